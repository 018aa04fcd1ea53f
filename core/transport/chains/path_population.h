// A population of complete paths that moves by Metropolis-Hastings steps and is drawn again with new samples: a
// sequential Monte Carlo sampler for the light of the film [Del Moral, Doucet and Jasra 2006; Fan 2006, section 5.5,
// corrected].
//
// Member i at path x carries weight w_i with E[sum_i w_i h(x_i)] the integral of h times the target of its space; its
// energy per channel is w_i f_c(x) / target(x). A generation takes new bidirectional samples, draws old members and new
// paths together in the order of a Hilbert curve over the film, so that all weights are equal, and moves every member
// some steps.
//
// It learns how the proposals of each mutation fare and where the film is bright. A population that used what it has
// learned itself would be biased: see `set_learned`. Random numbers are those of member and generation, so results do
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

namespace ajar {

class PathPopulation {
 public:
  struct Size {
    uint32_t members, steps;          ///< steps of a member in a generation
    uint32_t first_samples, samples;  ///< bidirectional samples of the first and of every other generation
  };
  struct Learned {
    std::vector<float> shares;  ///< of the mutations
    FilmImportance importance;
  };

  /// `number` tells apart populations of one render; each adds to its own half of the film's splats.
  /// Hints are among what it proposes; they must outlive it.
  PathPopulation(const PathSpace& space, Size size, uint32_t seed, uint32_t number, const FollowedHints& followed);

  /// Before the first generation: begin with what a population of an earlier frame had learned, and go on learning.
  void begin_with(const Learned& learned);

  /// One generation. Each of its steps is splatted into `film` as an estimate of the image, times `emphasis`, in units
  /// of splat_unit. Returns how much of it was done: 1 unless stopped, after which there shall be no other.
  double run_generation(Film& film, double emphasis, const std::atomic<bool>& stop);
  double splat_unit() const { return space_.film_area() / double(size_.members); }

  /// What this population has seen so far.
  Learned learned() const;
  /// Use what another population has learned. Unbiased as long as nothing in this one's past has influenced it.
  void set_learned(const Learned& learned);

  uint64_t steps() const { return steps_done_; }
  uint64_t samples() const { return samples_done_; }
  uint64_t rays() const;
  /// Adds up over populations.
  void add_statistics(std::map<std::string, double>& extra) const;
  /// What hints brought, in units of the steps of a member in all generations; adds up too.
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
  /// How the proposals of one mutation fared, in fixed point so that the order of sums does not matter.
  struct MutationGain {
    std::atomic<int64_t> gain{0}, rays{0};
  };

  Sampler seed_sampler(uint64_t sample) const;
  bool sample_seeds(uint32_t count, const std::atomic<bool>& stop);
  void draw();
  void move_slot(Film& film, Worker& worker, uint32_t slot, double emphasis);
  /// Bring the path of this slot's parent into `worker.path`; false when there is none.
  bool fetch(Worker& worker, uint32_t slot);

  const Scene& scene_;
  const Hints& hints_;
  PathSpace space_;
  Size size_;
  uint32_t seed_, number_;
  std::vector<MutationShare> mutations_;
  std::vector<float> first_shares_;  ///< of the mutations, which what is learned is drawn towards
  std::vector<bool> renews_;         ///< mutations whose proposals are worth the same wherever they arrive
  std::unique_ptr<Workers> workers_;

  struct Member {
    CompactPath path;  ///< empty where rounding lost it
    double weight = 0.0;
  };
  std::vector<Member> members_, moved_;  ///< before and after a generation
  double weight_ = 0.0;                  ///< of every member drawn
  uint64_t generation_ = 0, samples_done_ = 0, steps_done_ = 0;

  /// New samples of this generation, and who is drawn: candidates are the members, then the samples.
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
