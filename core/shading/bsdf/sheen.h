// Grazing-angle lobes of cloth. Values exclude the cosine. wo and wi are on the side of n.
#pragma once

#include "math/types.h"
#include "shading/bsdf/fresnel.h"

namespace ajar::sheen {

/// Disney 2012 (Burley): Schlick's curve of the angle between wi and the half vector, not normalised, as in Blender
/// 3.x.
inline float disney(float cos_between) { return fresnel::schlick(safe_sqrt(0.5f * (1.0f + cos_between))); }
/// A fit of the directional albedo of `disney`, within 2e-5.
inline float disney_albedo(float cosine) {
  const float m = 1.0f - cosine;
  return 0.00025745f + m * (0.00640908f + m * (0.02906721f + m * (0.02492564f + m * 0.0279597f)));
}

/// Upright fibres: the shape of Estevez and Kulla 2017, with the directional albedo of Blender 4.x' microfiber sheen
/// (Zeltner et al. 2022) for the eye's cosine. The angular distribution differs from Blender's; the energy is equal.
float microfiber(float roughness, Vec3 n, Vec3 wo, Vec3 wi, float cos_eye);
/// A fit of that albedo. Mean error 0.005, maximum error 0.026.
float microfiber_albedo(float roughness, float cosine);

/// Ashikhmin, Premoze and Shirley 2000, section 4 (velvet), with Blender's normalisation. The minimum of sigma is 0.01.
float velvet(float sigma, Vec3 n, Vec3 wo, Vec3 wi);

}  // namespace ajar::sheen
