#include "transport/chains/mutations/standard_mutations.h"

#include <algorithm>

#include "transport/chains/mutations/bidirectional_mutation.h"
#include "transport/chains/mutations/caustic_perturbation.h"
#include "transport/chains/mutations/hint_mutation.h"
#include "transport/chains/mutations/lens_perturbation.h"

namespace ajar {

namespace {
// The efficiency depends little on these shares. Fewer bidirectional mutations improve `room` and `lantern` a little
// and make caustics with few steps worse.
constexpr float kLens = 0.35f, kCaustic = 0.25f;  // in addition to kBidirectionalShare
constexpr float kHint = 0.1f, kRegrow = 0.05f;    // also in addition, when there are hints
constexpr float kSharpRoughness = 0.05f;
}  // namespace

MutationShare renewing_mutation(const PathSpace& space, const Hints& hints, float hint_use, float bidirectional) {
  if (hints.empty()) return {std::make_unique<BidirectionalMutation>(space), bidirectional};
  const float hint = hint_use * kHint, regrow = hint_use * kRegrow, share = bidirectional + hint + regrow;
  return {std::make_unique<HintMutation>(space, hints, hint / share, regrow / share), share};
}

std::vector<MutationShare> standard_mutations(const PathSpace& space, const Hints& hints, float hint_use) {
  std::vector<MutationShare> mutations;
  mutations.push_back(renewing_mutation(space, hints, hint_use));
  mutations.push_back({std::make_unique<LensPerturbation>(space), kLens});
  const auto& programs = space.scene.programs();
  if (std::any_of(programs.begin(), programs.end(),
                  [](const ShaderProgram& p) { return p.may_be_smooth(kSharpRoughness); }))
    mutations.push_back({std::make_unique<CausticPerturbation>(space), kCaustic});
  return mutations;
}

}  // namespace ajar
