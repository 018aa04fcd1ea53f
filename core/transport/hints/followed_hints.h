// The artist's light hints in one render: attached, tried, followed as far as they pay.
//
// Shares are learned once, from bidirectional samples that are used for nothing else: one step of population Monte
// Carlo for mixtures from a defensive start [Cappe, Douc, Guillin, Marin and Robert 2008]. Each component gets a share
// in proportion to the part of all light that went its way, however it was found; of the walks that set out, less than
// that (docs/benchmarks/thesis.md). What brings nothing is followed no further, and costs nothing.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "transport/hints/hint_guide.h"

namespace ajar {

class PathSeeds;
class PathSpace;
struct Path;

class FollowedHints {
 public:
  /// Learn what the hints bring, and let the walks of `space` follow them. Costs nothing where there are none.
  /// This must outlive the space, and stay where it is.
  void begin(std::shared_ptr<const AttachedHints> attached, PathSpace& space, uint32_t seed,
             const std::atomic<bool>& stop);
  void clear();

  const Hints& hints() const { return attached_->hints; }
  const std::vector<HintReport>& reports() const { return attached_->reports; }
  /// Null where no hint is worth following.
  const HintGuide* guide() const { return guide_.active() ? &guide_ : nullptr; }
  /// How much of their usual share mutations by hints deserve, at most 1: by the light of paths that hints could have
  /// proposed whole.
  float mutation_use() const { return mutation_use_; }
  /// For integrators without chains: light as learned; proposed are the samples that learned it.
  std::vector<HintStatistics> statistics() const;
  uint64_t rays() const { return rays_; }

 private:
  struct Trial;
  Trial try_hints(PathSeeds& seeds, Path& path, Sampler& sampler) const;
  void learn(const PathSpace& space, uint32_t seed, const std::atomic<bool>& stop);

  std::shared_ptr<const AttachedHints> attached_ = std::make_shared<const AttachedHints>();
  HintGuide guide_;
  std::vector<double> light_;  ///< of each hint: part of the image's
  std::vector<uint64_t> proposed_, useful_;
  float mutation_use_ = 1.0f;
  uint64_t rays_ = 0;
};

}  // namespace ajar
