// Statistics of hints in chains or populations: the numbers of proposals and acceptances, and the light of paths that
// the hints could have proposed. Accounts can be added, so each chain or thread can have its own.
#pragma once

#include "transport/hints/hint_shares.h"
#include "transport/hints/hints.h"

namespace ajar {

/// Of the proposals of one hint.
struct HintCounts {
  uint64_t proposed = 0, accepted = 0;
};

class HintAccount {
 public:
  /// One state in this many is examined, and counts for all of them.
  static constexpr uint64_t kStride = 8;

  /// Adds a state with `weight`, in units without the importance of positions on the film.
  void add_state(const LightSet& lights, const Hints& hints, const Path& path, double weight) {
    if (of_hints_.size() < hints.size()) of_hints_.resize(hints.size());
    light_ += weight;
    add_hint_shares(lights, hints, path, weight, of_hints_);
  }
  void add_proposals(const std::vector<HintCounts>& counts);
  void add(const HintAccount& other);
  /// For all hints, attached or not. The attached ones are counted here in the same order. Light is `per_weight` times
  /// the weights of states, plus `other_light` for the rest of the image.
  std::vector<HintStatistics> statistics(const std::vector<HintReport>& reports, double per_weight,
                                         double other_light) const;

 private:
  double light_ = 0.0;
  std::vector<double> of_hints_;
  std::vector<HintCounts> proposals_;
};

}  // namespace ajar
