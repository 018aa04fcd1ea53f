// Adaptive subdivision of the meshes of a scene, before anything is built.
#pragma once

#include <atomic>

#include "description/diagnostics.h"
#include "description/scene_description.h"
#include "geometry/subdivision/dice.h"

namespace ajar {

/// How finely a mesh is divided: as its instances need it that show it in the most detail.
DicingRate dicing_rate_of(const SceneDescription& d, size_t mesh, const PixelSize& pixels);
/// The pixels that adaptive subdivision of the scene follows.
PixelSize dicing_pixels(const SceneDescription& d);
bool has_subdivision(const SceneDescription& d);

/// Replaces the faces of meshes with adaptive subdivision by triangles. If there would be too many for the memory of
/// this machine, the triangles are larger, and that is reported.
void dice_meshes(SceneDescription& d, Diagnostics& diagnostics, const std::atomic<bool>* stop);

}  // namespace ajar
