// Populations of weighted members that stand for an unnormalised target f. A population is properly weighted if E[sum_i
// w_i h(x_i)] is the integral of h f for every h [Liu and Chen 1998; Del Moral, Doucet and Jasra 2006].
//
// Three operations keep a population properly weighted:
// - moving members by kernels that leave f invariant (Metropolis-Hastings), with unchanged weights;
// - resampling members so that their expected numbers of copies are proportional to any positive preference, with
//   weights divided by these numbers;
// - mixing two such populations with weights a and 1 - a that are fixed beforehand.
// The choice of a kernel must not depend on the past of the member that it moves, nor on the past of the members with
// which this member is resampled.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

namespace ajar {

/// Systematic resampling: `parents[k]` is the index of the k-th drawn member, in ascending order. The mean number of
/// copies of member i is n w_i / W, and the actual number differs from it by less than 1. The same holds for every run
/// of consecutive members, so that neighbours represent each other if the order puts similar members side by side. `u`
/// is in [0, 1). Returns W, the sum of the weights; if it is not positive, nothing is drawn.
inline double systematic_resample(std::span<const double> weights, double u, std::span<uint32_t> parents) {
  double total = 0.0;
  for (double w : weights) total += w;
  if (!(total > 0.0) || !std::isfinite(total)) return 0.0;
  const double step = total / double(parents.size());
  size_t i = 0;
  double end = weights[0];
  for (size_t k = 0; k < parents.size(); ++k) {
    const double at = (double(k) + u) * step;
    while (at >= end && i + 1 < weights.size()) end += weights[++i];
    size_t drawn = i;
    while (!(weights[drawn] > 0.0)) --drawn;  // rounding can leave the last end below the last position
    parents[k] = uint32_t(drawn);
  }
  return total;
}

/// Share of n new samples in a mixture with a population that stands for n_before samples, so that all samples have
/// equal weight. It is at least `min_share`, so that old samples are forgotten in time. It is fixed beforehand, so the
/// mixture stays unbiased.
inline double new_share(double n, double n_before, double min_share) {
  return n_before > 0.0 ? std::fmax(n / (n + n_before), min_share) : 1.0;
}

/// Position along a Hilbert curve through the unit square (4^16 cells). Members that are near each other in this order
/// are near each other in the plane.
inline uint32_t hilbert_index(float x, float y) {
  const auto cell = [](float v) { return uint32_t(std::fmin(std::fmax(v, 0.0f) * 65536.0f, 65535.0f)); };
  uint32_t column = cell(x), row = cell(y), index = 0;
  for (uint32_t s = 1u << 15; s > 0; s >>= 1) {
    const uint32_t right = (column & s) != 0, up = (row & s) != 0;
    index = (index << 2) | ((3 * right) ^ up);
    if (!up) {
      if (right) column = 65535u - column, row = 65535u - row;
      const uint32_t swapped = column;
      column = row;
      row = swapped;
    }
  }
  return index;
}

}  // namespace ajar
