// The scattering function of a surface: a sum of lobes, stored by value.
//
// Directions (Veach 1997, section 3.7): `wo` points to where the path came from (towards the eye when radiance is
// traced) and `wi` to where it goes. Both point away from the surface and have unit length. `n` is the shading normal
// on the side of wo. Every lobe may have its own normal (bump per closure). The geometric normal `ng` is turned to wo's
// side. It decides what is reflection and what is transmission. A lobe is black if its normal disagrees with `ng` about
// the side of either direction, so no light leaks through the surface.
//
// Values: `f` excludes the cosine. `f_cos` is f(wo, wi) |cos(wi, n_lobe)|, summed over the lobes; transport needs this
// when lobes have their own normals. Densities are per solid angle. Specular (delta) lobes and transparency contribute
// zero to f, f_cos and the pdf. `sample` returns them with `specular` set, f_cos = weight, and pdf = the discrete
// probability of the choice. `sample` returns nothing if the random numbers give no valid direction (below the horizon,
// beyond the critical angle). Such a sample is part of the estimate and counts as zero.
//
// Directions can be swapped: evaluate(wi, wo) is valid for any pair, on either side. The density depends only on the
// two directions. The selection probabilities are those for the wo that is passed; they are cached for the wo that was
// given to `prepare`. So the density of the reverse step is evaluate(wi, wo).pdf_solid_angle, without a further factor.
//
// Refraction: as in Cycles, rays transport radiance divided by the square of the index of refraction (basic radiance).
// A boundary does not change it, so radiance is not scaled by 1/eta^2. Its adjoint, importance (photons), is scaled by
// 1/eta^2, where eta is the index of the side that is entered divided by the index of the side that is left. Images
// differ from physically correct ones, by eta^2, only if a light or the camera is inside the denser medium.
//
// Shading normals: importance needs the factor `shading_normal_correction` (Veach 1997, section 5.3). The importance
// f_cos is measured from the lobe's own normal and already contains all other factors, so f_cos times this one factor
// is exact for every lobe.
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
  MicrofiberSheen,    ///< upright fibres (Blender 4.x Principled)
  Velvet,             ///< Ashikhmin's velvet; `roughness` is its sigma
  ToonDiffuse,        ///< a cone around n; `alpha_x` is its size, `alpha_y` the width of its edge (radians)
  ToonGlossy,         ///< the same in a cone around the mirror direction
  PrincipledRetro,    ///< PrincipledDiffuse minus its value for roughness 0
  MicrofacetReflection,
  MicrofacetRefraction,  ///< transmission part only
  MicrofacetGlass,       ///< reflection and transmission; dielectric Fresnel chooses between them
  MicrofacetThin,        ///< transmission through a thin sheet: a reflection lobe, mirrored to the other side
  HairChiang,            ///< a fibre (hair.h)
  HairReflection,        ///< of the Hair BSDF
  HairTransmission,
  Transparent,  ///< straight through, no change of direction
  HairHuang     ///< a fibre with rough facets (huang.h)
};

constexpr bool is_diffuse(LobeKind kind) {
  return kind == LobeKind::Diffuse || kind == LobeKind::PrincipledDiffuse || kind == LobeKind::Translucent ||
         kind == LobeKind::Sheen || kind == LobeKind::MicrofiberSheen || kind == LobeKind::Velvet ||
         kind == LobeKind::ToonDiffuse || kind == LobeKind::PrincipledRetro;
}
constexpr bool is_microfacet(LobeKind kind) {
  return kind == LobeKind::MicrofacetReflection || kind == LobeKind::MicrofacetRefraction ||
         kind == LobeKind::MicrofacetGlass || kind == LobeKind::MicrofacetThin;
}
/// Whether the lobe is that of a fibre, whose value does not depend on the side of a normal.
constexpr bool is_fiber(LobeKind kind) {
  return kind == LobeKind::HairChiang || kind == LobeKind::HairReflection || kind == LobeKind::HairTransmission ||
         kind == LobeKind::HairHuang;
}
/// Whether the lobe scatters light to the other side, except straight through.
constexpr bool transmits(LobeKind kind) {
  return kind == LobeKind::Translucent || kind == LobeKind::MicrofacetRefraction || kind == LobeKind::MicrofacetGlass ||
         kind == LobeKind::MicrofacetThin || kind == LobeKind::HairChiang || kind == LobeKind::HairTransmission ||
         kind == LobeKind::HairHuang;
}

