// Shares of a mixture, learned by position and kept from iteration to iteration: PMC-HI beyond a single estimate.
//
// A cell is a small cube of space, a rounded normal and a material (and a rounded direction of view on glossy
// surfaces). Its shares follow the second moments of the contributions of the components:
//   alpha_k proportional to sqrt(sum_i alpha_k rho_k(x_i) y_i^2),  rho_k = alpha_k p_k / p
// For components that do not overlap, this is the optimum alpha_k ~ sqrt(E[(f/p_k)^2]), for any shares with which
// the samples were drawn. So all past samples count. For components that overlap, the fixed point is that of minimum
// variance (all E[y^2 p_k/p] are equal), a damped form of the population Monte Carlo update for variance [Douc et al.
// 2007]. A prior of a few pseudo-samples regularises cells with few samples.
//
// Cells are slots of a table without keys. Two positions with the same slot share their statistics, which reduces
// efficiency but adds no bias. Sums are integers, so they do not depend on the order of the threads. The shares are
// constant between calls of `publish`.
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

  /// A copy for another frame. Each of the `halvings` halves the weight of what was learned.
  ShareCache copied(int halvings) const;

  int components() const { return m_; }
  uint32_t cell(uint64_t key) const { return uint32_t(key) & mask_; }
  /// The shares of a cell in this iteration, none below its floor. If nothing is known, they are the prior. Components
  /// with prior 0 do not exist at this point. The caller passes prior and floors, because they depend on the surface at
  /// the point.
  void shares(uint32_t cell, std::span<const float> prior, std::span<const float> floors,
              std::span<float> shares) const;
  bool learned(uint32_t cell) const { return past_[size_t(cell) * size_t(m_ + 1) + size_t(m_)] > 0.0f; }

  /// Records a sample: count, its y^2, and alpha_k rho_k y^2 of component k. Any thread may call these at any time.
  void count(uint32_t cell) const { sums_[size_t(cell) * size_t(m_ + 2)].fetch_add(1, std::memory_order_relaxed); }
  void add_square(uint32_t cell, float y_squared) const;
  void add_moment(uint32_t cell, int component, float moment) const;
  /// Computes the shares of the next iteration from everything recorded so far.
  void publish();

 private:
  uint64_t fixed_point(float squared) const;
  int m_ = 0;
  uint32_t mask_ = 0;
  float prior_count_ = 0.0f, inverse_scale_squared_ = 1.0f;
  /// By cell: moments divided by the sum of y^2, and the weight of the prior relative to them (0: nothing learned).
  std::vector<float> past_;
  /// By cell: number of samples, sum of y^2, sum of moments of each component.
  std::unique_ptr<std::atomic<uint64_t>[]> sums_;
};

/// The key of a cell. `size` is the edge of its cube.
uint64_t cell_key(Vec3 position, float size, Vec3 normal, uint32_t material);

}  // namespace ajar
