// What a render will keep in memory, from its description alone: to be refused before anything is built, not to fail half way.
//
// Counted are the arrays whose size the scene decides. Meshes, textures and the film are counted to the byte, ray tracing structures and
// photons by what they take on average (docs/manual/memory.md has the numbers). Not counted: Blender's own copy of the scene, the libraries
// themselves, shaders, lights, and what is bounded whatever the scene (caches of shares, lookups of photon maps).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene_description.h"

namespace ajar {

/// Of Embree's structures: measured by `tests/core/test_memory_estimate.cpp`.
inline constexpr uint64_t kStructureBytesPerTriangle = 62, kStructureBytesPerSegment = 100, kStructureBytesPerInstance = 440, kStructureBytesPerMesh = 1500;
/// Photons that a photon path leaves, and a step of a chain, at most in scenes that are not all white.
inline constexpr uint64_t kPhotonsPerPath = 4;
/// A photon in its map, in the list that the next map is made from, and in the order of its tree.
inline constexpr uint64_t kBytesPerPhoton = 32 + 32 + 16 + 4;

struct MemoryPart {
  std::string what;        ///< "geometry"
  uint64_t bytes = 0;
  std::string largest;     ///< what of it takes most, by the artist's name; may be empty
  uint64_t largest_bytes = 0;
};

struct MemoryEstimate {
  std::vector<MemoryPart> parts;   ///< the largest first
  uint64_t bytes() const;
};

MemoryEstimate estimate_memory(const SceneDescription& description);
/// Throws SceneError, which names what is largest, when the settings set a limit and the scene needs more.
void check_memory_limit(const SceneDescription& description);

}  // namespace ajar
