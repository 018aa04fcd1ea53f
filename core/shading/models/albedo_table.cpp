#include "shading/models/albedo_table.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <mutex>

#include "shading/models/fresnel.h"
#include "shading/models/microfacet.h"

namespace ajar::albedo_table {
namespace {

/// The mean of `value(m)` over the normals of GGX that are visible under `cosine`, by a rank-1 lattice.
template <typename Value>
float mean_over_visible(float cosine, float alpha, int count, Value value) {
  const Vec3 wo(safe_sqrt(1.0f - cosine * cosine), 0.0f, cosine);
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const float golden = float(i) * 0.61803398875f;
    const Vec2 u(golden - std::floor(golden), (float(i) + 0.5f) / float(count));
    sum += value(wo, microfacet::ggx_sample_visible(wo, alpha, alpha, u));
  }
  return float(sum / count);
}

float masking(Vec3 w, float alpha) {
  return std::abs(w.z) * microfacet::ggx_masking_over_cos({w.x, w.y, std::abs(w.z)}, alpha, alpha);
}

/// The fraction of the light from a visible facet towards wi that is not shadowed. `wi` is above the surface.
float unshadowed(Vec3 wo, Vec3 wi, float alpha, bool correlated) {
  if (!correlated) return masking(wi, alpha);
  return wi.z * microfacet::ggx_correlated_over_cosines(wo, wi, alpha, alpha) /
         microfacet::ggx_masking_over_cos(wo, alpha, alpha);
}

float reflected(Vec3 wo, Vec3 m, float alpha, bool correlated) {
  const Vec3 wi = 2.0f * glm::dot(wo, m) * m - wo;
  return wi.z > 0.0f ? unshadowed(wo, wi, alpha, correlated) : 0.0f;
}

float transmitted(Vec3 wo, Vec3 m, float alpha, float eta, bool correlated) {
  Vec3 wi;
  if (!fresnel::refract(wo, m, eta, wi) || !(wi.z < 0.0f)) return 0.0f;
  return unshadowed(wo, {wi.x, wi.y, -wi.z}, alpha, correlated);
}

// Both axes are uniform in cos and in roughness = sqrt(alpha). The first cosine is above zero.
constexpr float kSmallestCosine = 1e-3f;

struct Position {
  int index;
  float fraction;
};
Position locate(float x, int size) {
  const float scaled = saturate(x) * float(size - 1);
  const int index = std::min(int(scaled), size - 2);
  return {index, scaled - float(index)};
}
/// On the axis of the fourth root of f0, which is the same for eta and 1 / eta.
Position locate_eta(float eta, int size) { return locate(std::sqrt(std::abs(eta - 1.0f) / (eta + 1.0f)), size); }
float lerp(float a, float b, float t) { return a + (b - a) * t; }

struct MirrorTable {
  static constexpr int kCosines = 64, kRoughnesses = 32, kLattice = 233;
  std::array<std::array<float, kCosines>, kRoughnesses> albedo;
  std::array<float, kRoughnesses> mean;

  explicit MirrorTable(bool correlated) {
    for (int r = 0; r < kRoughnesses; ++r) {
      const float alpha = std::max(sqr(float(r) / float(kRoughnesses - 1)), 1e-4f);
      double sum = 0.0, weight = 0.0;
      for (int c = 0; c < kCosines; ++c) {
        const float cosine = std::max(float(c) / float(kCosines - 1), kSmallestCosine);
        albedo[r][c] = mean_over_visible(cosine, alpha, kLattice,
                                         [&](Vec3 wo, Vec3 m) { return reflected(wo, m, alpha, correlated); });
        const double share = (c == 0 || c == kCosines - 1) ? 0.5 : 1.0;
        sum += share * albedo[r][c] * cosine;
        weight += share * cosine;
      }
      mean[r] = float(sum / weight);
    }
  }
};

const MirrorTable& mirror_table() {
  static const MirrorTable table(false);
  return table;
}
const MirrorTable& correlated_table() {
  static const MirrorTable table(true);
  return table;
}

float lookup(const MirrorTable& t, float cosine, float alpha) {
  const auto c = locate(cosine, t.kCosines), r = locate(std::sqrt(alpha), t.kRoughnesses);
  const auto row = [&](int i) { return lerp(t.albedo[i][c.index], t.albedo[i][c.index + 1], c.fraction); };
  return lerp(row(r.index), row(r.index + 1), r.fraction);
}
float lookup_mean(const MirrorTable& t, float alpha) {
  const auto r = locate(std::sqrt(alpha), t.kRoughnesses);
  return lerp(t.mean[r.index], t.mean[r.index + 1], r.fraction);
}

struct GlassTable {
  static constexpr int kCosines = 24, kRoughnesses = 16, kEtas = 16, kLattice = 89;
  // Third axis: sqrt(|eta - 1| / (eta + 1)), the fourth root of f0. The first half is for eta >= 1, the second for its
  // inverse.
  using Row = std::array<float, kCosines>;
  std::array<std::array<std::array<Row, kRoughnesses>, kEtas>, 2> albedo;
  std::array<std::array<std::array<float, kRoughnesses>, kEtas>, 2> mean;

