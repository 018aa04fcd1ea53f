// What walks from lights follow in one render: the artist's light hints, attached, tried, and followed as far as this is
// efficient, and learned starts (emission_training.h).
//
// Shares of hints are learned once, from bidirectional samples that are used for nothing else. The method is one step of
// population Monte Carlo for mixtures from a defensive start [Cappe, Douc, Guillin, Marin and Robert 2008]. The share
// of a component is in proportion to the part of all light that its directions contain, by whichever component the
// light was found. Only a fraction of this share of the walks starts along hints (docs/benchmarks/thesis.md).
// Components without light are removed and cost nothing.
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
  /// Learns the shares of the hints, and the starts if no integrator has asked for them yet. Lets the walks of `space`
  /// follow them. This object must outlive the space and must not move.
  void begin(std::shared_ptr<const AttachedHints> attached, PathSpace& space, uint32_t seed,
             const std::atomic<bool>& stop);
  void clear();

  const Hints& hints() const { return attached_->hints; }
  const std::vector<HintReport>& reports() const { return attached_->reports; }
  /// Null if no hint is followed and no start was learned.
  const LightWalkGuide* guide() const {
    if (starts_) return &*starts_;
    return guide_.active() ? &guide_ : nullptr;
  }
  /// By which factor learned starts reduce the second moment of photons; 0 if walks do not follow them.
  double emission_gain() const { return starts_ ? emission_.gain : 0.0; }
  /// Factor of the usual share of mutations by hints, at most 1. It follows from the light of paths that hints could
  /// have proposed completely.
  float mutation_use() const { return mutation_use_; }
  /// For integrators without chains. The light is that of the learning samples, and `proposed` counts those samples.
  std::vector<HintStatistics> statistics() const;
  /// Rays that learned the shares of hints, and those that learned the starts.
  uint64_t rays() const { return rays_; }
  uint64_t emission_rays() const { return emission_rays_; }

 private:
  struct Trial;
  Trial try_hints(PathSeeds& seeds, Path& path, Sampler& sampler) const;
  void learn(const PathSpace& space, uint32_t seed, const std::atomic<bool>& stop);

  std::shared_ptr<const AttachedHints> attached_ = std::make_shared<const AttachedHints>();
  HintGuide guide_;
  LearnedEmission emission_;
  std::optional<EmissionGuide> starts_;
  std::vector<double> light_;  ///< of each hint: its part of the light in the image
  std::vector<uint64_t> proposed_, useful_;
  float mutation_use_ = 1.0f;
  uint64_t rays_ = 0, emission_rays_ = 0;
};

}  // namespace ajar
