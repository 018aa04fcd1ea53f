// Light that the eye sees directly or through specular surfaces only: the paths L S* E. Integrators that separate it
// from the rest of a sample can sample it more often (further_samples.h). Specular bounces branch
// (specular_branches.h).
#pragma once

#include "sampling/sampler.h"
#include "scene/scene.h"

namespace ajar {

/// Radiance along one camera ray that continues at delta lobes only, in W / (sr m^2). Zero in a scene with media. Uses
/// the dimensions of `sampler` from number 4.
Color trace_seen_light(const Scene& scene, Ray ray, Sampler& sampler, uint64_t& rays);

}  // namespace ajar