/// Whether the lobe scatters light back to the side from which it comes.
constexpr bool reflects(LobeKind kind) {
  return kind != LobeKind::Translucent && kind != LobeKind::MicrofacetRefraction && kind != LobeKind::MicrofacetThin &&
         kind != LobeKind::HairTransmission && kind != LobeKind::Transparent;
}

enum class Microfacet : uint8_t { Ggx, Beckmann, Gtr1, AshikhminShirley };
/// How the colour of a reflection lobe varies with the angle to the facet.
enum class FresnelKind : uint8_t {
  None,            ///< white; a glass lobe then splits light without a tint
  DielectricTint,  ///< from f0 to f90 as the exact dielectric curve of `eta` goes from its own f0 to 1
  Dielectric,      ///< exact dielectric curve of `eta`
  F82Tint,         ///< Schlick from f0 to white, minus a dip at 82 degrees with the coefficient f90 (fresnel::f82)
  Conductor        ///< exact curve of the complex index f0 + i f90
};
/// Blender 3.x splits glass by the Fresnel reflectance for the lobe's normal, 4.x by that for the facet's normal.
/// Thin sheets are always split there; they have the sum over all bounces inside the sheet.
enum class NormalFresnel : uint8_t { None, Reflected, Transmitted, ThinReflected, ThinTransmitted };

/// How a lobe compensates the energy that single scattering loses between facets.
enum class Compensation : uint8_t {
  None,
  Mixed,  ///< scales the lobe; with more roughness, adds a nearly diffuse part; close to Blender 3.x' random walk
  Scaled  ///< scales the lobe (Turquin 2019), as Blender 4.x does
};

enum LobeFlags : uint32_t {
  kReflection = 1,
  kTransmission = 2,
  kDiffuse = 4,
  kGlossy = 8,
  kSpecular = 16,
  kTransparent = 32,
  kPortal = 64  ///< this bit and those above it are the number of a portal's lobe, from 1; 0: no portal
};

/// A film on facets, in which light interferes (thin_film.h).
struct ThinFilm {
  float thickness = 0.0f;  ///< nanometres
  float ior = 1.33f;       ///< relative to the side from which light arrives
};

/// One lobe. The makers in closures.h create lobes and keep their invariants.
struct Lobe {
  LobeKind kind = LobeKind::Diffuse;
  Microfacet microfacet = Microfacet::Ggx;
  FresnelKind fresnel = FresnelKind::None;
  NormalFresnel normal_fresnel = NormalFresnel::None;  ///< factor: reflectance of `eta` at n (glass: split there)
  Compensation compensation = Compensation::None;      ///< its colour is `multiple_scattering`
  bool ignores_eye = false;         ///< diffuse: the eye may be behind the normal, which is not bent to it; fibres
  bool correlated = false;          ///< masking and shadowing depend on each other (Blender 4.0 and later)
  bool delta = false;               ///< value of is_delta(), set by Bsdf::add
  bool subsurface = false;          ///< represents light that enters here and leaves elsewhere (SubsurfaceMedium)
  bool portal = false;              ///< Transparent: the ray goes on from the place f0 in the direction f90
  bool thin_wall = false;           ///< Transparent: light that a smooth thin sheet transmits
  uint8_t layers = 0;               ///< bit mask of the Bsdf's layers that are above the lobe
  Color weight{0.0f};               ///< product of all mix factors and the closure's colour
  Color f0{1.0f}, f90{1.0f};        ///< reflectance of facets; f0 of rough Diffuse: colour of multiple scattering
  Color transmission_tint{1.0f};    ///< glass: colour of the transmitted light
  Color multiple_scattering{1.0f};  ///< reflectance of all bounces after the first, taken together
  Color mean_fresnel{1.0f};  ///< reflectance of the first bounce, for the part of the light that loses its direction
  float alpha_x = 1.0f, alpha_y = 1.0f;  ///< microfacet roughness (already squared)
  float roughness = 0.0f;                ///< Oren-Nayar sigma, sheen and principled diffuse roughness
  float eta = 1.0f;                      ///< relative index of refraction: transmitted side over incident side
  ThinFilm film;                         ///< on the facets, for light from wo's side
  float selection = 0.0f;                ///< probability that the lobe is sampled; set by Bsdf::prepare
  Frame frame;                           ///< n: the lobe's normal on wo's side; s: the tangent of anisotropy
  bool is_delta() const;
};

