// The scene with which shadow catchers are compared (film/caught_light.h).
#pragma once

#include <optional>

#include "description/scene_description.h"

namespace ajar {

/// The scene without the objects that are no shadow catchers. Lamps and the world stay.
SceneDescription catchers_alone(const SceneDescription& description);

/// Where a path from the camera meets a shadow catcher.
struct CaughtPath {
  bool caught = false;
  Color before{0.0f}, throughput{1.0f};  ///< the light before, and the throughput there
  float alpha_before = 0.0f;
  Color sees_background{0.0f};    ///< throughput with which the path leaves the scene unscattered
  std::optional<Ray> past_glass;  ///< the ray to the catcher, if the camera sees it through clear glass
};

}  // namespace ajar
