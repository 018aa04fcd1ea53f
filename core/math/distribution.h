// Tabulated distributions: discrete choices, and piecewise-constant densities on [0, 1]^2. All tables accept
// non-negative finite weights. A table whose weights sum to zero is empty and must not be sampled.
#pragma once

#include <algorithm>
#include <vector>

#include "math/types.h"

namespace ajar {

/// Discrete distribution over {0..n-1}, sampled by inversion of the cumulative sum. It keeps the stratification of u
/// and returns u rescaled to [0, 1) for reuse.
/// The cumulative sum is rounded to multiples of 2^-24, as random floats are. The pmf is its difference and so exactly
/// the probability of the entry. No positive weight gets probability zero (with up to 2^24 of them); a million entries
/// share 6 % of the probability evenly for this.
class DiscreteDistribution {
 public:
  DiscreteDistribution() = default;
  explicit DiscreteDistribution(const std::vector<double>& weights);

  struct Choice {
    uint32_t index;
    float pmf;
    float u_remapped;
  };
  bool empty() const { return !(total_ > 0.0); }
  size_t size() const { return cdf_.size(); }
  double total() const { return total_; }
  size_t memory_bytes() const { return cdf_.size() * sizeof(float); }
  float pmf(uint32_t index) const { return cdf_[index] - (index > 0 ? cdf_[index - 1] : 0.0f); }
  Choice sample(float u) const;

 private:
  std::vector<float> cdf_;  // cdf_[i] = sum of pmf(0..i); the last is 1
  double total_ = 0.0;
};

/// Piecewise-constant density over the unit square. The row is chosen by the marginal distribution, then the column by
/// the conditional one. The density is with respect to the area of the unit square.
class Distribution2D {
 public:
  Distribution2D() = default;
  /// `values`: width * height non-negative numbers, row by row, row 0 first.
  Distribution2D(const std::vector<float>& values, int width, int height);
  bool empty() const { return marginal_.empty(); }
  int width() const { return width_; }
  int height() const { return height_; }
  size_t memory_bytes() const {
    size_t bytes = marginal_.memory_bytes();
    for (const DiscreteDistribution& row : conditional_) bytes += row.memory_bytes();
    return bytes;
  }
  /// A point in [0, 1)^2 (x along the width, y along the height) and its density.
  Vec2 sample(Vec2 u, float& pdf_square) const;
  float pdf_square(Vec2 point) const;

 private:
  int width_ = 0, height_ = 0;
  DiscreteDistribution marginal_;
  std::vector<DiscreteDistribution> conditional_;
};

}  // namespace ajar
