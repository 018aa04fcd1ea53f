// A SceneDescription in one file: the bug report, the benchmark input and the unit of distribution.
//
// Little-endian binary: magic "AJARSCN" and the version, then every field in the order of scene_description.h, arrays
// as a 64-bit count followed by their elements. Reading checks every count against what is left of the file and what
// its elements take there at the least, so a damaged file gives SceneError, never a crash or a huge allocation.
#pragma once

#include <string>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

void save_description(const SceneDescription& description, const std::string& path);
SceneDescription load_description(const std::string& path);

/// A number for everything but camera and settings, save those of caustics: scenes of equal number render alike through
/// one camera. Shared meshes count by identity.
uint64_t fingerprint(const SceneDescription& description);
uint64_t fingerprint(const NodeGraph& graph);
uint64_t fingerprint(const MaterialDescription& material);

/// `version`: as an older program reads it, without the fields that came later; 0 is the newest.
std::vector<char> to_bytes(const SceneDescription& description, char version = 0);
SceneDescription from_bytes(const std::vector<char>& bytes);

}  // namespace ajar
