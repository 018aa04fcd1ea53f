// Grazing-angle lobes of cloth. Values exclude the cosine. wo and wi are on the side of n.
#pragma once

#include "math/types.h"
#include "shading/models/fresnel.h"

namespace ajar::sheen {

/// Disney 2012 (Burley): Schlick's curve of the angle between wi and the half vector, not normalised, as in Blender
/// 3.x.
inline float disney(float cos_between) { return fresnel::schlick(safe_sqrt(0.5f * (1.0f + cos_between))); }
/// A fit of the directional albedo of `disney`, within 2e-5.
inline float disney_albedo(float cosine) {
  const float m = 1.0f - cosine;
  return 0.00025745f + m * (0.00640908f + m * (0.02906721f + m * (0.02492564f + m * 0.0279597f)));
}

/// A layer of fibres, with multiple scattering: a linearly transformed cosine for each direction of the eye (Zeltner,
/// Burley and Chiang 2022, "Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines", eq. 2 to 4).
struct Microfiber {
  float a, b;    ///< of the transformation in the plane of the eye: (x, y, z) -> (a x + b z, a y, z)
  float albedo;  ///< fraction of the light that is scattered to this eye

  Microfiber(float roughness, float cos_eye);
  /// Density of the direction `w` of light per solid angle, in the frame whose x axis points to the eye. The value of
  /// the lobe with its cosine is this density times the albedo.
  float density(Vec3 w) const;
  Vec3 sample(Vec2 u) const;
};
constexpr int kTableSize = 32;
extern const float kLinearlyTransformedCosines[3 * kTableSize * kTableSize];

/// Ashikhmin, Premoze and Shirley 2000, section 4 (velvet), with Blender's normalisation. The minimum of sigma is 0.01.
float velvet(float sigma, Vec3 n, Vec3 wo, Vec3 wi);

}  // namespace ajar::sheen
