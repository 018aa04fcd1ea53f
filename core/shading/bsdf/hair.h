// Lobes of hair: scattering by a fibre, from all sides of it.
//
// Directions are measured from the fibre: the inclination theta from the plane across it, the azimuth phi around its
// tangent, from the eye. The offset h = sin(gamma) is where the ray of the eye meets the fibre: 0 in the middle, +-1 at
// the rims; gamma is the azimuth of the eye from the normal. Values are integrated over the sphere without a further
// cosine, and do not depend on the normal otherwise. So f |cos(light, n)| is the value itself, and importance is the
// value times |cos(eye, n) / cos(light, n)|. A point whose normal is turned away from the eye stands for the point on
// the opposite side of the fibre.
//
// HairChiang: the near-field model of Chiang et al. 2016, "A Practical and Controllable Hair and Fur Model for
// Production Path Tracing", with the longitudinal distribution of d'Eon et al. 2011: reflection (R), two ways of
// transmission (TT, TRT) and the remainder. HairHuang: see huang.h. HairReflection, HairTransmission: the parts of Blender's Hair BSDF, products
// of a distribution of theta and one of phi.
#pragma once

#include "shading/bsdf/lobe.h"

namespace ajar::hair {

/// A fibre of the model of Chiang et al., as stored in a lobe.
struct Fiber {
  Color absorption{0.0f};           ///< per radius of the fibre
  float eta = 1.55f;                ///< index of refraction
  float longitudinal = 0.1f;        ///< variance of the inclination (v)
  float longitudinal_first = 0.1f;  ///< the same for R
  float azimuthal = 0.1f;           ///< scale of the logistic distribution of the azimuth (s)
  float tilt = 0.0f;                ///< of the scales of the cuticle towards the root, in radians
  bool turns_light = false;         ///< the tilt turns the inclination of the light and not that of the eye (Blender 3)
};
/// The variance v of the longitudinal roughness, 0 to 1 (eq. 7).
float longitudinal_variance(float roughness);
/// The scale s of the azimuthal roughness, 0 to 1 (eq. 8).
float azimuthal_scale(float roughness);
/// The absorption for which dense hair has this colour (eq. 9).
Color absorption_of_color(Color color, float azimuthal_roughness);
/// The absorption by the two kinds of melanin, of their concentrations (d'Eon et al. 2011).
Color absorption_of_melanin(float eumelanin, float pheomelanin);

/// A lobe for the fibre along `tangent`, at a point with this geometric normal.
Lobe chiang_lobe(Color weight, Vec3 ng, Vec3 tangent, const Fiber& fiber);
/// Both parts of the Hair BSDF. The roughnesses are in radians; `offset` turns the lobe towards the tip.
Lobe part_lobe(bool transmission, Color weight, Vec3 normal, Vec3 tangent, float roughness_u, float roughness_v,
               float offset);

/// Whether the lobe has all ways of light through a fibre, which passes count as glossy.
inline bool is_whole(LobeKind kind) { return kind == LobeKind::HairChiang || kind == LobeKind::HairHuang; }
/// See lobe.h.
LobeValue evaluate(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode, bool flipped);
bool sample(const Lobe& lobe, Vec3 wo, float u_branch, Vec2 u, bool flipped, LobeSample& sample);
/// Estimate of the albedo for this cosine of the eye to the normal, without the lobe's weight.
Color albedo(const Lobe& lobe, float cos_wo);
/// The part of the density of scattering from wo to wi that counts as reflection; the rest counts as transmission. As in
/// Cycles, only R of the model of Chiang et al. is reflection, and all light of the model of Huang et al.
float reflected_share(const Lobe& lobe, Vec3 wo, Vec3 wi, bool flipped);

}  // namespace ajar::hair
