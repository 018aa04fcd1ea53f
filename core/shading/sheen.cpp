#include "shading/sheen.h"

#include <algorithm>
#include <array>

#include "math/warps.h"

namespace ajar::sheen {
namespace {

float alpha_of(float roughness) { return std::max(sqr(saturate(roughness)), 0.02f); }

float microfiber_local(float alpha, float cos_o, float cos_i, float sin2_h) {
  const float inverse = 1.0f / alpha;
  const float density = (2.0f + inverse) * std::pow(sin2_h, 0.5f * inverse) * (0.5f * kInvPi);
  return density / (4.0f * (cos_o + cos_i - cos_o * cos_i));
}

struct Table {
  static constexpr int kCosines = 32, kRoughnesses = 16, kLattice = 610;
  std::array<std::array<float, kCosines>, kRoughnesses> albedo;
  Table() {
    for (int r = 0; r < kRoughnesses; ++r)
      for (int c = 0; c < kCosines; ++c) {
        const float roughness = float(r) / float(kRoughnesses - 1), cosine = std::max(float(c) / float(kCosines - 1), 1e-3f);
        const Vec3 wo(safe_sqrt(1.0f - cosine * cosine), 0.0f, cosine);
        double sum = 0.0;
        for (int i = 0; i < kLattice; ++i) {
          const float golden = float(i) * 0.61803398875f;
          const Vec3 wi = warp::square_to_cosine_hemisphere({(float(i) + 0.5f) / float(kLattice), golden - std::floor(golden)});
          sum += kPi * microfiber(roughness, {0, 0, 1}, wo, wi);
        }
        albedo[r][c] = float(sum / kLattice);
      }
  }
};

}  // namespace

float disney_albedo(float cosine) {
  const float m = 1.0f - cosine;
  return 0.0045f + m * m * (0.0f + m * 0.3f);
}

float microfiber(float roughness, Vec3 n, Vec3 wo, Vec3 wi) {
  const Vec3 sum = wo + wi;
  const float cos_h = glm::dot(n, sum), length2 = length_squared(sum);
  const float cos_o = glm::dot(n, wo), cos_i = glm::dot(n, wi);
  if (!(length2 > 0.0f && cos_o > 0.0f && cos_i > 0.0f)) return 0.0f;
  return microfiber_local(alpha_of(roughness), cos_o, cos_i, saturate(1.0f - cos_h * cos_h / length2));
}

float microfiber_albedo(float roughness, float cosine) {
  static const Table table;
  const float x = saturate(cosine) * float(Table::kCosines - 1), y = saturate(roughness) * float(Table::kRoughnesses - 1);
  const int i = std::min(int(x), Table::kCosines - 2), j = std::min(int(y), Table::kRoughnesses - 2);
  const float fx = x - float(i), fy = y - float(j);
  const auto row = [&](int k) { return glm::mix(table.albedo[k][i], table.albedo[k][i + 1], fx); };
  return glm::mix(row(j), row(j + 1), fy);
}

}  // namespace ajar::sheen