/// A coating whose albedo dims the lobes below it (Blender 4.x Principled). Its factor is 1 - albedo(eye direction),
/// times the absorption along the refracted ray. The makers multiply it into the weights of the lobes below, for their
/// wo. The Bsdf uses it again for importance, where the eye is at wi, and for other directions (turn_to).
struct Layer {
  Lobe lobe;                ///< with its weight
  float tint_share = 0.0f;  ///< fraction of the area that is tinted
  Color tint{1.0f};         ///< transmittance at normal incidence
  Color in_weights{1.0f};   ///< the transmittance that the weights of the lobes below contain
  /// A normal that leans away from the eye is seen from its horizon. `ng`: of the surface.
  Color transmittance(Vec3 ng, Vec3 eye) const;
};

/// The direction in which light enters a surface with subsurface scattering.
enum class SubsurfaceEntry : uint8_t {
  Diffuse,    ///< proportional to the cosine (Blender 3.x)
  Refracted,  ///< refracted by a GGX facet
  Mixed       ///< either, with equal probabilities
};

/// The medium below a surface that has a `subsurface` lobe. Lengths are in metres.
struct SubsurfaceMedium {
  Color albedo{0.0f};          ///< albedo of the surface for uniform light from all directions
  Color radius{0.0f};          ///< mean free path; of the reduced medium unless `van_de_hulst`
  float anisotropy = 0.0f;     ///< mean cosine of scattering
  bool fresnel = false;        ///< light is dimmed at grazing angles where it leaves (Principled of Blender 3.x)
  bool profile = false;        ///< light leaves by a profile (subsurface_profile.h), `radius` is its width
  bool van_de_hulst = false;   ///< how the single scattering albedo follows from `albedo` (walk_medium)
  bool after_diffuse = false;  ///< light enters after a diffuse bounce as well (Blender 5.0 and later)
  SubsurfaceEntry entry = SubsurfaceEntry::Diffuse;
  float eta = 1.4f, alpha = 0.0f;  ///< of the boundary that refracts: index of refraction, roughness of GGX
};

struct BsdfSample {
  Vec3 wi;                ///< of a portal: straight on, see Bsdf::portal
  Color f_cos;            ///< sum over all lobes that share the density, multiplied by |cos|
  float pdf_solid_angle;  ///< of all these lobes together; the discrete probability if specular
  uint32_t flags;         ///< LobeFlags of the sampled lobe
  bool specular;
  float eta = 1.0f;        ///< relative index along the refracted direction; 1 for reflection
  float roughness = 1.0f;  ///< sqrt(alpha) of the sampled lobe; 1 for diffuse
};

/// Whether two delta events scatter into the same direction, up to rounding.
bool is_same_specular_direction(const BsdfSample& a, const BsdfSample& b);

class Bsdf {
 public:
  static constexpr int kMaxLobes = 12, kMaxLayers = 6;

