#include "shading/models/sheen.h"

#include <algorithm>

#include "math/warps.h"

namespace ajar::sheen {
namespace {

/// Interpolates one of the three parts of the table.
float look_up(int part, float roughness, float cosine) {
  const float x = saturate(cosine) * float(kTableSize - 1), y = saturate(roughness) * float(kTableSize - 1);
  const int i = std::min(int(x), kTableSize - 2), j = std::min(int(y), kTableSize - 2);
  const float* rows = kLinearlyTransformedCosines + (part * kTableSize + j) * kTableSize + i;
  const float *low = rows, *high = rows + kTableSize;
  return glm::mix(glm::mix(low[0], low[1], x - float(i)), glm::mix(high[0], high[1], x - float(i)), y - float(j));
}

}  // namespace

Microfiber::Microfiber(float roughness, float cos_eye) {
  constexpr float kSmallestRoughness = 1e-3f, kSmallest = 1e-5f;
  roughness = std::clamp(roughness, kSmallestRoughness, 1.0f);
  a = look_up(0, roughness, cos_eye);
  b = look_up(1, roughness, cos_eye);
  albedo = look_up(2, roughness, cos_eye);
  if (std::abs(a) < kSmallest || albedo < kSmallest) a = 1.0f, b = albedo = 0.0f;
}

float Microfiber::density(Vec3 w) const {
  const float length2 = sqr(a * w.x + b * w.z) + sqr(a * w.y) + sqr(w.z);
  return w.z > 0.0f ? kInvPi * w.z * sqr(a / length2) : 0.0f;
}

Vec3 Microfiber::sample(Vec2 u) const {
  const Vec3 w = warp::square_to_cosine_hemisphere(u);
  return glm::normalize(Vec3(w.x - w.z * b, w.y, w.z * a));
}

float velvet(float sigma, Vec3 n, Vec3 wo, Vec3 wi) {
  const Vec3 sum = wo + wi;
  const float length = std::sqrt(length_squared(sum));
  if (!(length > 1e-5f)) return 0.0f;
  const Vec3 half = sum / length;
  const float cos_o = glm::dot(n, wo), cos_i = glm::dot(n, wi), cos_h = glm::dot(n, half),
              cos_oh = std::abs(glm::dot(wo, half));
  if (!(std::abs(cos_h) < 1.0f - 1e-5f && cos_oh > 1e-5f && cos_o > 0.0f && cos_i > 0.0f)) return 0.0f;
  const float inverse_variance = 1.0f / sqr(std::max(sigma, 0.01f)), sin2 = 1.0f - cos_h * cos_h;
  // The density is a Gaussian of the inverse of the half vector's slope; the masking is that of V-grooves.
  const float density = std::exp(-inverse_variance * cos_h * cos_h / sin2) * inverse_variance * kInvPi / (sin2 * sin2);
  const float grooves = 2.0f * std::max(cos_h / cos_oh, 1e-5f);
  const float masking = std::min({1.0f, grooves * cos_o, grooves * cos_i});
  return 0.25f * density * masking / (cos_o * cos_i);
}

}  // namespace ajar::sheen
