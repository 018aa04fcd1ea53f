// The mutations that a scene needs, with their shares: the same list for all algorithms with chains.
//
// Without surfaces that may be mirrors or clear glass there is no caustic perturbation, because the lens perturbation
// then moves the same paths. Without attached hints there are no proposals by hints.
#pragma once

#include "transport/chains/mutations/mutation.h"
#include "transport/hints/hints.h"

namespace ajar {

/// `space` and `hints` must outlive the mutations. `hint_use`: factor of the usual share of hints (FollowedHints).
std::vector<MutationShare> standard_mutations(const PathSpace& space, const Hints& hints, float hint_use = 1.0f);
/// The mutation among them whose proposals do not depend on large parts of the path: bidirectional, with hints where
/// there are any. Without hints it has the share `bidirectional`; hints add to it.
constexpr float kBidirectionalShare = 0.4f;
MutationShare renewing_mutation(const PathSpace& space, const Hints& hints, float hint_use,
                                float bidirectional = kBidirectionalShare);

}  // namespace ajar
