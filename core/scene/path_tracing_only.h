// What only path tracing renders. Other techniques are replaced by it where a scene has this, and the artist is told.
#pragma once

#include <string>

#include "scene/scene.h"

namespace ajar {

/// Whether the surface scatters light or lets it pass in another way for other kinds of rays: it follows a Light Path
/// node, or its transparent parts cast shadows. A walk from a light does not know what kind of ray the path from the
/// eye would have, and how many bounces. Emission may depend on it.
bool depends_on_ray_kind(const MaterialDescription& material);
/// What the scene has that only path tracing renders, in words; empty: nothing. The scene is not built yet.
std::string path_tracing_only(const SceneDescription& description);
/// The same for a scene that is built, seen by this camera. `scene` may be null.
std::string path_tracing_only(const Scene* scene, const CameraDescription& camera, const RenderSettings& settings);

}  // namespace ajar
