// Mixtures of densities with deterministic shares: p(x : alpha) = sum_k alpha_k p_k(x).
//
// Of N samples, component k gets floor(N alpha_k) samples. The remaining samples are distributed over the residuals by
// systematic resampling, so that E[n_k] = N alpha_k exactly for every N. Then 1/N sum f(x_i) / p(x_i : alpha) is
// unbiased. For integer N alpha_k it is the balance heuristic [Fan 2006, section 2.4.4 and appendix A].
// Shares never fall below a floor, so that a component that was once underrated can recover. Shares must be learned
// from other samples than those that they are used for; the code here cannot check this.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "math/types.h"

namespace ajar {

/// Makes `shares` sum to 1 with none below `floor` (at most 1/m): floor + (1 - m floor) share / sum. If the sum is zero
/// or not finite, all shares become equal.
inline void apply_floor(std::span<float> shares, float floor) {
  double sum = 0.0;
  for (float& share : shares) {
    if (!(share > 0.0f) || !std::isfinite(share)) share = 0.0f;
    sum += double(share);
  }
  const float m = float(shares.size());
  floor = std::min(floor, 1.0f / m);
  for (float& share : shares) {
    share = sum > 0.0 && std::isfinite(sum) ? floor + (1.0f - m * floor) * float(double(share) / sum) : 1.0f / m;
  }
}

/// The number of the `n` samples that each component draws. `u` in [0, 1) is the single offset of the systematic
/// resampling.
inline void deterministic_counts(std::span<const float> shares, int n, float u, std::span<int> counts) {
  double total = 0.0;
  for (float share : shares) total += double(share);
  int assigned = 0;
  for (size_t k = 0; k < shares.size(); ++k) {
    // The offset keeps products that are integers up to rounding from being rounded down to the integer below.
    counts[k] = int(std::floor(n * double(shares[k]) / total + 1e-6));
    assigned += counts[k];
  }
  const int left = n - assigned;
  if (left <= 0) return;
  double residual_sum = 0.0;
  const auto residual = [&](size_t k, int count) {
    return std::max(0.0, n * double(shares[k]) / total - double(count));
  };
  for (size_t k = 0; k < shares.size(); ++k) residual_sum += residual(k, counts[k]);
  // Systematic resampling: the residuals are laid end to end over [0, left). Each point u + integer gives one sample to
  // the component in whose residual it lies.
  double end = 0.0, next = double(u);
  int given = 0;
  size_t last = 0;
  for (size_t k = 0; k < shares.size() && given < left; ++k) {
    const double r = residual(k, counts[k]) * double(left) / residual_sum;
    if (r > 0.0) last = k;
    end += r;
    while (given < left && next < end) {
      ++counts[k];
      ++given;
      next += 1.0;
    }
  }
  counts[last] += left - given;  // rounding can leave the end of the last residual below the last point
}

}  // namespace ajar
