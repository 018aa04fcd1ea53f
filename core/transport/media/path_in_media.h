// The state of a path in media. Code that is compiled with and without media takes one of these types.
#pragma once

#include "math/random.h"
#include "transport/media/media.h"

namespace ajar {

/// What the paths of a thread count.
struct PathCounters {
  uint64_t rays = 0, paths = 0;
  MediaCounters media;
};

/// For scenes without media.
struct NoMedia {
  static constexpr bool kThere = false;
};
/// State of a path in media.
struct InMedia {
  static constexpr bool kThere = true;
  const Media& media;
  MediaCounters& counters;
  Pcg32 rng;
  MediaStack stack;
  int depth = 0, stretch = 0, bounds = 0;
  bool chose = false;       ///< a phase function chose the present direction
  LightStretch chosen_for;  ///< the part of a ray for which lights were then chosen
};

}  // namespace ajar
