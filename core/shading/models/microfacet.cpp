#include "shading/models/microfacet.h"

#include <algorithm>
#include <cmath>

namespace ajar::microfacet {
namespace {

constexpr float kInvSqrtPi = 0.56418958354775628f;

/// erf for x >= 0 given exp(-x^2) (Abramowitz and Stegun 1964, 7.1.26; absolute error 2e-7).
float erf_positive(float x, float exp_minus_x2) {
  const float t = 1.0f / (1.0f + 0.3275911f * x);
  return 1.0f - t * (0.254829592f + t * (-0.284496736f + t * (1.421413741f + t * (-1.453152027f + t * 1.061405429f)))) *
                    exp_minus_x2;
}

/// The inverse of erf. As in Giles 2012 ("Approximating the erfinv function"), erfinv(x) / x is approximated as a
/// function of w = -log(1 - x^2), in which it is smooth at 0 and grows like sqrt(w) at the ends. Here one ratio of
/// polynomials covers all floats below 1 (w < 16). It was fitted for the minimum relative error, which is 1.4e-8 before
/// rounding to floats. All coefficients are positive, so there is no cancellation.
float inverse_erf(float x) {
  x = std::clamp(x, -kOneMinusEpsilon, kOneMinusEpsilon);
  const float w = -std::log((1.0f - x) * (1.0f + x));
  const float above = 0.88622694f +
                      w * (0.30653921f +
                           w * (0.059588324f + w * (7.7653958e-3f + w * (6.4386448e-4f + w * 2.4311355e-5f))));
  const float below = 1.0f + w * (0.084093435f +
                                  w * (0.032188937f + w * (1.8769487e-3f + w * (1.7952546e-4f + w * 1.2907622e-6f))));
  return x * (above / below);
}

/// Samples the slope, along the direction of view, of the facets that are visible from an angle of tangent `tan_theta`
/// (alpha = 1). Solves b = erf(x) of 1 + erf(x) + tan(theta) exp(-x^2) / sqrt(pi) over x < cot(theta), by Newton's
/// method inside a shrinking bracket.
float beckmann_visible_slope(float tan_theta, float u) {
  const float cot_theta = 1.0f / tan_theta, k = tan_theta * kInvSqrtPi;
  const float exp_cot = std::exp(-cot_theta * cot_theta), erf_cot = erf_positive(cot_theta, exp_cot);
  const float target = u * (1.0f + erf_cot + k * exp_cot);
  float low = -1.0f, high = erf_cot, b = 0.5f * (low + high);
  for (int i = 0; i < 24; ++i) {
    const float x = inverse_erf(b);
    const float error = 1.0f + b + k * std::exp(-x * x) - target;
    if (std::abs(error) < 2e-7f * (1.0f + k)) break;
    (error > 0.0f ? high : low) = b;
    const float slope = 1.0f - x * tan_theta;
    float next = slope > 1e-6f ? b - error / slope : low;
    if (!(next > low && next < high)) next = 0.5f * (low + high);
    if (next == b) break;
    b = next;
  }
  return inverse_erf(b);
}

float phong_exponent(float alpha) { return std::max(2.0f / (alpha * alpha) - 2.0f, 0.0f); }

}  // namespace

float beckmann_density(Vec3 m, float alpha_x, float alpha_y) {
  const float cos2 = m.z * m.z;
  if (!(cos2 > 1e-12f)) return 0.0f;
  const float tan2 = (sqr(m.x / alpha_x) + sqr(m.y / alpha_y)) / cos2;
  return kInvPi * std::exp(-tan2) / (alpha_x * alpha_y * cos2 * cos2);
}

float beckmann_masking_over_cos(Vec3 w, float alpha_x, float alpha_y) {
  const float a = std::sqrt(sqr(alpha_x * w.x) + sqr(alpha_y * w.y));
  if (w.z > 4.0f * a) return 1.0f / w.z;  // 1 + lambda rounds to 1 in single precision
  const float c = w.z / a;
  const float exp_c = std::exp(-c * c);
  return 1.0f / (0.5f * w.z * (1.0f + erf_positive(c, exp_c)) + 0.5f * kInvSqrtPi * a * exp_c);
}

Vec3 beckmann_sample_visible(Vec3 w, float alpha_x, float alpha_y, Vec2 u) {
  const Vec3 stretched = glm::normalize(Vec3(alpha_x * w.x, alpha_y * w.y, w.z));
  const float sin_theta = std::sqrt(sqr(stretched.x) + sqr(stretched.y));
  float slope_x, slope_y, cos_phi = 1.0f, sin_phi = 0.0f;
  if (sin_theta < 1e-4f * stretched.z) {
    const float r = std::sqrt(-std::log1p(-u.x)), phi = 2.0f * kPi * u.y;
    slope_x = r * std::cos(phi);
    slope_y = r * std::sin(phi);
  } else {
    cos_phi = stretched.x / sin_theta;
    sin_phi = stretched.y / sin_theta;
    slope_x = beckmann_visible_slope(sin_theta / std::max(stretched.z, 1e-6f), u.x);
    slope_y = inverse_erf(2.0f * u.y - 1.0f);
  }
  const float x = cos_phi * slope_x - sin_phi * slope_y, y = sin_phi * slope_x + cos_phi * slope_y;
  return glm::normalize(Vec3(-alpha_x * x, -alpha_y * y, 1.0f));
}

float gtr1_density(Vec3 m, float alpha) {
  if (alpha >= 1.0f) return kInvPi;
  const float alpha2 = alpha * alpha, sin2 = m.x * m.x + m.y * m.y;
  return (1.0f - alpha2) * kInvPi / (-std::log(alpha2) * (sin2 + alpha2 * m.z * m.z));
}

Vec3 gtr1_sample(float alpha, Vec2 u) {
  const float alpha2 = std::min(alpha * alpha, 0.9999f);
  const float cos2 = saturate((1.0f - std::pow(alpha2, 1.0f - u.x)) / (1.0f - alpha2));
  const float r = std::sqrt(1.0f - cos2), phi = 2.0f * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), std::sqrt(cos2)};
}

