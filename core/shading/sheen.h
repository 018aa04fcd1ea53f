// Grazing-angle lobes of cloth. Values exclude the cosine; `wo` and `wi` are on the side of n.
#pragma once

#include "math/types.h"
#include "shading/fresnel.h"

namespace ajar::sheen {

/// Disney 2012 (Burley): Schlick's curve of the angle between wi and the half vector, unnormalised as in Blender 3.x.
inline float disney(float cos_between) { return fresnel::schlick(safe_sqrt(0.5f * (1.0f + cos_between))); }
/// Fit of its directional albedo, within 0.002.
float disney_albedo(float cosine);

/// Fibres standing upright on the surface (Estevez and Kulla 2017, with Neubelt's visibility), alpha = roughness^2. An
/// approximation of Blender 4.x' microfiber sheen (Zeltner et al. 2022): like shape and albedo, not the same curve.
float microfiber(float roughness, Vec3 n, Vec3 wo, Vec3 wi);
/// Directional albedo, from a table integrated at first use.
float microfiber_albedo(float roughness, float cosine);

}  // namespace ajar::sheen
