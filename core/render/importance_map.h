// The importance of each pixel of the film, as set by the artist, for film/image_plan.h. It is the product of:
// - the factor of the screen region;
// - the importance of the object that the ray through the centre of the pixel hits first;
// - the importance of the light of the pixel: the mean of the importances of its sources (light groups, in Blender),
//   weighted by their parts of the pixel's luminance. A pilot of path tracing measures it for all integrators.
// The samples of the image are not used, so the importance may decide on their number.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "scene/scene.h"

namespace ajar {

/// Whether any importance is not 1.
bool has_importance(const Scene& scene);
/// In the order of the film; empty if all are 1. `seed` must not be that of other samples.
std::vector<float> importance_map(const std::shared_ptr<const Scene>& scene, uint32_t seed,
                                  const std::atomic<bool>& stop);

}  // namespace ajar
