// What the artist said matters: a factor for each pixel of the film, for film/image_plan.h.
//
// The factor of the screen region, times the importance of the object that the ray through the pixel's centre meets first.
// It is found without the samples of the picture, so it may decide on their number.
#pragma once

#include <vector>

#include "scene/scene.h"

namespace ajar {

/// In the order of the film; empty when nothing matters more than the rest.
std::vector<float> importance_map(const Scene& scene);

}  // namespace ajar
