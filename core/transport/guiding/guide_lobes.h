// A learned density over directions at one position: eight von Mises-Fisher lobes, which are mixed with the density of
// the BSDF.
//
// It is fitted by population Monte Carlo for mixtures (M-PMC, Cappé et al. 2008). The samples can come from any
// density. Their weights are w = f / p. Each sample moves each lobe in proportion to the share that the lobe has in the
// sample. The BSDF is one more component, with a fixed density that is known at each sample. So the lobes cover light
// that the BSDF samples badly, and the share of the BSDF decreases, down to a floor, with the light that they cover.
// Each lobe stores the distance from which its light comes and is rotated accordingly where the density is used
// (Ruppert et al. 2020).
#pragma once

#include <array>
#include <span>

#include "math/types.h"

namespace ajar {

/// Class of a surface, or a volume. Surfaces differ in how well their BSDF alone samples the light, so each class has its
/// own share. In volumes, the phase function takes the place of the BSDF.
enum class GuideKind : uint8_t { Diffuse, Rough, Glossy, Volume };
constexpr int kGuideKinds = 4;

/// Light that arrived at a position from direction wi. Directions without light are not stored. Light that the density
/// cannot represent does not count.
struct GuideSample {
  Vec3 position, normal, wi;  ///< normal: 0 in a volume
  float inverse_distance;     ///< 1 / distance to the point that sent the light
  float weight;               ///< luminance of f_cos L / pdf
  float pdf_bsdf;             ///< density of wi by the BSDF, without delta lobes
  GuideKind kind;
  uint32_t pixel = 0, index = 0;  ///< pixel and number of the path that found it
};

/// The lobes in the form in which they are evaluated. A cell stores them; a vertex keeps a copy that is rotated for its
/// position.
struct alignas(32) GuideLobes {
  static constexpr int kCount = 8;
  float x[kCount], y[kCount], z[kCount];  ///< unit means
  float half_kappa[kCount];
  float peak[kCount];  ///< weight times the density of the lobe at its mean
};

inline float pdf_solid_angle(const GuideLobes& lobes, Vec3 w);

/// The learned distribution of one cell.
class GuideDistribution {
 public:
  static constexpr int kCount = GuideLobes::kCount;
  static constexpr float kMinShare = 0.1f;

  /// Discards everything and distributes the lobes over these samples.
  void start(Vec3 center, std::span<const GuideSample* const> samples);
  struct Fit {
    float past_share;   ///< the factor on earlier samples
    float width_prior;  ///< pseudo-samples of uniform directions that widen each lobe
    int iterations;
  };
  /// Fits the distribution to the samples.
  void fit(std::span<const GuideSample* const> samples, const Fit& how);
  /// Changes the centre, when a cell is divided.
  void move_to(Vec3 center);

  Vec3 center() const { return center_; }
  /// The share of the guide; the rest is that of the BSDF. It is 0 if it is so small that the cost of the guide does
  /// not pay.
  float share(GuideKind kind) const { return share_[size_t(kind)] < kMinShare ? 0.0f : share_[size_t(kind)]; }
  std::span<const float> weights() const { return weight_; }
  Vec3 mean(int lobe) const { return Vec3(lobes_.x[lobe], lobes_.y[lobe], lobes_.z[lobe]); }
  float kappa(int lobe) const { return 2.0f * lobes_.half_kappa[lobe]; }

  /// The lobes as seen from p.
  void aim(Vec3 p, GuideLobes& out) const;
  /// Samples a direction; u_lobe chooses the lobe.
  Vec3 sample(const GuideLobes& aimed, float u_lobe, Vec2 u) const;

 private:
  /// Sums over samples, in units of samples of mean weight.
  struct Sums {
    float weight[kCount], x[kCount], y[kCount], z[kCount], inverse_distance[kCount];
    float bsdf[kGuideKinds], total[kGuideKinds];
  };
  void accumulate(std::span<const GuideSample* const> samples, float unit, float max_weight, Sums& sums) const;
  void maximize(const Sums& sums, float width_prior);

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
