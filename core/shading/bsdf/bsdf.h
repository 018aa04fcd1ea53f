// How a surface scatters light: a sum of lobes, kept by value.
//
// Conventions (Veach 1997, section 3.7): `wo` points to where the path came from
// (the eye side when tracing radiance), `wi` to where it goes; both point away from
// the surface and have unit length. `n` is the shading normal on the side of wo; every
// lobe may have its own (bump per closure). The geometric normal `ng`, turned
// to wo's side, decides what is reflection and what transmission; where a lobe's normal disagrees
// with it about either direction the lobe is black, so no light leaks through.
//
// Values: `f` excludes the cosine; `f_cos` is f(wo, wi) |cos(wi, n_lobe)| summed over lobes,
// which is what transport needs when lobes have their own normals. Densities are per solid angle.
// Specular (delta) lobes and transparency contribute zero to f, f_cos and pdf; `sample` returns them with
// `specular` set, f_cos = weight, and pdf = the discrete probability of having chosen them.
// sample returns nothing when the random numbers lead nowhere (below the horizon, beyond the critical angle); that
// is part of the estimate and counts as zero.
//
// Directions may be swapped: evaluate(wi, wo) holds for any pair, on either side. The density depends on its two
// directions only: selection probabilities are those for the wo passed (cached for the one given to `prepare`), so
// the density of the reverse step is evaluate(wi, wo).pdf_solid_angle, nothing else.
//
// Refraction. As in Cycles, what is transported along rays is radiance divided by the square of the index of refraction
// (basic radiance), which a boundary passes on unchanged: Radiance is not scaled by 1/eta^2. Its adjoint is:
// Importance (particles) is scaled by 1/eta^2, eta being the index of the side entered over that of the side left.
// Pictures differ from the physical ones only when a light or the camera is inside the denser medium, by eta^2. Shading
// normals: see `shading_normal_correction` for importance (Veach section 5.3). Measured from the lobe's own normal,
// importance f_cos already contains what is needed for f_cos times that one factor to be exact for every lobe.
#pragma once

#include <array>
#include <cstring>
#include <optional>

#include "description/bump_terminator.h"
#include "math/frame.h"
#include "math/types.h"