  Vec3 ng{0, 0, 1};                                        ///< geometric normal on wo's side
  Vec3 n{0, 0, 1};                                         ///< shading normal of the surface, on wo's side
  Vec3 bump_base{0, 0, 1};                                 ///< n, but not bent towards the eye
  BumpTerminator bump_terminator = BumpTerminator::Cubic;  ///< for diffuse lobes with other normals than n
  Color channel_weights{1.0f};                             ///< of the channels in the choice of a lobe

  Bsdf() = default;
  Bsdf(const Bsdf& other) { *this = other; }
  Bsdf& operator=(const Bsdf& other);

  /// Removes all lobes and sets the normals, both on wo's side.
  void start(Vec3 geometric_normal, Vec3 shading_normal) {
    ng = geometric_normal;
    n = bump_base = shading_normal;
    channel_weights = Color(1.0f);
    count_ = layer_count_ = 0;
    dropped_ = 0;
    has_non_delta_ = single_lambert_ = has_subsurface_ = bound_to_view_ = transmits_ = false;
    receiving_normal_ = shading_normal;
  }
  /// Makes the surface a single Lambert lobe around n. Call it after start. The result is that of add and prepare, at a
  /// lower cost.
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

  /// Adds a lobe. Lobes with black or non-finite weights are ignored. If the storage is full, the new lobe replaces the
  /// weakest one and `dropped_lobes` counts it.
  void add(const Lobe& lobe);
  /// Returns the bit by which the lobes below refer to this layer. Returns 0 if there is no space; importance then uses
  /// the factor for wo.
  uint8_t add_layer(const Layer& layer);
  /// Takes the lobes of `other` for which `wanted(lobe)` is true, with its normals and all its layers. Call `prepare`
  /// afterwards.
  template <class Wanted>
  void assign_lobes(const Bsdf& other, Wanted&& wanted) {
    ng = other.ng;
    n = other.n;
    bump_base = other.bump_base;
    channel_weights = other.channel_weights;
    count_ = 0;
    has_subsurface_ = other.has_subsurface_;
    bound_to_view_ = other.bound_to_view_ || other.dropped_ > 0;
    layer_count_ = other.layer_count_;
    std::memcpy(layer_bytes_, other.layer_bytes_, size_t(layer_count_) * sizeof(Layer));
    for (int i = 0; i < other.count_; ++i)
      if (wanted(other.lobe(i)))
        std::memcpy(lobe_bytes_ + size_t(count_++) * sizeof(Lobe), other.lobe_bytes_ + size_t(i) * sizeof(Lobe),
                    sizeof(Lobe));
  }
  /// Computes the selection probabilities for this wo. Call it once, after the last `add`.
  void prepare(Vec3 wo);

  /// From now on, only the makers can make the lobes for another direction than that of `prepare`: a normal was bent
  /// towards it, or light from it does not reach a lobe.
  void bind_to_view() { bound_to_view_ = true; }
  /// Whether the lobes that the makers would make for `wo` follow from these: layers dim the light of a lobe by another
  /// factor, and nothing else is different. Not for shaders that use the direction (ShaderProgram::view_dependence).
  bool can_turn_to(Vec3 wo) const;
  /// Makes the lobes those for `wo`. Needs can_turn_to(wo).
  void turn_to(Vec3 wo);

