// An approximate image from a few bidirectional samples that are used for nothing else, for the importance of the film
// ["two-stage" Metropolis, Veach 1997, section 11.3.2].
//
// Chains whose target is luminance place nearly all their samples where the image is bright. The eye, and all relative
// measures of error, need the same relative error everywhere.
#pragma once

#include <atomic>

#include "transport/paths/path.h"

namespace ajar {

struct Pilot {
  FilmImportance importance;  ///< one over the image, up to a maximum
  double direct_light = 0.0;  ///< LS*E and L(D)S*E, summed over the film: an estimate for statistics
  uint64_t rays = 0;
};
/// The importance is constant when stopped, or without light.
Pilot look_ahead(const PathSpace& space, uint32_t seed, uint32_t samples, const std::atomic<bool>& stop);

}  // namespace ajar
