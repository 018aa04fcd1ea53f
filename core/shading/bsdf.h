// How a surface scatters light: a sum of lobes, kept by value.
//
// Conventions (Veach 1997, section 3.7): `wo` points to where the path came from
// (the eye side when tracing radiance), `wi` to where it goes; both point away from
// the surface and have unit length. `n` is the shading normal on the side of wo; every
// lobe may have its own (bump per closure). The geometric normal `ng`, turned
// to wo's side, decides what is reflection and what transmission.
// Values: `f` excludes the cosine; `f_cos` is f(wo, wi) |cos(wi, n_lobe)| summed over lobes,
// which is what transport needs when lobes have their own normals. Densities are per solid angle.
// Specular (delta) lobes and transparency contribute zero to f, f_cos and pdf; `sample` returns them with
// `specular` set, f_cos = weight, and pdf = the discrete probability of having chosen them.
// Refraction scales radiance by 1/eta^2 (Veach section 5.2) and importance not at all.
// Shading normals: see `shading_normal_correction` for importance (Veach section 5.3).
#pragma once

#include <optional>

#include "math/frame.h"
#include "math/types.h"

namespace ajar {

enum class TransportMode : uint8_t { Radiance, Importance };

enum class LobeKind : uint8_t {
  Diffuse,             ///< Lambert; Oren-Nayar when roughness > 0
  PrincipledDiffuse,   ///< Disney diffuse with retro-reflection (Blender 3.x Principled)
  Translucent,         ///< Lambert on the other side
  Sheen,               ///< principled sheen (Blender 3.x); microfiber sheen (4.x) by `model`
  MicrofacetReflection,   ///< GGX or Beckmann
  MicrofacetRefraction,   ///< transmission part only
  MicrofacetGlass,        ///< reflection and transmission, chosen by dielectric Fresnel
  Transparent,         ///< straight through, no change of direction
};

enum class Microfacet : uint8_t { Ggx, Beckmann };
/// How the colour of a reflection lobe varies with angle.
enum class FresnelKind : uint8_t {
  None,               ///< constant
  SchlickF0F90,       ///< f0 to f90 by Schlick's curve
  DielectricTint,     ///< Blender 3.x Principled: f0 scaled by the exact dielectric curve of `eta`
  Dielectric,         ///< exact dielectric curve of `eta` times the weight
  F82Tint             ///< 4.x Principled metal: Schlick with an edge tint at 82 degrees
};

enum LobeFlags : uint32_t {
  kReflection = 1, kTransmission = 2,
  kDiffuse = 4, kGlossy = 8, kSpecular = 16, kTransparent = 32
};

/// One lobe. Fill it through the makers in closures.h, which keep its invariants.
struct Lobe {
  LobeKind kind = LobeKind::Diffuse;
  Microfacet microfacet = Microfacet::Ggx;
  FresnelKind fresnel = FresnelKind::None;
  bool backfacing_eta = false;      ///< the ray is inside: eta has been inverted already
  Color weight{0.0f};               ///< product of all mix factors and the closure's colour
  Color f0{1.0f}, f90{1.0f};
  float alpha_x = 1.0f, alpha_y = 1.0f;  ///< microfacet roughness (already squared)
  float roughness = 0.0f;           ///< Oren-Nayar sigma, sheen and principled diffuse roughness
  float eta = 1.0f;                 ///< index of refraction, transmitted over incident side
  float energy_scale = 1.0f;        ///< multiple-scattering compensation
  float selection = 0.0f;           ///< probability of being sampled; set by Bsdf::prepare
  Frame frame;                      ///< n: the lobe's normal on wo's side; s: tangent of anisotropy
  bool is_delta() const;
};

struct BsdfSample {
  Vec3 wi;
  Color f_cos;                      ///< of all lobes that share the density, already times |cos|
  float pdf_solid_angle;            ///< of all of them; discrete probability when specular
  uint32_t flags;                   ///< LobeFlags of the lobe sampled
  bool specular;
  float eta = 1.0f;                 ///< relative index along the refracted direction, 1 for reflection
  float roughness = 1.0f;           ///< sqrt(alpha) of the lobe sampled, 1 for diffuse
};

class Bsdf {
 public:
  static constexpr int kMaxLobes = 12;

  Vec3 ng{0, 0, 1};                 ///< geometric normal on wo's side
  Vec3 n{0, 0, 1};                  ///< shading normal of the surface, on wo's side

  /// Add a lobe; black or non-finite weights are ignored. When storage is full the
  /// weakest lobe makes room and `dropped_lobes` counts it.
  void add(const Lobe& lobe);
  /// Compute selection probabilities for this wo. Call once after the last add.
  void prepare(Vec3 wo);

  struct Evaluation {
    Color f_cos;
    float pdf_solid_angle;
  };
  Evaluation evaluate(Vec3 wo, Vec3 wi, TransportMode mode = TransportMode::Radiance) const;
  Color f(Vec3 wo, Vec3 wi, TransportMode mode = TransportMode::Radiance) const;
  float pdf_solid_angle(Vec3 wo, Vec3 wi) const { return evaluate(wo, wi).pdf_solid_angle; }
  std::optional<BsdfSample> sample(Vec3 wo, float u_lobe, Vec2 u, TransportMode mode = TransportMode::Radiance) const;

  /// Splits for passes and for shadow rays.
  Color transparency() const;       ///< sum of the Transparent lobes' weights
  Color albedo() const;             ///< estimate of the reflected and transmitted fraction, without transparency
  bool has_non_delta() const { return has_non_delta_; }
  bool empty() const { return count_ == 0; }
  int lobe_count() const { return count_; }
  const Lobe& lobe(int i) const { return lobes_[i]; }
  uint32_t dropped_lobes() const { return dropped_; }

 private:
  int count_ = 0;
  uint32_t dropped_ = 0;
  bool has_non_delta_ = false;
  float sum_selection_ = 0.0f;
  Lobe lobes_[kMaxLobes];
};

/// Factor on f_cos when importance is carried through shading normals
/// (Veach 1997, eq. 5.19): |wo.ns| |wi.ng| / (|wo.ng| |wi.ns|).
float shading_normal_correction(const Bsdf& bsdf, Vec3 wo, Vec3 wi);

}  // namespace ajar