  struct Evaluation {
    Color f_cos;
    float pdf_solid_angle;
  };
  Evaluation evaluate(Vec3 wo, Vec3 wi, TransportMode mode = TransportMode::Radiance) const {
    return single_lambert_ ? evaluate_lambert(wo, wi) : sum_lobes<true>(wo, wi, mode);
  }
  Color f(Vec3 wo, Vec3 wi, TransportMode mode = TransportMode::Radiance) const;
  /// Scattering between two directions, for the densities of walks from both ends.
  struct PairEvaluation {
    Color f_cos{0.0f};  ///< with the cosine of to_light
    float pdf_to_light = 0.0f, pdf_to_eye = 0.0f;
  };
  /// evaluate(to_eye, to_light) and the density of evaluate(to_light, to_eye). If `turns`, each is that of the lobes
  /// that are turned to its first argument; then can_turn_to must hold for both directions, or they are that of
  /// `prepare`.
  PairEvaluation evaluate_pair(Vec3 to_eye, Vec3 to_light, bool turns) const;
  /// f_cos for a wi that n and ng see on different sides, where n decides between reflection and transmission. For
  /// radiance only; such directions are never sampled (transport/paths/shadow_terminator.h). Black for all other wi.
  Color evaluate_beyond_horizon(Vec3 wo, Vec3 wi) const;
  float pdf_solid_angle(Vec3 wo, Vec3 wi) const { return evaluate(wo, wi).pdf_solid_angle; }
  std::optional<BsdfSample> sample(Vec3 wo, float u_lobe, Vec2 u, TransportMode mode = TransportMode::Radiance) const {
    return single_lambert_ ? sample_lambert(wo, u) : sample_lobes(wo, u_lobe, u, mode);
  }

  /// Removes the Transparent lobes, for walks that decide by themselves to pass straight through surfaces. Calls
  /// `prepare`.
  void remove_transparency(Vec3 wo);
  /// The delta lobes (without transparency) that scatter wo into wi, up to rounding: the sum of their weights, and the
  /// probability that `sample` chooses one of them. `follow_probability` is the probability of `follow_specular`. The
  /// side of wi decides between reflection and transmission.
  struct SpecularEvaluation {
    Color weight{0.0f};
    float probability = 0.0f, follow_probability = 0.0f;
    float eta = 1.0f;  ///< as in BsdfSample
  };
  SpecularEvaluation evaluate_specular(Vec3 wo, Vec3 wi, TransportMode mode = TransportMode::Radiance) const;
  /// The directions into which delta lobes (without transparency) scatter wo, up to kMaxSpecularDirections. Returns
  /// their number. Lobes of equal direction are one event: f_cos is the sum of their weights, pdf_solid_angle is the
  /// probability that `sample` chooses one of them, and the other members are those of the first lobe.
  static constexpr int kMaxSpecularDirections = 8;
  int specular_directions(Vec3 wo, std::array<BsdfSample, kMaxSpecularDirections>& events) const;
  /// Like `sample`, but restricted to delta lobes that reflect (or transmit). A perturbed path keeps the type of its
  /// bounce.
  std::optional<BsdfSample> follow_specular(Vec3 wo, bool transmitted, float u_lobe,
                                            TransportMode mode = TransportMode::Radiance) const;

  /// Shares of the kinds of lobes in the probability of scattering from wo to wi (of the delta lobes if `specular`).
  /// Their sum is 1.
  struct KindShares {
    float diffuse = 0.0f, glossy = 0.0f, transmission = 0.0f, diffuse_transmission = 0.0f;
  };
  KindShares kind_shares(Vec3 wo, Vec3 wi, bool specular) const;

  /// The value of `evaluate`, divided by kind as in Blender's passes: diffuse (with translucent), glossy, transmission.
  std::array<Color, 3> f_cos_of_kinds(Vec3 wo, Vec3 wi) const;
  /// The value of `albedo`, divided in the same way.
  std::array<Color, 3> albedo_of_kinds() const;

