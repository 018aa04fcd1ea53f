// The paths LS*E and L(D)S*E by themselves: light seen directly or after specular bounces, and light
// that the first other surface scatters, weighted between light and BSDF sampling (Veach 1997, section 9.2). What
// PathSpace leaves out when it is made `without_direct`. Specular bounces branch (specular_branches.h).
#pragma once

#include "transport/bidirectional/vertex_merging.h"
#include "transport/paths/walk.h"

namespace ajar {

/// Estimates at a point of the film.
struct DirectSample {
  Color radiance{0.0f};  ///< by those paths
  Color merged{0.0f};    ///< by unconnectable ones (vertex_merging.h), which begin alike
  float alpha = 0.0f;
  bool polished = false;  ///< came to delta or sharp lobes
};

/// Everything it draws comes from `sampler`, by fixed dimensions. `merging`: null where nothing shall be merged.
DirectSample trace_direct_paths(const Scene& scene, Vec2 film, Sampler& sampler, SampleAux* aux, uint64_t& rays,
                                const VertexMerging* merging);

}  // namespace ajar
