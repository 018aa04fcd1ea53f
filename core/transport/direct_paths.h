// The paths LS*E and L(D)S*E by themselves: light seen directly or after specular bounces, and light
// that the first other surface scatters, weighted between light and BSDF sampling (Veach 1997, section 9.2). What
// PathSpace leaves out when it is made `without_direct`.
#pragma once

#include "transport/vertex_merging.h"
#include "transport/walk.h"

namespace ajar {

/// Estimate of that part of the radiance through a film point. Everything it draws comes from `sampler` in a fixed order. With `merging`, also of
/// what unconnectable paths bring (vertex_merging.h): they begin alike.
Color trace_direct_paths(const Scene& scene, Vec2 film, Sampler& sampler, SampleAux* aux, float& alpha, uint64_t& rays, const VertexMerging* merging = nullptr);

}  // namespace ajar
