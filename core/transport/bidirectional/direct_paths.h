// The paths LS*E and L(D)S*E alone: light that is seen directly or after specular bounces, and light that the first
// other surface scatters, weighted between light and BSDF sampling (Veach 1997, section 9.2). A PathSpace that is
// `without_direct` leaves them out. Specular bounces branch (specular_branches.h).
#pragma once

#include "transport/bidirectional/vertex_merging.h"
#include "transport/paths/light_passes.h"
#include "transport/paths/walk.h"

namespace ajar {

/// Estimates at a point of the film.
struct DirectSample {
  Color radiance{0.0f};  ///< by direct paths
  Color merged{0.0f};    ///< by unconnectable paths (vertex_merging.h), which start in the same way
  float alpha = 0.0f;
  bool polished = false;  ///< the sample reached delta or sharp lobes
};

/// All random numbers come from fixed dimensions of `sampler`. `merging`: null for no merging. `passes`: null, or it
/// receives the light by the passes of the film, and the albedo of the first surface.
DirectSample trace_direct_paths(const PathScene& where, Vec2 film, Sampler& sampler, SampleAux* aux, uint64_t& rays,
                                const VertexMerging* merging, LightPasses* passes);

}  // namespace ajar