namespace ajar {

enum class TransportMode : uint8_t { Radiance, Importance };

enum class LobeKind : uint8_t {
  Diffuse,            ///< Lambert; Oren-Nayar when roughness > 0
  PrincipledDiffuse,  ///< Disney diffuse with retro-reflection (Blender 3.x Principled)
  Translucent,        ///< Lambert on the other side
  Sheen,              ///< Disney sheen (Blender 3.x Principled)
  MicrofiberSheen,    ///< fibres standing on the surface (Blender 4.x Principled)
  Velvet,             ///< Ashikhmin's velvet; `roughness` is its sigma
  ToonDiffuse,        ///< a cone around n; `alpha_x` and `alpha_y` are its size and the width of its edge, in radians
  ToonGlossy,         ///< the same around the mirror direction
  PrincipledRetro,    ///< what PrincipledDiffuse has beyond its value without roughness
  MicrofacetReflection,
  MicrofacetRefraction,  ///< transmission part only
  MicrofacetGlass,       ///< reflection and transmission, chosen by dielectric Fresnel
  Transparent,           ///< straight through, no change of direction
};

enum class Microfacet : uint8_t { Ggx, Beckmann, Gtr1, AshikhminShirley };
/// How the colour of a reflection lobe varies with the angle to the facet.
enum class FresnelKind : uint8_t {
  None,            ///< white; a glass lobe then splits without colouring
  DielectricTint,  ///< from f0 to f90 as far as the exact dielectric curve of `eta` is from its own f0 to 1
  Dielectric,      ///< exact dielectric curve of `eta`
  F82Tint          ///< Schlick from f0 to white, less the coefficient f90 at 82 degrees (fresnel::f82)
};
/// Blender 3.x splits glass by the reflectance at the lobe's normal, 4.x at the facet's.
enum class NormalFresnel : uint8_t { None, Reflected, Transmitted };

/// How the light that single scattering loses between facets is put back.
enum class Compensation : uint8_t {
  None,
  Mixed,  ///< by scaling the lobe, and the rougher the more as a nearly diffuse part; near Blender 3.x' random walk
  Scaled  ///< by scaling the lobe (Turquin 2019), as Blender 4.x does
};

enum LobeFlags : uint32_t {
  kReflection = 1,
  kTransmission = 2,
  kDiffuse = 4,
  kGlossy = 8,
  kSpecular = 16,
  kTransparent = 32
};

/// One lobe. Fill it through the makers in closures.h, which keep its invariants.
struct Lobe {
  LobeKind kind = LobeKind::Diffuse;
  Microfacet microfacet = Microfacet::Ggx;
  FresnelKind fresnel = FresnelKind::None;
  NormalFresnel normal_fresnel = NormalFresnel::None;  ///< factor by the reflectance of `eta` at n (glass: split there)
  Compensation compensation = Compensation::None;      ///< coloured by `multiple_scattering`
  bool delta = false;                                  ///< is_delta(), set by Bsdf::add
  bool subsurface = false;  ///< stands for light that enters here and leaves elsewhere (SubsurfaceMedium)
  uint8_t layers = 0;       ///< which of the Bsdf's layers lie above, as bits
  Color weight{0.0f};       ///< product of all mix factors and the closure's colour
  Color f0{1.0f}, f90{1.0f};
  Color transmission_tint{1.0f};         ///< glass: colour of what is transmitted
  Color multiple_scattering{1.0f};       ///< reflectance of all bounces after the first together
  Color mean_fresnel{1.0f};              ///< reflectance of the first bounce where it has lost its direction
  float alpha_x = 1.0f, alpha_y = 1.0f;  ///< microfacet roughness (already squared)
  float roughness = 0.0f;                ///< Oren-Nayar sigma, sheen and principled diffuse roughness
  float eta = 1.0f;                      ///< index of refraction, transmitted over incident side
  float selection = 0.0f;                ///< probability of being sampled; set by Bsdf::prepare
  Frame frame;                           ///< n: the lobe's normal on wo's side; s: tangent of anisotropy
  bool is_delta() const;
};

/// A coating whose albedo dims what lies below it (Blender 4.x Principled): factor 1 - albedo(eye direction), and
/// absorption along the refracted ray. The makers multiply it into the weights of the lobes below for their wo; the
/// Bsdf needs it again only for importance, where the eye is at wi.
struct Layer {
  Lobe lobe;                ///< its weight included
  float tint_share = 0.0f;  ///< of the area that is tinted
  Color tint{1.0f};         ///< transmittance at normal incidence
  Color transmittance(Vec3 eye) const;
};

/// What is below a surface with a `subsurface` lobe. Lengths in metres.
struct SubsurfaceMedium {
  Color albedo{0.0f};       ///< of the surface, for light that comes from all around
  Color radius{0.0f};       ///< mean free path
  float anisotropy = 0.0f;  ///< mean cosine of scattering, in [0, 0.9]
  bool fresnel = false;     ///< dimmed at grazing angles on the way in and out (Principled)
};

struct BsdfSample {
  Vec3 wi;
  Color f_cos;            ///< of all lobes that share the density, already times |cos|
  float pdf_solid_angle;  ///< of all of them; discrete probability when specular
  uint32_t flags;         ///< LobeFlags of the lobe sampled
  bool specular;
  float eta = 1.0f;        ///< relative index along the refracted direction, 1 for reflection
  float roughness = 1.0f;  ///< sqrt(alpha) of the lobe sampled, 1 for diffuse
};

/// Whether two delta events turn the same direction to the same one, up to rounding.
bool is_same_specular_direction(const BsdfSample& a, const BsdfSample& b);

class Bsdf {
 public:
  static constexpr int kMaxLobes = 12, kMaxLayers = 6;

  Vec3 ng{0, 0, 1};                                        ///< geometric normal on wo's side
  Vec3 n{0, 0, 1};                                         ///< shading normal of the surface, on wo's side
  BumpTerminator bump_terminator = BumpTerminator::Cubic;  ///< of diffuse lobes around other normals than n

  Bsdf() = default;
  Bsdf(const Bsdf& other) { *this = other; }
  Bsdf& operator=(const Bsdf& other);

  /// Forget all lobes and begin again with these normals, both on wo's side.
  void start(Vec3 geometric_normal, Vec3 shading_normal) {
    ng = geometric_normal;
    n = shading_normal;
    count_ = layer_count_ = 0;
    dropped_ = 0;
    has_non_delta_ = single_lambert_ = has_subsurface_ = false;
    receiving_normal_ = shading_normal;
  }
  /// After start: the whole surface is one Lambert lobe around n. The same as add and prepare, without their work.
  void set_lambert(Color weight, Vec3 wo) {
    if (!(max_component(weight) > 0.0f)) return;
    Lobe* lobe = new (lobes()) Lobe;
    lobe->weight = weight;
    lobe->selection = 1.0f;
    lobe->frame = Frame(n);
    count_ = 1;
    has_non_delta_ = single_lambert_ = true;
    prepared_wo_ = wo;
  }

