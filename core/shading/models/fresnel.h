// Fresnel reflectance and the curves that are derived from it. Cosines are on the incident side and not negative. eta
// is the index of refraction of the transmitted side divided by that of the incident side.
#pragma once

#include <algorithm>
#include <cmath>

#include "math/types.h"

namespace ajar::fresnel {

/// The reflectance of a dielectric for unpolarised light; 1 beyond the critical angle.
inline float dielectric(float cos_incident, float eta) {
  // Above this bound, everything is reflected up to rounding, and products of the terms would overflow.
  const float eta2 = std::min(eta * eta, 1e20f), g2 = eta2 - 1.0f + cos_incident * cos_incident;
  if (!(g2 > 0.0f)) return 1.0f;
  const float g = std::sqrt(g2);  // eta times the cosine of the refracted ray
  const float below_s = cos_incident + g, below_p = eta2 * cos_incident + g;
  const float inverse = 1.0f / (below_s * below_p);
  const float perpendicular = (cos_incident - g) * below_p * inverse,
              parallel = (eta2 * cos_incident - g) * below_s * inverse;
  return 0.5f * (perpendicular * perpendicular + parallel * parallel);
}

/// Reflectance at normal incidence.
inline float f0_from_eta(float eta) { return sqr((eta - 1.0f) / (eta + 1.0f)); }
inline float eta_from_f0(float f0) {
  const float root = std::sqrt(std::min(std::max(f0, 0.0f), 0.99f));
  return (1.0f + root) / (1.0f - root);
}

/// (1 - cos)^5 (Schlick 1994).
inline float schlick(float cosine) {
  const float m = saturate(1.0f - cosine), m2 = m * m;
  return m2 * m2 * m;
}

/// The relative position of the exact dielectric curve between its value at normal incidence (0) and 1 (1).
inline float dielectric_position(float cos_incident, float eta) {
  // (F - f0) / (1 - f0), times (eta + 1)^2 above and below, which is (eta - 1)^2 / f0.
  return eta > 0.0f ? saturate((dielectric(cos_incident, eta) * sqr(eta + 1.0f) - sqr(eta - 1.0f)) / (4.0f * eta))
                    : 0.0f;
}

/// The cosine of 82 degrees, as the F82 model defines it.
constexpr float kF82Cosine = 1.0f / 7.0f;
/// Schlick's curve with a dip at 82 degrees, whose cosine is 1/7 (Kutz et al. 2021, "Novel aspects of the Adobe
/// Standard Material"). `b` is the result of f82_coefficient.
inline Color f82(float cos_incident, Color f0, Color b) {
  const float m = saturate(1.0f - cos_incident), m5 = sqr(sqr(m)) * m;
  return glm::clamp(f0 + (1.0f - f0) * m5 - b * (cos_incident * m5 * m), 0.0f, 1.0f);
}
/// The coefficient for which the reflectance at 82 degrees is `at_82`.
inline Color f82_coefficient_of(Color f0, Color at_82) {
  constexpr float kM = 1.0f - kF82Cosine, kM5 = kM * kM * kM * kM * kM;
  return (f0 + (1.0f - f0) * kM5 - at_82) / (kF82Cosine * kM5 * kM);
}
/// The same if this reflectance is a fraction, `tint`, of the value of Schlick's curve.
inline Color f82_coefficient(Color f0, Color tint) {
  return f82_coefficient_of(f0, f82(kF82Cosine, f0, Color(0.0f)) * tint);
}
/// The cosine-weighted mean of `f82`: 1/21 of the rise of Schlick's curve, 1/126 of the dip.
inline Color f82_mean(Color f0, Color b) { return glm::mix(f0, Color(1.0f), 1.0f / 21.0f) - b / 126.0f; }

/// The reflectance of a conductor of index n + ik along the normal.
inline float f0_of_conductor(float n, float k) { return (sqr(n - 1.0f) + k * k) / (sqr(n + 1.0f) + k * k); }
/// The same for unpolarised light at any angle (Born and Wolf, Principles of Optics, section 14.4): u + iv is the index
/// times the cosine of the refracted wave.
inline float conductor(float cosine, float n, float k) {
  const float squares = n * n - k * k, t = squares - 1.0f + cosine * cosine;
  const float length = std::sqrt(t * t + sqr(2.0f * n * k));
  const float u = std::sqrt(std::max(0.5f * (length + t), 0.0f)), v = std::sqrt(std::max(0.5f * (length - t), 0.0f));
  const auto ratio = [](float above, float below) { return below > 0.0f ? above / below : 1.0f; };
  const float s = ratio(sqr(cosine - u) + v * v, sqr(cosine + u) + v * v);
  const float re = squares * cosine, im = 2.0f * n * k * cosine;
  return 0.5f * (s + ratio(sqr(re - u) + sqr(im - v), sqr(re + u) + sqr(im + v)));
}
inline Color conductor(float cosine, Color n, Color k) {
  return {conductor(cosine, n.x, k.x), conductor(cosine, n.y, k.y), conductor(cosine, n.z, k.z)};
}

/// The cosine-weighted mean of `dielectric` over the hemisphere (fits of Kulla and Conty 2017, within 0.006).
inline float dielectric_mean(float eta) {
  if (eta >= 1.0f) return (eta - 1.0f) / (4.08567f + 1.00071f * eta);
  return 0.997118f + eta * (0.1014f - eta * (0.965241f + eta * 0.130607f));
}

/// Refracts w (which points away from the surface, on m's side) at m. Returns false beyond the critical angle.
inline bool refract(Vec3 w, Vec3 m, float eta, Vec3& transmitted) {
  const float cos_incident = glm::dot(w, m), inverse = 1.0f / eta;
  const float sin2_transmitted = (1.0f - cos_incident * cos_incident) * inverse * inverse;
  if (!(sin2_transmitted < 1.0f)) return false;
  transmitted = glm::normalize((cos_incident * inverse - std::sqrt(1.0f - sin2_transmitted)) * m - inverse * w);
  return true;
}

}  // namespace ajar::fresnel
