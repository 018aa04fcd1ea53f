// What only path tracing renders. Other techniques are replaced by it where a scene has this, and the artist is told.
#pragma once

#include <string>

#include "scene/scene.h"

namespace ajar {

/// What the scene has that only path tracing renders, in words; empty: nothing. The scene is not built yet.
std::string path_tracing_only(const SceneDescription& description);
/// The same for a scene that is built, seen by this camera. `scene` may be null.
std::string path_tracing_only(const Scene* scene, const CameraDescription& camera, const RenderSettings& settings);

}  // namespace ajar