  /// Add a lobe; black or non-finite weights are ignored. When storage is full the
  /// weakest lobe makes room and `dropped_lobes` counts it.
  void add(const Lobe& lobe);
  /// Returns the bit by which lobes below name this layer; 0 when there is no room (importance then takes the dimming
  /// for wo as it is).
  uint8_t add_layer(const Layer& layer);
  /// Become the lobes of `other` that `wanted(lobe)` selects, with its normals and all its layers. Prepare afterwards.
  template <class Wanted>
  void assign_lobes(const Bsdf& other, Wanted&& wanted) {
    ng = other.ng;
    n = other.n;
    count_ = 0;
    has_subsurface_ = other.has_subsurface_;
    layer_count_ = other.layer_count_;
    std::memcpy(layer_bytes_, other.layer_bytes_, size_t(layer_count_) * sizeof(Layer));
    for (int i = 0; i < other.count_; ++i)
      if (wanted(other.lobe(i)))
        std::memcpy(lobe_bytes_ + size_t(count_++) * sizeof(Lobe), other.lobe_bytes_ + size_t(i) * sizeof(Lobe),
                    sizeof(Lobe));
  }
  /// Compute selection probabilities for this wo. Call once after the last add.
  void prepare(Vec3 wo);

  struct Evaluation {
    Color f_cos;
    float pdf_solid_angle;
  };
  Evaluation evaluate(Vec3 wo, Vec3 wi, TransportMode mode = TransportMode::Radiance) const {
    return single_lambert_ ? evaluate_lambert(wo, wi) : sum_lobes<true>(wo, wi, mode);
  }
  Color f(Vec3 wo, Vec3 wi, TransportMode mode = TransportMode::Radiance) const;
  /// f_cos for a wi that n and ng see on different sides, reflection and transmission told apart by n: radiance only,
  /// never sampled (transport/paths/shadow_terminator.h). Black for all other wi.
  Color evaluate_beyond_horizon(Vec3 wo, Vec3 wi) const;
  float pdf_solid_angle(Vec3 wo, Vec3 wi) const { return evaluate(wo, wi).pdf_solid_angle; }
  std::optional<BsdfSample> sample(Vec3 wo, float u_lobe, Vec2 u, TransportMode mode = TransportMode::Radiance) const {
    return single_lambert_ ? sample_lambert(wo, u) : sample_lobes(wo, u_lobe, u, mode);
  }

  /// Forget the Transparent lobes, for walks that pass straight through surfaces by a choice of their own. Calls
  /// prepare.
  void remove_transparency(Vec3 wo);
  /// Delta lobes (without transparency) that turn wo into wi, up to rounding: their weights and the probability that
  /// `sample` takes one of them; `follow_probability` is that of `follow_specular`. Reflection and transmission are
  /// told apart by wi.
  struct SpecularEvaluation {
    Color weight{0.0f};
    float probability = 0.0f, follow_probability = 0.0f;
    float eta = 1.0f;  ///< as in BsdfSample
  };
  SpecularEvaluation evaluate_specular(Vec3 wo, Vec3 wi, TransportMode mode = TransportMode::Radiance) const;
  /// Directions in which delta lobes (without transparency) turn wo, up to kMaxSpecularDirections of them; returns how
  /// many. Lobes of one direction are one event: f_cos their weights, pdf_solid_angle the probability that `sample`
  /// takes one of them, the rest of the first.
  static constexpr int kMaxSpecularDirections = 8;
  int specular_directions(Vec3 wo, std::array<BsdfSample, kMaxSpecularDirections>& events) const;
  /// Like sample, but only delta lobes that reflect (or transmit): a path that is perturbed keeps its kind of bounce.
  std::optional<BsdfSample> follow_specular(Vec3 wo, bool transmitted, float u_lobe,
                                            TransportMode mode = TransportMode::Radiance) const;

  /// Shares of the kinds of lobes in the probability of going from wo to wi (of the delta lobes when `specular`), sum
  /// 1.
  struct KindShares {
    float diffuse = 0.0f, glossy = 0.0f, transmission = 0.0f, diffuse_transmission = 0.0f;
  };
  KindShares kind_shares(Vec3 wo, Vec3 wi, bool specular) const;

