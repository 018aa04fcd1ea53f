// A population of complete paths that moves by Metropolis-Hastings steps and is resampled together with new samples: a
// sequential Monte Carlo sampler for the light of the film [Del Moral, Doucet and Jasra 2006; Fan 2006, section 5.5,
// corrected].
//
// Member i at path x has a weight w_i. For every function h, E[sum_i w_i h(x_i)] is the integral of h times the target
// of the space. The energy of a member per channel is w_i f_c(x) / target(x). A generation draws new bidirectional
// samples, resamples the old members and the new paths together in the order of a Hilbert curve over the film, so that
// all weights are equal, and moves every member by some steps.
//
// The population learns the efficiency of each mutation and the luminance of the film. Its estimate would be biased if
// it used what it has learned itself: see `set_learned`. Random numbers depend on member and generation, so results do
// not depend on threads.
#pragma once

#include <map>
#include <string>

#include <tbb/enumerable_thread_specific.h>

#include "film/film.h"
#include "transport/bidirectional/path_seeds.h"
#include "transport/chains/chain.h"
#include "transport/hints/followed_hints.h"
#include "transport/hints/hint_account.h"
#include "transport/paths/compact_path.h"
#include "transport/paths/film_luminance.h"
#include "transport/paths/light_passes.h"

namespace ajar {

class PathPopulation {
 public:
  struct Size {
    uint32_t members, steps;          ///< chain steps of a member in a generation
    uint32_t first_samples, samples;  ///< bidirectional samples in the first generation and in each later one
  };
  struct Learned {
    std::vector<float> shares;  ///< of the mutations
    FilmImportance importance;
  };

  /// `number` distinguishes the populations of one render. Each adds to its own half of the film's splats. Hints are
  /// among its proposals; `followed` must outlive the population.
  PathPopulation(const PathSpace& space, Size size, uint32_t seed, uint32_t number, const FollowedHints& followed);

  /// Called before the first generation: starts with what a population of an earlier frame has learned, and continues
  /// learning.
  void begin_with(const Learned& learned);

  /// Runs one generation. Each of its steps is splatted into `film` as an estimate of the image times `emphasis`, in
  /// units of splat_unit. Returns the completed part: 1 unless stopped. No generation may follow a stopped one.
  double run_generation(Film& film, double emphasis, const std::atomic<bool>& stop);
  double splat_unit() const { return space_.film_area() / double(size_.members); }

  /// What this population has learned so far.
  Learned learned() const;
  /// Uses what another population has learned. The estimate stays unbiased if this population has not influenced the
  /// other one.
  void set_learned(const Learned& learned);

  uint64_t steps() const { return steps_done_; }
  uint64_t samples() const { return samples_done_; }
  uint64_t rays() const;
  /// Adds to the statistics of other populations.
  void add_statistics(std::map<std::string, double>& extra) const;
  /// Adds the statistics of hints, in units of the steps of a member in all generations.
  void add_hint_account(HintAccount& sum) const;
  /// Luminance by paths that the space leaves out: mean over the samples, for the whole film.
  double left_out() const;

 private:
  struct Worker {
    PathSeeds seeds;
    Chain chain;
    Path path;
    HintAccount account;
    double left_out = 0.0;
  };
  using Workers = tbb::enumerable_thread_specific<Worker>;
  /// Sums over the proposals of one mutation, in fixed point so that the order of summation does not matter.
  struct MutationGain {
    std::atomic<int64_t> gain{0}, rays{0};
  };

  Sampler seed_sampler(uint64_t sample) const;
  bool sample_seeds(uint32_t count, const std::atomic<bool>& stop);
  void draw();
  void move_slot(Film& film, Worker& worker, uint32_t slot, double emphasis);
  /// Copies the path of this slot's parent to `worker.path`. Returns false when there is none.
  bool fetch(Worker& worker, uint32_t slot);

  const Scene& scene_;
  const Hints& hints_;
  PathSpace space_;
  LightPasses passes_;
  Size size_;
  uint32_t seed_, number_;
  std::vector<MutationShare> mutations_;
  std::vector<float> first_shares_;  ///< prior shares of the mutations
  std::vector<bool> renews_;         ///< mutations whose proposals are useful at any distance on the film
  std::unique_ptr<Workers> workers_;

  struct Member {
    CompactPath path;  ///< empty if rounding made its contribution zero
    double weight = 0.0;
  };
  std::vector<Member> members_, moved_;  ///< before and after a generation
  double weight_ = 0.0;                  ///< of every member after resampling
  uint64_t generation_ = 0, samples_done_ = 0, steps_done_ = 0;

  /// New samples of this generation, and the result of resampling. Candidates are the members, then the samples.
  struct NewSample {
    double energy;
    Vec2 film;
  };
  uint64_t first_new_ = 0;
  std::vector<NewSample> new_samples_;
  std::vector<uint32_t> parents_;

  FilmLuminance luminance_;
  std::vector<MutationGain> mutation_gains_;
  bool learning_ = true;
};

}  // namespace ajar
