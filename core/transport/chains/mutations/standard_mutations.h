// The mutations that a scene needs, and how often each is chosen: the same list for all algorithms with chains.
//
// Without surfaces that may be mirrors or clear glass there is no caustic perturbation: what it moves
// then, the lens perturbation moves as well. Without attached hints there is no user path.
#pragma once

#include "transport/chains/mutations/mutation.h"
#include "transport/hints/hints.h"

namespace ajar {

/// `space` and `hints` must outlive the mutations. `hint_use`: of the share that hints usually have (FollowedHints).
std::vector<MutationShare> standard_mutations(const PathSpace& space, const Hints& hints, float hint_use = 1.0f);
/// The one among them that forgets where a path came from: bidirectional, with hints where there are any.
/// Without hints it has the share `bidirectional`, with them some more.
constexpr float kBidirectionalShare = 0.4f;
MutationShare renewing_mutation(const PathSpace& space, const Hints& hints, float hint_use,
                                float bidirectional = kBidirectionalShare);

}  // namespace ajar
