// A learned density over directions at one place: eight von Mises-Fisher lobes, to be mixed with the BSDF's own
// density.
//
// Fitted by population Monte Carlo for mixtures (M-PMC, Cappé et al. 2008): samples drawn from anything, with weights
// w = f / p, pull each lobe by the share it has in them; the BSDF is one more component, whose shape is fixed and known
// at each sample. So lobes go where the BSDF leaves light behind, and the BSDF's share falls as far as they cover it
// (never below a floor). Each lobe remembers how far away its light comes from and is turned accordingly where the
// density is used (Ruppert et al. 2020).
#pragma once

#include <array>
#include <span>

#include "math/types.h"

namespace ajar {

/// Surfaces differ in how much of their light the BSDF finds by itself; each kind has its own share.
enum class GuideKind : uint8_t { Diffuse, Rough, Glossy };
constexpr int kGuideKinds = 3;

/// Light that came to a place from direction wi. Only such as brought any; what the density does not know does not
/// count.
struct GuideSample {
  Vec3 position, normal, wi;
  float inverse_distance;  ///< of what sent it
  float weight;            ///< luminance of f_cos L / pdf
  float pdf_bsdf;          ///< of wi, without delta lobes
  GuideKind kind;
  uint32_t pixel = 0, index = 0;  ///< of the path that found it
};

/// Ready to be evaluated: kept by cells, and once more by the vertex that has turned the lobes towards itself.
struct alignas(32) GuideLobes {
  static constexpr int kCount = 8;
  float x[kCount], y[kCount], z[kCount];  ///< unit means
  float half_kappa[kCount];
  float peak[kCount];  ///< weight times the lobe's density at its mean
};

inline float pdf_solid_angle(const GuideLobes& lobes, Vec3 w);

/// What one cell knows.
class GuideDistribution {
 public:
  static constexpr int kCount = GuideLobes::kCount;
  static constexpr float kMinShare = 0.1f;

  /// Forget everything and spread the lobes over what these samples show.
  void start(Vec3 center, std::span<const GuideSample* const> samples);
  /// Move to what the samples and `past_share` of what was known before say.
  void fit(std::span<const GuideSample* const> samples, float past_share, int iterations);
  /// Another center, when a cell is divided.
  void move_to(Vec3 center);

  Vec3 center() const { return center_; }
  /// Of the guide; the rest belongs to the BSDF. Zero where so little is left to the guide that asking it does not pay.
  float share(GuideKind kind) const { return share_[size_t(kind)] < kMinShare ? 0.0f : share_[size_t(kind)]; }
  std::span<const float> weights() const { return weight_; }
  Vec3 mean(int lobe) const { return Vec3(lobes_.x[lobe], lobes_.y[lobe], lobes_.z[lobe]); }
  float kappa(int lobe) const { return 2.0f * lobes_.half_kappa[lobe]; }

  /// The lobes as seen from p.
  void aim(Vec3 p, GuideLobes& out) const;
  /// u chooses the lobe.
  Vec3 sample(const GuideLobes& aimed, float u_lobe, Vec2 u) const;

 private:
  /// Sums over samples, in units of samples of mean weight.
  struct Sums {
    float weight[kCount], x[kCount], y[kCount], z[kCount], inverse_distance[kCount];
    float bsdf[kGuideKinds], total[kGuideKinds];
  };
  void accumulate(std::span<const GuideSample* const> samples, float unit, float most, Sums& sums) const;
  void maximize(const Sums& sums);

  Vec3 center_{0.0f};
  GuideLobes lobes_;
  float weight_[kCount], inverse_distance_[kCount];
  float share_[kGuideKinds];
  Sums past_;
};

}  // namespace ajar

#include "math/von_mises_fisher.h"

namespace ajar {

inline float pdf_solid_angle(const GuideLobes& lobes, Vec3 w) {
  float sum = 0.0f, value[GuideLobes::kCount];
  for (int k = 0; k < GuideLobes::kCount; ++k) {
    const float dx = lobes.x[k] - w.x, dy = lobes.y[k] - w.y, dz = lobes.z[k] - w.z;
    value[k] = lobes.peak[k] * exp_of_negative(-lobes.half_kappa[k] * (dx * dx + dy * dy + dz * dz));
  }
  for (int k = 0; k < GuideLobes::kCount; ++k) sum += value[k];
  return sum;
}

inline void GuideDistribution::aim(Vec3 p, GuideLobes& out) const {
  const Vec3 d = center_ - p;
  for (int k = 0; k < kCount; ++k) {
    const float x = lobes_.x[k] + d.x * inverse_distance_[k], y = lobes_.y[k] + d.y * inverse_distance_[k],
                z = lobes_.z[k] + d.z * inverse_distance_[k];
    const float scale = 1.0f / std::sqrt(std::max(x * x + y * y + z * z, 1e-12f));
    out.x[k] = x * scale;
    out.y[k] = y * scale;
    out.z[k] = z * scale;
    out.half_kappa[k] = lobes_.half_kappa[k];
    out.peak[k] = lobes_.peak[k];
  }
}

}  // namespace ajar
