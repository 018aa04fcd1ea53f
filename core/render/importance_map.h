// What the artist said matters: a factor for each pixel of the film, for film/image_plan.h.
//
// The factor of the screen region, times the importance of the object that the ray through the pixel's centre meets
// first, times that of the pixel's light: the mean of its sources' importances (light groups, in Blender), weighted by
// how much of its brightness each is. The last is measured by a pilot of path tracing, whatever integrator renders. All
// is found without the samples of the picture, so it may decide on their number.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "scene/scene.h"

namespace ajar {

/// Whether anything matters more or less than the rest.
bool has_importance(const Scene& scene);
/// In the order of the film; empty when nothing does. `seed`: of no other samples.
std::vector<float> importance_map(const std::shared_ptr<const Scene>& scene, uint32_t seed,
                                  const std::atomic<bool>& stop);

}  // namespace ajar
