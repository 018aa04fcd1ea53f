// The scene with which shadow catchers are compared (film/caught_light.h).
#pragma once

#include "description/scene_description.h"

namespace ajar {

/// The scene without the objects that are no shadow catchers. Lamps and the world stay.
SceneDescription catchers_alone(const SceneDescription& description);

}  // namespace ajar
