// Distributions of microfacet normals under Smith's masking, in the local frame of the lobe (z is the macroscopic
// normal). Sources: Walter et al. 2007, Heitz 2014 (anisotropy, masking), Dupuy and Benyoub 2023 (visible normals of
// GGX by spherical caps), Jakob 2014 (visible normals of Beckmann).
//
// Masking and shadowing are independent, G(wo, wi) = G1(wo) G1(wi), as in Cycles, unless a comment says otherwise. All
// values stay finite at grazing angles because G1(w) / cos(w) is computed as one quantity.
#pragma once

#include <algorithm>
#include <cmath>

#include "math/types.h"

namespace ajar {

/// A lobe whose product of the two alphas is at most this is a delta distribution (Cycles has the same threshold).
constexpr float kDeltaAlphaProduct = 1e-7f;

namespace microfacet {

inline float ggx_density(Vec3 m, float alpha_x, float alpha_y) {
  const float sx = m.x / alpha_x, sy = m.y / alpha_y;
  const float t = sx * sx + sy * sy + m.z * m.z;
  return kInvPi / (alpha_x * alpha_y * t * t);
}

/// G1(w) / cos(w) for w.z >= 0.
inline float ggx_masking_over_cos(Vec3 w, float alpha_x, float alpha_y) {
  const float a2 = sqr(alpha_x * w.x) + sqr(alpha_y * w.y);
  return 2.0f / (w.z + std::sqrt(w.z * w.z + a2));
}

/// G(wo, wi) / (cos(wo) cos(wi)) for height-correlated masking and shadowing (Heitz 2014, eq. 99).
inline float ggx_correlated_over_cosines(Vec3 wo, Vec3 wi, float alpha_x, float alpha_y) {
  const float ro = std::sqrt(wo.z * wo.z + sqr(alpha_x * wo.x) + sqr(alpha_y * wo.y));
  const float ri = std::sqrt(wi.z * wi.z + sqr(alpha_x * wi.x) + sqr(alpha_y * wi.y));
  return 2.0f / (ro * wi.z + ri * wo.z);
}

/// Samples a normal that is visible from w. The density is G1(w) (w.m) D(m) / cos(w) per solid angle.
inline Vec3 ggx_sample_visible(Vec3 w, float alpha_x, float alpha_y, Vec2 u) {
  const Vec3 stretched = glm::normalize(Vec3(alpha_x * w.x, alpha_y * w.y, w.z));
  const float phi = 2.0f * kPi * u.x;
  const float z = (1.0f - u.y) * (1.0f + stretched.z) - stretched.z;
  const float r = safe_sqrt(1.0f - z * z);
  const Vec3 h = Vec3(r * std::cos(phi), r * std::sin(phi), z) + stretched;
  return glm::normalize(Vec3(alpha_x * h.x, alpha_y * h.y, std::max(h.z, 1e-9f)));
}

float beckmann_density(Vec3 m, float alpha_x, float alpha_y);
float beckmann_masking_over_cos(Vec3 w, float alpha_x, float alpha_y);
Vec3 beckmann_sample_visible(Vec3 w, float alpha_x, float alpha_y, Vec2 u);

/// GTR with exponent 1: Disney's clearcoat (Burley 2012, eq. 4). Sampled in proportion to D(m) cos(m).
float gtr1_density(Vec3 m, float alpha);
Vec3 gtr1_sample(float alpha, Vec2 u);

/// Anisotropic Phong of Ashikhmin and Shirley 2000: (cos m)^n with the exponents 2 / alpha^2 - 2, normalised as a
/// density of m. The sampling is exact.
float ashikhmin_shirley_density(Vec3 m, float alpha_x, float alpha_y);
Vec3 ashikhmin_shirley_sample(float alpha_x, float alpha_y, Vec2 u);

}  // namespace microfacet
}  // namespace ajar
