// A Metropolis-Hastings chain over paths. No other file computes an acceptance probability [Veach 1997, chapter 11].
//
// A step chooses a mutation in proportion to its share among those that suit the path, draws a proposal, and moves to
// it with probability
//   a = min(1, target(y) T(y -> x) / (target(x) T(x -> y))).
// T includes the probability of choosing the mutation from the path. The old path x contributes 1 - a of a splat of
// luminance 1, and the proposal y contributes a: the expectation over the decision. Chains are numbered. The random
// numbers of a chain depend on seed, number and step alone.
#pragma once

#include <memory>
#include <vector>

#include "transport/chains/mutations/mutation.h"
#include "transport/hints/hint_account.h"

namespace ajar {

class Chain {
 public:
  struct Counts {
    uint64_t proposed = 0, accepted = 0, empty = 0;  ///< empty: proposals without a contribution
    double acceptance = 0.0;                         ///< sum of a
    void add(const Counts& other) {
      proposed += other.proposed;
      accepted += other.accepted;
      empty += other.empty;
      acceptance += other.acceptance;
    }
  };
  explicit Chain(const std::vector<MutationShare>& mutations) : mutations_(&mutations), counts_(mutations.size()) {}

  /// Starts from a path with positive target.
  void start(const Path& path) {
    if (!current_) current_ = std::make_unique<Path>(), proposal_ = std::make_unique<Path>();
    *current_ = path;
  }
  const Path& path() const { return *current_; }
  bool started() const { return current_ != nullptr; }
  const std::vector<Counts>& counts() const { return counts_; }
  /// Indexed by hint, up to the last hint that was proposed.
  const std::vector<HintCounts>& hint_counts() const { return hint_counts_; }
  uint64_t rays() const { return rays_; }

  /// The result of a step: the mutation of its proposal, the acceptance probability, the distance between the two paths
  /// on the film in pixels (0 if the acceptance probability is 0), and the number of rays.
  struct Step {
    size_t mutation = 0;
    double acceptance = 0.0;
    float film_distance = 0.0f;
    uint32_t rays = 0;
  };

  /// Does one step. Calls visit(path, weight) for both states with the weights of their splats, which sum to 1.
  template <class Visit>
  Step step(Sampler& sampler, Visit&& visit) {
    const Path& x = *current_;
    const double total = suiting_share(x);
    double left = double(sampler.get_1d()) * total;
    size_t k = 0, last = 0;
    for (; k < mutations_->size(); ++k) {
      const MutationShare& m = (*mutations_)[k];
      if (!(m.share > 0.0f) || !m.mutation->suits(x)) continue;
      last = k;
      left -= double(m.share);
      if (left < 0.0) break;
    }
    k = std::min(k, last);
    const Mutation& mutation = *(*mutations_)[k].mutation;
    Counts& counts = counts_[k];
    ++counts.proposed;
    Path& y = *proposal_;
    const uint64_t rays_before = rays_;
    y.hint = -1;
    double acceptance = 0.0;
    if (mutation.sample(x, sampler, y, rays_) && mutation.suits(y)) {
      const double there = mutation.pdf(x, y) / total, back = mutation.pdf(y, x) / suiting_share(y);
      // [Fan 2006, eq. 2.26 and 4.3]
      if (there > 0.0) acceptance = std::min(1.0, y.target * back / (x.target * there));
      if (!(acceptance >= 0.0)) acceptance = 0.0;
    } else {
      ++counts.empty;
    }
    counts.acceptance += acceptance;
    if (acceptance < 1.0) visit(x, 1.0 - acceptance);
    if (acceptance > 0.0) visit(y, acceptance);
    const Step done{k, acceptance, acceptance > 0.0 ? glm::length(y.film - x.film) : 0.0f,
                    uint32_t(rays_ - rays_before)};
    const bool accepted = double(sampler.get_1d()) < acceptance;
    if (y.hint >= 0) {
      if (size_t(y.hint) >= hint_counts_.size()) hint_counts_.resize(size_t(y.hint) + 1);
      ++hint_counts_[size_t(y.hint)].proposed;
      hint_counts_[size_t(y.hint)].accepted += accepted;
    }
    if (accepted) {
      ++counts.accepted;
      std::swap(current_, proposal_);
    }
    return done;
  }

 private:
  double suiting_share(const Path& path) const {
    double sum = 0.0;
    for (const MutationShare& m : *mutations_)
      if (m.share > 0.0f && m.mutation->suits(path)) sum += double(m.share);
    return sum;
  }

  const std::vector<MutationShare>* mutations_;
  std::unique_ptr<Path> current_, proposal_;
  std::vector<Counts> counts_;
  std::vector<HintCounts> hint_counts_;
  uint64_t rays_ = 0;
};

}  // namespace ajar
