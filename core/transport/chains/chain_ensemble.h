// Numbered chains over paths that start from bidirectional samples, and the brightness that scales their splats.
//
// Starting paths are drawn from a first set of samples in proportion to their luminance, evenly spaced along its
// cumulative sum. Further samples, from which no chain starts, improve the estimate of the brightness. Chains are
// numbered, so results do not depend on the number of threads.
#pragma once

#include <atomic>
#include <map>
#include <string>

#include <tbb/parallel_for.h>

#include "math/statistics.h"
#include "transport/bidirectional/bidirectional.h"
#include "transport/chains/chain.h"
#include "transport/hints/hint_account.h"

namespace ajar {

class ChainEnsemble {
 public:
  static constexpr int kChains = 96;

  /// Also collects statistics of these hints, which must outlive the ensemble. Called before begin.
  void watch(const Hints& hints) { hints_ = &hints; }
  /// Starts the chains from `seeds` bidirectional samples. Returns false when stopped. Without light no chain starts.
  bool begin(const PathSpace& space, const std::vector<MutationShare>& mutations, uint32_t seed, uint32_t seeds,
             const std::atomic<bool>& stop);
  bool empty() const { return chains_.empty(); }
  size_t size() const { return chains_.size(); }
  /// Integral of the target over all paths. Without importance it is the sum of all splats of a film.
  double brightness() const { return brightness_.mean(); }
  uint64_t steps() const { return steps_done_; }
  uint64_t seeds() const { return seeds_done_; }
  uint64_t rays() const;
  /// Adds the number of steps, the brightness, and the counts of each mutation.
  void add_statistics(std::map<std::string, double>& extra) const;
  /// For the hints of watch. `other_light`: light of the image that is not in the chains, in units of the brightness
  /// without importance.
  std::vector<HintStatistics> hint_statistics(const std::vector<HintReport>& reports, double other_light) const;

  /// Does further steps, evenly divided among the chains, and calls `visit(chain, path, weight, sampler)` in the task
  /// of the chain. Then draws further samples for the brightness.
  template <class Visit>
  void run(uint64_t steps, const std::atomic<bool>& stop, Visit&& visit) {
    steps_wanted_ += steps;
    tbb::parallel_for(
        size_t(0), chains_.size(),
        [&](size_t c) {
          Numbered& numbered = chains_[c];
          const uint64_t wanted = steps_wanted_ * (c + 1) / chains_.size() - steps_wanted_ * c / chains_.size();
          for (; numbered.steps < wanted; ++numbered.steps) {
            if (stop.load(std::memory_order_relaxed)) return;
            numbered.chain.step(numbered.sampler, [&](const Path& path, double weight) {
              if (hints_ && numbered.steps % HintAccount::kStride == 0)
                numbered.account.add_state(space_->scene.lights(), *hints_, path,
                                           HintAccount::kStride * weight / double(space_->importance.at(path.film)));
              visit(c, path, weight, numbered.sampler);
            });
          }
        },
        tbb::simple_partitioner());
    count_steps();
    const uint64_t seeds = first_seeds_ + this->steps() / kStepsPerSeed;
    if (seeds > seeds_done_) sample_seeds(uint32_t(seeds - seeds_done_), stop);
  }

 private:
  static constexpr uint64_t kStepsPerSeed = 24;  ///< chain steps for each further sample of the brightness
  struct Numbered {
    Chain chain;
    Sampler sampler;
    uint64_t steps = 0;
    HintAccount account{};
  };
  void add_accounts(HintAccount& sum) const;
  template <class Visit>
  double visit_seed(BidirectionalWalks& walks, uint32_t index, Visit&& visit) const;
  void start_chains(const std::vector<double>& values);
  std::vector<double> sample_seeds(uint32_t count, const std::atomic<bool>& stop);
  void count_steps();

  const PathSpace* space_ = nullptr;
  const Hints* hints_ = nullptr;
  const std::vector<MutationShare>* mutations_ = nullptr;
  uint32_t seed_ = 0, first_seeds_ = 0, seeds_done_ = 0;
  std::vector<Numbered> chains_;
  RunningMoments brightness_;
  uint64_t steps_done_ = 0, steps_wanted_ = 0, seed_rays_ = 0, failed_starts_ = 0, refused_paths_ = 0;
};

}  // namespace ajar
