// What hints have brought to chains or populations: how often they proposed and were followed, and the light of paths
// that they could have made. Accounts add up, so every chain or thread may keep its own.
#pragma once

#include "transport/hints/hint_shares.h"
#include "transport/hints/hints.h"

namespace ajar {

/// Of one hint's proposals.
struct HintCounts {
  uint64_t proposed = 0, accepted = 0;
};

class HintAccount {
 public:
  /// One state in so many is looked at, and counts for all of them.
  static constexpr uint64_t kStride = 8;

  /// A state that carries `weight`, in units without the importance of places on the film.
  void add_state(const LightSet& lights, const Hints& hints, const Path& path, double weight) {
    if (of_hints_.size() < hints.size()) of_hints_.resize(hints.size());
    light_ += weight;
    add_hint_shares(lights, hints, path, weight, of_hints_);
  }
  void add_proposals(const std::vector<HintCounts>& counts);
  void add(const HintAccount& other);
  /// Of all hints, attached (and then counted here in the same order) or not. Light is `per_weight` times the weights
  /// of states, beside `other_light` in the image.
  std::vector<HintStatistics> statistics(const std::vector<HintReport>& reports, double per_weight,
                                         double other_light) const;

 private:
  double light_ = 0.0;
  std::vector<double> of_hints_;
  std::vector<HintCounts> proposals_;
};

}  // namespace ajar
