// Steps that the makers of closures share; used only by closures.cpp and principled.cpp.
#pragma once

#include "shading/bsdf/closures.h"

namespace ajar::closures {

/// Lobes with smaller weights are dropped, as in Cycles.
constexpr float kWeightCutoff = 1e-5f;

Lobe make_lobe(LobeKind kind, Color weight, Vec3 normal);
void set_roughness(Lobe& lobe, float alpha_x, float alpha_y);
/// Aligns the lobe's s axis with the tangent, rotated about n; `rotation` is in turns.
void set_tangent(Lobe& lobe, Vec3 tangent, float rotation);
Vec3 rotate_about(Vec3 v, Vec3 axis, float angle);
/// Compensates the energy that single scattering loses. `mean_fresnel` is the mean reflectance of a facet; it colours
/// light that bounces more than once (Kulla and Conty 2017).
void compensate(Lobe& lobe, Compensation compensation, Color mean_fresnel);
float eta_from_ior(const Surface& surface, float ior);
/// Roughness along and across the tangent, by the rule of the Principled and Metallic BSDF.
void set_principled_anisotropy(Lobe& lobe, float roughness, const Anisotropy& anisotropy);
/// Puts a film on the outer side of a boundary with this index of refraction.
void set_film(Lobe& lobe, const Surface& surface, const ThinFilm& film, float ior);

}  // namespace ajar::closures
