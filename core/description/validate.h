// What is wrong with a description, found before anything is built.
//
// Whatever can be rendered without guessing is repaired, counted and reported by the artist's name:
// triangles with bad indices or non-finite vertices are left out, non-finite normals and attribute values
// replaced, instances with non-finite transforms left out, as are those shrunk to a line or a point. What cannot be
// rendered throws SceneError: no camera, a camera or settings that make no picture.
#pragma once

#include "description/diagnostics.h"
#include "description/scene_description.h"

namespace ajar {

struct ValidationCounts {
  uint64_t skipped_triangles = 0, repaired_values = 0, skipped_instances = 0;
};

ValidationCounts validate(SceneDescription& description, Diagnostics& diagnostics);
/// The part of it that concerns how the scene is looked at.
void validate_view(const CameraDescription& camera, RenderSettings& settings);

}  // namespace ajar