  /// What `evaluate` gives, by kind as Blender's passes have it: diffuse (translucent included), glossy, transmission.
  std::array<Color, 3> f_cos_of_kinds(Vec3 wo, Vec3 wi) const;
  /// The same of albedo().
  std::array<Color, 3> albedo_of_kinds() const;

  /// Splits for passes and for shadow rays.
  Color transparency() const;  ///< sum of the Transparent lobes' weights
  Color albedo() const;        ///< estimate of the reflected and transmitted fraction, without transparency
  bool has_non_delta() const { return has_non_delta_; }
  bool has_subsurface() const { return has_subsurface_; }
  /// The subsurface lobes together: weight, normal of the first, and probability of being chosen. After prepare.
  struct SubsurfacePart {
    Color weight{0.0f};
    Vec3 normal{0.0f};
    float selection = 0.0f;
  };
  SubsurfacePart subsurface_part() const;
  /// Forget the subsurface lobes, for walks that choose by themselves whether to enter. Calls prepare.
  void remove_subsurface(Vec3 wo);
  /// The normal by which light that arrives counts, for choosing lights; 0 when it may come from all around. After
  /// prepare.
  Vec3 receiving_normal() const { return receiving_normal_; }
  bool empty() const { return count_ == 0; }
  int lobe_count() const { return count_; }
  const Lobe& lobe(int i) const { return lobes()[i]; }
  int layer_count() const { return layer_count_; }
  uint32_t dropped_lobes() const { return dropped_; }

 private:
  // Storage is not initialised: constructing and copying cost only the lobes in use.
  Lobe* lobes() { return reinterpret_cast<Lobe*>(lobe_bytes_); }
  const Lobe* lobes() const { return reinterpret_cast<const Lobe*>(lobe_bytes_); }
  Layer* layers() { return reinterpret_cast<Layer*>(layer_bytes_); }
  const Layer* layers() const { return reinterpret_cast<const Layer*>(layer_bytes_); }
  void select(Vec3 wo, float (&selection)[kMaxLobes]) const;
  float selection_for(int i, const float* recomputed) const {
    return recomputed ? recomputed[i] : lobes()[i].selection;
  }
  /// The commonest surface of all, without a loop over lobes.
  Evaluation evaluate_lambert(Vec3 wo, Vec3 wi) const {
    const float cos_o = glm::dot(n, wo), cos_i = glm::dot(n, wi);
    const float side_o = glm::dot(ng, wo), side_i = glm::dot(ng, wi);
    if (!(cos_o * side_o > 0.0f && cos_i * side_i > 0.0f && side_o * side_i > 0.0f)) return {Color(0.0f), 0.0f};
    const float pdf = std::abs(cos_i) * kInvPi;
    return {lobes()[0].weight * pdf, pdf};
  }
  std::optional<BsdfSample> sample_lambert(Vec3 wo, Vec2 u) const;
  std::optional<BsdfSample> sample_lobes(Vec3 wo, float u_lobe, Vec2 u, TransportMode mode) const;
  float importance_factor(const Lobe& lobe, Vec3 wo, Vec3 wi) const;
  Color layer_factor(const Lobe& lobe, Vec3 wo, Vec3 wi) const;
  template <class Wanted>
  void keep_lobes(Vec3 wo, Wanted&& wanted);
  template <class F>
  void for_each_specular(Vec3 wo, TransportMode mode, F&& visit) const;
  template <bool kWithCosine>
  Evaluation sum_lobes(Vec3 wo, Vec3 wi, TransportMode mode) const;

  int count_ = 0;
  int layer_count_ = 0;
  uint32_t dropped_ = 0;
  bool has_non_delta_ = false;
  bool single_lambert_ = false;
  bool has_subsurface_ = false;
  Vec3 prepared_wo_{0.0f}, receiving_normal_{0.0f};
  alignas(Lobe) unsigned char lobe_bytes_[kMaxLobes * sizeof(Lobe)];
  alignas(Layer) unsigned char layer_bytes_[kMaxLayers * sizeof(Layer)];
};

/// Factor on f_cos when importance is carried through shading normals
/// (Veach 1997, eq. 5.19): |wo.ns| |wi.ng| / (|wo.ng| |wi.ns|).
float shading_normal_correction(const Bsdf& bsdf, Vec3 wo, Vec3 wi);

}  // namespace ajar
