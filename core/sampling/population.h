// Populations of weighted members that stand for an unnormalised target f: properly weighted when E[sum_i w_i h(x_i)]
// is the integral of h f for every h [Liu and Chen 1998; Del Moral, Doucet and Jasra 2006].
//
// What keeps a population so: moving members by kernels that leave f as it is (Metropolis-Hastings), with weights
// unchanged; drawing members again with expected numbers of copies in proportion to any positive preference, weights
// divided by that number; mixing two such populations with weights a and 1 - a fixed beforehand. A kernel may not be
// chosen by what the member it moves, or those it is drawn with, have done before.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

namespace ajar {

/// Systematic resampling: `parents[k]` is the k-th of the members drawn, in order. Member i is drawn n w_i / W times on
/// average and never a whole time more or less than that; so is every run of members in a row, which makes neighbours
/// in a well chosen order stand for one another. `u` in [0, 1). Returns W; when it is not positive nothing is drawn.
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
    while (!(weights[drawn] > 0.0)) --drawn;  // rounding of the very last end
    parents[k] = uint32_t(drawn);
  }
  return total;
}

/// Share of the energy that n new samples take from a population that stands for n_before samples, so that all count
/// alike; never less than `least`, which forgets the oldest. Fixed beforehand, so the mixture stays unbiased.
inline double new_share(double n, double n_before, double least) {
  return n_before > 0.0 ? std::fmax(n / (n + n_before), least) : 1.0;
}

/// Place along a Hilbert curve through the unit square (4^16 cells): members near each other in this order are near in
/// the plane.
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
