// Where hints would help: the light paths that path tracing finds too seldom, in groups.
//
// A pilot pass draws bidirectional samples. A path of contribution f that path tracing finds with density p adds
// f/p times its energy to the second moment of path tracing; paths are chosen by that product, f/p bounded at a
// quantile so that no single path speaks for all. Of the paths chosen, those with the most others near them, vertex by
// vertex, are suggested as curves: from the light to the last rough surface before the eye. Light from infinitely far
// and light that arrives directly need no curves.
#pragma once

#include <atomic>
#include <vector>

#include "transport/hints/hints.h"

namespace ajar {

struct HintSuggestion {
  std::vector<Vec3> points;  ///< the light's first
  double share = 0.0;        ///< of the difficulty found, that of the paths near this one
};

/// At most `count`, the most useful first, all of which attach. None where path tracing does well.
std::vector<HintSuggestion> suggest_hints(const Scene& scene, int count, int samples, uint32_t seed,
                                          const std::atomic<bool>* stop = nullptr);

}  // namespace ajar
