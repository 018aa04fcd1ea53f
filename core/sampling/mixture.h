// Mixtures of densities with deterministic shares: p(x : alpha) = sum_k alpha_k p_k(x).
//
// Of N samples, component k gets floor(N alpha_k) for certain; those left over go to the residuals by systematic
// resampling, so that E[n_k] = N alpha_k exactly, whatever N. Then 1/N sum f(x_i) / p(x_i : alpha) is unbiased, and for
// integer N alpha_k it is the balance heuristic [Fan 2006, section 2.4.4 and appendix A].
// Shares never fall below a floor: a component that had bad luck once must be able to show itself again. They may be
// learned only from samples other than those they are used for; nothing here can check that.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "math/types.h"

namespace ajar {

/// Make `shares` sum to 1 with none below `floor` (at most 1/m): floor + (1 - m floor) share / sum. Zero or
/// non-finite sums give equal shares.
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

/// How many of `n` samples each component draws. `u` in [0, 1) is the single offset of the systematic resampling.
inline void deterministic_counts(std::span<const float> shares, int n, float u, std::span<int> counts) {
  double total = 0.0;
  for (float share : shares) total += double(share);
  int assigned = 0;
  for (size_t k = 0; k < shares.size(); ++k) {
    // Products that are integers but for rounding count as such.
    counts[k] = int(std::floor(n * double(shares[k]) / total + 1e-6));
    assigned += counts[k];
  }
  const int left = n - assigned;
  if (left <= 0) return;
  double residual_sum = 0.0;
  const auto residual = [&](size_t k, int count) { return std::max(0.0, n * double(shares[k]) / total - double(count)); };
  for (size_t k = 0; k < shares.size(); ++k) residual_sum += residual(k, counts[k]);
  // Walk through the residuals, laid end to end over [0, left); one more sample wherever u + integer is passed.
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
  counts[last] += left - given;  // rounding of the very last end
}

/// Shares in proportion to what the components' samples brought in the past, drawn towards `prior` as if `prior_count`
/// samples more had brought just what the prior says.
/// `sums[k]` is the sum over the n_k samples of component k, of weights (thesis, eq. 5.8) or whatever the shares shall follow.
inline void learn_shares(std::span<const double> sums, int n, std::span<const float> prior, float prior_count, float floor,
                         std::span<float> shares) {
  double total = 0.0;
  for (double sum : sums) total += sum;
  const double kept = total > 0.0 && std::isfinite(total) ? double(n) / (double(n) + double(prior_count)) : 0.0;
  for (size_t k = 0; k < shares.size(); ++k) {
    shares[k] = float((kept > 0.0 ? kept * sums[k] / total : 0.0) + (1.0 - kept) * double(prior[k]));
  }
  apply_floor(shares, floor);
}

/// A mixture over components of one type, each with `State sample(Vec2 u) const` and `float pdf(const State&) const`.
template <class Component>
class Mixture {
 public:
  using State = typename Component::State;

  explicit Mixture(std::vector<Component> components)
      : components_(std::move(components)), shares_(components_.size(), 1.0f / float(components_.size())) {}

  size_t size() const { return components_.size(); }
  std::span<const float> shares() const { return shares_; }
  void set_shares(std::vector<float> shares, float floor) {
    shares_ = std::move(shares);
    apply_floor(shares_, floor);
  }
  const Component& component(size_t k) const { return components_[k]; }

  float pdf(const State& x) const {
    float sum = 0.0f;
    for (size_t k = 0; k < size(); ++k) sum += shares_[k] * components_[k].pdf(x);
    return sum;
  }
  /// Draw n samples, calling visit(state, component) for each; `next_1d` and `next_2d` give random numbers.
  template <class Next1d, class Next2d, class Visit>
  void draw(int n, Next1d&& next_1d, Next2d&& next_2d, Visit&& visit) const {
    std::vector<int> counts(size());
    deterministic_counts(shares_, n, next_1d(), counts);
    for (size_t k = 0; k < size(); ++k) {
      for (int i = 0; i < counts[k]; ++i) visit(components_[k].sample(next_2d()), k);
    }
  }
  /// Move the shares to what past samples say; see learn_shares.
  void adapt(std::span<const double> sums, int n, float prior_count, float floor) {
    const std::vector<float> prior = shares_;
    learn_shares(sums, n, prior, prior_count, floor, shares_);
  }

 private:
  std::vector<Component> components_;
  std::vector<float> shares_;
};

}  // namespace ajar
