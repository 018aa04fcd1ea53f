// Finds errors in a description before anything is built.
//
// Errors that can be repaired without guessing are repaired, counted and reported by the artist's name:
// - Triangles with bad indices or non-finite vertices are left out.
// - Non-finite normals and attribute values are replaced.
// - Instances with non-finite transforms are left out, as are those that are shrunk to a line or a point.
// A scene that cannot be rendered throws SceneError: it has no camera, or a camera or settings that give no image.
#pragma once

#include "description/diagnostics.h"
#include "description/scene_description.h"

namespace ajar {

struct ValidationCounts {
  uint64_t skipped_triangles = 0, repaired_values = 0, skipped_instances = 0;
};

ValidationCounts validate(SceneDescription& description, Diagnostics& diagnostics);
/// Validates the camera and the settings only.
void validate_view(const CameraDescription& camera, RenderSettings& settings);

}  // namespace ajar