float ashikhmin_shirley_density(Vec3 m, float alpha_x, float alpha_y) {
  const float nx = phong_exponent(alpha_x), ny = phong_exponent(alpha_y);
  const float sin2 = m.x * m.x + m.y * m.y;
  const float exponent = sin2 > 0.0f ? (nx * m.x * m.x + ny * m.y * m.y) / sin2 : 0.5f * (nx + ny);
  // pow((1 - sin2) / 2) keeps the digits that cos(m) loses near the normal.
  const float power = m.z > 0.0f ? std::exp(0.5f * exponent * std::log1p(-std::min(sin2, kOneMinusEpsilon))) : 0.0f;
  return 0.5f * kInvPi * std::sqrt((nx + 1.0f) * (ny + 1.0f)) * power;
}

Vec3 ashikhmin_shirley_sample(float alpha_x, float alpha_y, Vec2 u) {
  const float nx = phong_exponent(alpha_x), ny = phong_exponent(alpha_y);
  // The four quadrants are equal; atan2 of the scaled angle maps each quadrant onto itself.
  const float t = 2.0f * kPi * u.x;
  const float phi = std::atan2(std::sqrt(nx + 1.0f) * std::sin(t), std::sqrt(ny + 1.0f) * std::cos(t));
  const float c = std::cos(phi), s = std::sin(phi);
  const float exponent = nx * c * c + ny * s * s;
  const float log_cos = std::log(std::max(1.0f - u.y, 1e-30f)) / (exponent + 1.0f);
  const float r = safe_sqrt(-std::expm1(2.0f * log_cos));
  return {r * c, r * s, std::exp(log_cos)};
}

}  // namespace ajar::microfacet
