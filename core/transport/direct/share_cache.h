// Mixture shares learned per place and carried from iteration to iteration: PMC-HI beyond a single estimate.
//
// A cell is a small cube of space, a rounded normal and a material (a rounded direction of view as well where surfaces
// gloss). Its shares follow the second moments of what the components brought:
//   alpha_k proportional to sqrt(sum_i alpha_k rho_k(x_i) y_i^2),  rho_k = alpha_k p_k / p
// For components that do not overlap this is the optimum alpha_k ~ sqrt(E[(f/p_k)^2]) whatever shares the samples were
// drawn with, so all the past counts; where they overlap the fixed point is that of minimum variance (all E[y^2 p_k/p]
// equal), a damped form of the population Monte Carlo update for variance [Douc et al. 2007]. A prior of a few
// pseudo-samples shrinks young cells. Cells are slots of a table without a tag: two places that meet in a slot share
// their statistics, which costs efficiency, never truth. Sums are integers, so any order of threads gives the same
// ones. Between calls of `publish` the shares stand still.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "math/types.h"

namespace ajar {

class ShareCache {
 public:
  ShareCache() = default;
  /// `scale` is a typical luminance of y.
  ShareCache(uint32_t cell_count_log2, int components, float prior_count, float scale);

  /// For another frame; with `halvings`, what was learned so far counts less.
  ShareCache copied(int halvings) const;

  int components() const { return m_; }
  uint32_t cell(uint64_t key) const { return uint32_t(key) & mask_; }
  /// Shares of a cell for this iteration, none below its floor; the prior where nothing is known. Components whose
  /// prior is 0 do not exist here. Prior and floors are the caller's, who knows what there is to share at this very
  /// point.
  void shares(uint32_t cell, std::span<const float> prior, std::span<const float> floors,
              std::span<float> shares) const;
  bool learned(uint32_t cell) const { return past_[size_t(cell) * size_t(m_ + 1) + size_t(m_)] > 0.0f; }

  /// A sample was drawn; it brought y^2; of which alpha_k rho_k y^2 for component k. Any thread, any time.
  void count(uint32_t cell) const { sums_[size_t(cell) * size_t(m_ + 2)].fetch_add(1, std::memory_order_relaxed); }
  void add_square(uint32_t cell, float y_squared) const;
  void add_moment(uint32_t cell, int component, float moment) const;
  /// Turn everything recorded so far into the shares of the next iteration.
  void publish();

 private:
  uint64_t fixed_point(float squared) const;
  int m_ = 0;
  uint32_t mask_ = 0;
  float prior_count_ = 0.0f, inverse_scale_squared_ = 1.0f;
  /// Per cell: moments over the sum of y^2, and the weight of the prior beside them (0: nothing learned).
  std::vector<float> past_;
  /// Per cell: samples, sum of y^2, sum of moments per component.
  std::unique_ptr<std::atomic<uint64_t>[]> sums_;
};

/// Number of a cell: `size` is the edge of the cube.
uint64_t cell_key(Vec3 position, float size, Vec3 normal, uint32_t material);

}  // namespace ajar
