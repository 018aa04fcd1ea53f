// Suggestions for hints: groups of paths that path tracing finds too rarely.
//
// A pilot pass draws bidirectional samples. A path of contribution f that path tracing finds with density p adds f/p
// times its energy to the second moment of path tracing. Paths are chosen in proportion to this product. f/p is bounded
// by a quantile, so that no single path dominates. A chosen path with many others near it, vertex by vertex, is
// suggested as a curve from the light to the last rough surface before the eye. Light from infinity and direct light
// need no curves.
#pragma once

#include <atomic>
#include <vector>

#include "transport/hints/hints.h"

namespace ajar {

struct HintSuggestion {
  std::vector<Vec3> points;  ///< from the light
  double share = 0.0;        ///< part of the difficulty that belongs to the paths near this one
};

/// At most `count` suggestions that can be attached, the most useful first. Empty where path tracing is efficient.
std::vector<HintSuggestion> suggest_hints(const Scene& scene, int count, int samples, uint32_t seed,
                                          const std::atomic<bool>* stop = nullptr);

}  // namespace ajar
