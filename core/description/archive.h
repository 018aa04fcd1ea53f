// A SceneDescription in one file, for bug reports and benchmarks and to distribute a render.
//
// The format is little-endian binary: the magic "AJARSCN" and the version, then every field in the order of
// scene_description.h. An array is a 64-bit count followed by its elements. Reading compares every count with the rest
// of the file and the minimum size of the elements, so a damaged file gives a SceneError, never a crash or a huge
// allocation.
#pragma once

#include <string>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

void save_description(const SceneDescription& description, const std::string& path);
SceneDescription load_description(const std::string& path);

/// A hash of everything but the camera and the settings; the settings of caustics and of the bump terminator are
/// included. Scenes with equal hashes give equal images with the same camera. A shared mesh is hashed by its address.
uint64_t fingerprint(const SceneDescription& description);
/// A hash of the camera and of the settings that define the image: filter, bounces, clamping, passes' parameters. How the
/// image is estimated is not in it: samples, seed, technique.
uint64_t view_fingerprint(const CameraDescription& camera, const RenderSettings& settings);
uint64_t fingerprint(const NodeGraph& graph);
uint64_t fingerprint(const MaterialDescription& material);
uint64_t fingerprint(const ColorDescription& color);

/// `version` selects an older format, without the fields that were added later; 0 is the newest.
std::vector<char> to_bytes(const SceneDescription& description, char version = 0);
SceneDescription from_bytes(const std::vector<char>& bytes);

}  // namespace ajar
