#include "shading/bsdf/sheen.h"

#include <algorithm>
#include <array>

#include "math/warps.h"

namespace ajar::sheen {
namespace {

constexpr float kSmallestRoughness = 0.065f;

/// Estevez and Kulla 2017, eq. 2, with Neubelt's visibility.
float upright_fibres(float alpha, Vec3 n, Vec3 wo, Vec3 wi) {
  const Vec3 sum = wo + wi;
  const float cos_o = glm::dot(n, wo), cos_i = glm::dot(n, wi), cos_h = glm::dot(n, sum), length2 = length_squared(sum);
  if (!(length2 > 0.0f && cos_o > 0.0f && cos_i > 0.0f)) return 0.0f;
  const float sin2_h = saturate(1.0f - cos_h * cos_h / length2), inverse = 1.0f / alpha;
  const float density = (2.0f + inverse) * std::pow(sin2_h, 0.5f * inverse) * (0.5f * kInvPi);
  return density / (4.0f * (cos_o + cos_i - cos_o * cos_i));
}

/// The directional albedo of upright_fibres, by which the shape is divided.
struct Table {
  static constexpr int kCosines = 32, kRoughnesses = 16, kLattice = 987;
  std::array<std::array<float, kCosines>, kRoughnesses> albedo;
  Table() {
    for (int r = 0; r < kRoughnesses; ++r)
      for (int c = 0; c < kCosines; ++c) {
        const float roughness = std::max(float(r) / float(kRoughnesses - 1), kSmallestRoughness);
        const float cosine = std::max(float(c) / float(kCosines - 1), 1e-3f);
        const Vec3 wo(safe_sqrt(1.0f - cosine * cosine), 0.0f, cosine);
        double sum = 0.0;
        for (int i = 0; i < kLattice; ++i) {
          const float golden = float(i) * 0.61803398875f;
          const Vec3 wi = warp::square_to_cosine_hemisphere(
              {(float(i) + 0.5f) / float(kLattice), golden - std::floor(golden)});
          sum += kPi * upright_fibres(roughness, {0, 0, 1}, wo, wi);
        }
        albedo[r][c] = std::max(float(sum / kLattice), 1e-6f);
      }
  }
  float at(float roughness, float cosine) const {
    const float x = saturate(cosine) * float(kCosines - 1), y = saturate(roughness) * float(kRoughnesses - 1);
    const int i = std::min(int(x), kCosines - 2), j = std::min(int(y), kRoughnesses - 2);
    const auto row = [&](int k) { return glm::mix(albedo[k][i], albedo[k][i + 1], x - float(i)); };
    return glm::mix(row(j), row(j + 1), y - float(j));
  }
};

}  // namespace

float microfiber(float roughness, Vec3 n, Vec3 wo, Vec3 wi, float cos_eye) {
  static const Table table;
  roughness = std::max(roughness, kSmallestRoughness);
  return upright_fibres(roughness, n, wo, wi) * microfiber_albedo(roughness, cos_eye) / table.at(roughness, cos_eye);
}

float microfiber_albedo(float roughness, float cosine) {
  const float r = std::clamp(roughness, kSmallestRoughness, 1.0f);
  const float at_grazing = 0.673f + 0.0561f * r - 1.0134f * std::exp(-20.35f * r);
  const float rate = std::exp(0.234f - 1.6692f * std::log(r) - (0.0645f + 0.3659f * r) * r);
  return at_grazing * std::exp(-rate * std::pow(saturate(cosine), 1.3688f - 0.2872f * r));
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
