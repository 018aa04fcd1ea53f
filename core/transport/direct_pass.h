// Direct light of the whole film, for integrators whose chains or populations leave it out.
#pragma once

#include <atomic>

#include "film/film.h"
#include "transport/path.h"
#include "transport/vertex_merging.h"

namespace ajar {

/// Samples first .. first + samples - 1 of every pixel (direct_paths.h), with alpha and passes; returns the rays traced. Pixels that
/// `stop` leaves out have had none. Where merging is active each sample has a pass of its photons, and their light in it.
uint64_t add_direct_samples(Film& film, const PathSpace& space, uint32_t seed, uint32_t first, int samples, VertexMerging& merging,
                            const std::atomic<bool>& stop);

}  // namespace ajar
