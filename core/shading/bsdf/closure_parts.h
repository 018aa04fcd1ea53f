// Steps shared by the makers of closures; internal to closures.cpp and principled.cpp.
#pragma once

#include "shading/bsdf/closures.h"

namespace ajar::closures {

/// Weights below this are dropped, as in Cycles.
constexpr float kWeightCutoff = 1e-5f;

Lobe make_lobe(LobeKind kind, Color weight, Vec3 normal);
void set_roughness(Lobe& lobe, float alpha_x, float alpha_y);
/// Align the lobe's s with the tangent turned about n; `rotation` is in turns.
void set_tangent(Lobe& lobe, Vec3 tangent, float rotation);
Vec3 rotate_about(Vec3 v, Vec3 axis, float angle);
/// Put back the light that single scattering loses. `mean_fresnel` is the mean reflectance of a facet, which colours
/// what bounces more than once (Kulla and Conty 2017).
void compensate(Lobe& lobe, Compensation compensation, Color mean_fresnel);
float eta_from_ior(const Surface& surface, float ior);

}  // namespace ajar::closures