  explicit GlassTable(bool correlated) {
    for (int side = 0; side < 2; ++side)
      for (int e = 0; e < kEtas; ++e) {
        const float z2 = std::min(sqr(float(e) / float(kEtas - 1)), 0.99f);
        const float above = (1.0f + z2) / (1.0f - z2), eta = side == 0 ? above : 1.0f / above;
        for (int r = 0; r < kRoughnesses; ++r) fill(side, e, r, eta, correlated);
      }
  }
  void fill(int side, int e, int r, float eta, bool correlated) {
    const float alpha = std::max(sqr(float(r) / float(kRoughnesses - 1)), 1e-4f);
    double sum = 0.0, weight = 0.0;
    for (int c = 0; c < kCosines; ++c) {
      const float cosine = std::max(float(c) / float(kCosines - 1), kSmallestCosine);
      const float value = mean_over_visible(cosine, alpha, kLattice, [&](Vec3 wo, Vec3 m) {
        const float f = fresnel::dielectric(glm::dot(wo, m), eta);
        return f * reflected(wo, m, alpha, correlated) + (1.0f - f) * transmitted(wo, m, alpha, eta, correlated);
      });
      albedo[side][e][r][c] = value;
      const double share = (c == 0 || c == kCosines - 1) ? 0.5 : 1.0;
      sum += share * value * cosine;
      weight += share * cosine;
    }
    mean[side][e][r] = float(sum / weight);
  }
};

const GlassTable& glass_table() {
  static const auto table = std::make_unique<const GlassTable>(false);
  return *table;
}
const GlassTable& correlated_glass_table() {
  static const auto table = std::make_unique<const GlassTable>(true);
  return *table;
}

float lookup(const GlassTable& t, float cosine, float alpha, float eta) {
  const int side = eta >= 1.0f ? 0 : 1;
  const auto c = locate(cosine, t.kCosines), r = locate(std::sqrt(alpha), t.kRoughnesses);
  const auto e = locate_eta(eta, t.kEtas);
  const auto row = [&](int k, int i) {
    return lerp(t.albedo[side][k][i][c.index], t.albedo[side][k][i][c.index + 1], c.fraction);
  };
  const auto plane = [&](int k) { return lerp(row(k, r.index), row(k, r.index + 1), r.fraction); };
  return lerp(plane(e.index), plane(e.index + 1), e.fraction);
}
float lookup_mean(const GlassTable& t, float alpha, float eta) {
  const int side = eta >= 1.0f ? 0 : 1;
  const auto r = locate(std::sqrt(alpha), t.kRoughnesses);
  const auto e = locate_eta(eta, t.kEtas);
  const auto plane = [&](int k) { return lerp(t.mean[side][k][r.index], t.mean[side][k][r.index + 1], r.fraction); };
  return lerp(plane(e.index), plane(e.index + 1), e.fraction);
}

struct PositionTable {
  static constexpr int kSize = 16, kLattice = 144;
  using Slice = std::array<std::array<float, kSize>, kSize>;  // roughness, cosine
  mutable std::array<Slice, kSize> slices{};
  mutable std::array<std::once_flag, kSize> once;
  mutable std::array<std::atomic<bool>, kSize> made{};

  const Slice& slice(int index) const {
    if (!made[size_t(index)].load(std::memory_order_acquire)) [[unlikely]]
      make(index);
    return slices[size_t(index)];
  }
  void make(int index) const {
    std::call_once(once[size_t(index)], [&] {
      const float z2 = std::clamp(sqr(float(index) / float(kSize - 1)), 1e-4f, 0.99f);
      const float eta = (1.0f + z2) / (1.0f - z2);
      for (int r = 0; r < kSize; ++r)
        for (int c = 0; c < kSize; ++c) {
          const float alpha = std::max(sqr(float(r) / float(kSize - 1)), 1e-4f);
          const float cosine = std::max(float(c) / float(kSize - 1), kSmallestCosine);
          slices[size_t(index)][size_t(r)][size_t(c)] = mean_over_visible(
              cosine, alpha, kLattice, [&](Vec3 wo, Vec3 m) {
                const float cos_facet = glm::dot(wo, m);
                return 2.0f * cos_facet * m.z > wo.z ? fresnel::dielectric_position(cos_facet, eta) : 0.0f;
              });
        }
      made[size_t(index)].store(true, std::memory_order_release);
    });
  }
};

}  // namespace

float dielectric_position(float cosine, float alpha, float eta) {
  static const PositionTable table;
  const auto c = locate(cosine, table.kSize), r = locate(std::sqrt(alpha), table.kSize);
  const auto e = locate_eta(eta, table.kSize);
  const auto plane = [&](int k) {
    const PositionTable::Slice& slice = table.slice(k);
    const auto row = [&](int i) {
      return lerp(slice[size_t(i)][size_t(c.index)], slice[size_t(i)][size_t(c.index + 1)], c.fraction);
    };
    return lerp(row(r.index), row(r.index + 1), r.fraction);
  };
  return lerp(plane(e.index), plane(e.index + 1), e.fraction);
}

float ggx(float cosine, float alpha) { return lookup(mirror_table(), cosine, alpha); }
float ggx_mean(float alpha) { return lookup_mean(mirror_table(), alpha); }
float ggx_correlated(float cosine, float alpha) { return lookup(correlated_table(), cosine, alpha); }
float ggx_correlated_mean(float alpha) { return lookup_mean(correlated_table(), alpha); }

float ggx_glass(float cosine, float alpha, float eta) { return lookup(glass_table(), cosine, alpha, eta); }
float ggx_glass_mean(float alpha, float eta) { return lookup_mean(glass_table(), alpha, eta); }
float ggx_glass_correlated(float cosine, float alpha, float eta) {
  return lookup(correlated_glass_table(), cosine, alpha, eta);
}
float ggx_glass_correlated_mean(float alpha, float eta) { return lookup_mean(correlated_glass_table(), alpha, eta); }

}  // namespace ajar::albedo_table
