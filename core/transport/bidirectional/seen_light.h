// Light that the eye sees directly or by way of specular surfaces alone, the paths L S* E, for integrators that take it
// apart from the rest of a sample, to look for it more often (further_samples.h). Specular bounces branch
// (specular_branches.h).
#pragma once

#include "sampling/sampler.h"
#include "scene/scene.h"

namespace ajar {

/// Light found by one camera ray that goes on at delta lobes only; W / (sr m^2). Nothing in a scene with media. Draws
/// from dimension 4 of `sampler`.
Color trace_seen_light(const Scene& scene, Ray ray, Sampler& sampler, uint64_t& rays);

}  // namespace ajar