  Color transparency() const;  ///< sum of the weights of the Transparent lobes
  /// Whether all light passes straight on.
  bool is_clear() const {
    for (int i = 0; i < lobe_count(); ++i)
      if (lobe(i).kind != LobeKind::Transparent) return false;
    return lobe_count() > 0;
  }
  /// Whether at least half of the light that passes straight on is transmitted by smooth thin sheets.
  bool passes_thin_wall() const;
  struct Portal {
    Vec3 position, direction;
  };
  /// Where a ray goes on after a sample that has the flag kPortal.
  Portal portal(const BsdfSample& sample) const {
    const Lobe& lobe = lobes()[sample.flags / kPortal - 1];
    return {lobe.f0, lobe.f90};
  }
  Color albedo() const;           ///< estimate of the fraction that is reflected or transmitted, without transparency
  Color albedo_of_sharp() const;  ///< the part of `albedo` that comes from nearly mirror-like lobes
  bool has_non_delta() const { return has_non_delta_; }
  /// Whether lobes that are not delta scatter light to the other side. Valid after `prepare`.
  bool transmits_light() const { return transmits_; }
  bool has_subsurface() const { return has_subsurface_; }
  /// All subsurface lobes together: weight, normal of the first one, probability of being chosen. Valid after
  /// `prepare`.
  struct SubsurfacePart {
    Color weight{0.0f};
    Vec3 normal{0.0f};
    float selection = 0.0f;
  };
  SubsurfacePart subsurface_part() const;
  /// Removes the subsurface lobes, for walks that decide by themselves to enter the surface. Calls `prepare`.
  void remove_subsurface(Vec3 wo);
  /// The normal for the irradiance by which lights are chosen; 0 if light can arrive from all directions. Valid after
  /// `prepare`.
  Vec3 receiving_normal() const { return receiving_normal_; }
  bool empty() const { return count_ == 0; }
  int lobe_count() const { return count_; }
  const Lobe& lobe(int i) const { return lobes()[i]; }
  int layer_count() const { return layer_count_; }
  uint32_t dropped_lobes() const { return dropped_; }

 private:
  /// Whether the lobe is diffuse with a normal other than that of the surface.
  bool is_bumped(const Lobe& lobe) const;
  // The storage is not initialised. Construction and copies touch only the lobes in use.
  Lobe* lobes() { return reinterpret_cast<Lobe*>(lobe_bytes_); }
  const Lobe* lobes() const { return reinterpret_cast<const Lobe*>(lobe_bytes_); }
  Layer* layers() { return reinterpret_cast<Layer*>(layer_bytes_); }
  const Layer* layers() const { return reinterpret_cast<const Layer*>(layer_bytes_); }
  void select(Vec3 wo, float (&selection)[kMaxLobes]) const;
  template <class Factor>
  void select(Vec3 wo, float (&selection)[kMaxLobes], const Factor& factor) const;
  /// What differs for another direction than that of `prepare`.
  struct Turned {
    bool other_selection = false, other_weights = false;
    float selection[kMaxLobes];
    Color factors[kMaxLobes];  ///< of the weights
  };
  void turn(Vec3 wo, bool with_layers, Turned& turned) const;
  /// The factors of the weights of all lobes in which layers for `wo` differ.
  void layers_for(Vec3 wo, Color (&factors)[kMaxLobes]) const;
  float selection_for(int i, const float* recomputed) const {
    return recomputed ? recomputed[i] : lobes()[i].selection;
  }
  /// The most common surface, evaluated without a loop over lobes.
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
  bool bound_to_view_ = false, transmits_ = false;
  Vec3 prepared_wo_{0.0f}, receiving_normal_{0.0f};
  alignas(Lobe) unsigned char lobe_bytes_[kMaxLobes * sizeof(Lobe)];
  alignas(Layer) unsigned char layer_bytes_[kMaxLayers * sizeof(Layer)];
};

/// The lobes for `wo`. Needs bsdf.can_turn_to(wo).
inline Bsdf turned_to(const Bsdf& bsdf, Vec3 wo) {
  Bsdf turned = bsdf;
  turned.turn_to(wo);
  return turned;
}

/// Factor on f_cos for importance at surfaces with shading normals (Veach 1997, eq. 5.19): |wo.ns| |wi.ng| / (|wo.ng|
/// |wi.ns|).
float shading_normal_correction(const Bsdf& bsdf, Vec3 wo, Vec3 wi);

}  // namespace ajar
