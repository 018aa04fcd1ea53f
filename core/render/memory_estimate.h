// What a render will keep in memory, from its description alone: to be refused before anything is built, not to fail
// half way.
//
// Counted are the arrays whose size the scene decides. Meshes, textures and the film are counted to the byte, photons
// by what they take on average, ray tracing structures by the most that Embree was seen to take (docs/manual/memory.md
// has the numbers). Not counted: Blender's own copy of the scene, the libraries themselves, shaders, lights, and what
// is bounded whatever the scene (caches of shares, lookups of photon maps).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

/// Upper bounds on what Embree allocates for its acceleration structures. The allocation depends on the instruction
/// set, the number of threads and the shapes. Measured with SSE4.2, AVX, AVX2 and AVX-512 and 1 to 64 threads: 54 to 84
/// bytes a triangle (meshes, and separate triangles of any size), 116 to 126 a segment of hair. The bounds are 14 %
/// above the largest. An instance is 73 to 150 bytes of tree and an object that Embree takes from the heap without
/// counting it (`make bench` measures the sum).
inline constexpr uint64_t kStructureBytesPerTriangle = 96, kStructureBytesPerSegment = 144,
                          kStructureBytesPerInstance = 440, kStructureBytesPerMesh = 1500;
/// Photons that a photon path leaves, and a step of a chain, at most in scenes that are not all white.
inline constexpr uint64_t kPhotonsPerPath = 4;
/// A photon in its map, in the list that the next map is made from, and in the order of its tree.
inline constexpr uint64_t kBytesPerPhoton = 32 + 32 + 16 + 4;

struct MemoryPart {
  std::string what;  ///< "geometry"
  uint64_t bytes = 0;
  std::string largest;  ///< what of it takes most, by the artist's name; may be empty
  uint64_t largest_bytes = 0;
};

struct MemoryEstimate {
  std::vector<MemoryPart> parts;  ///< the largest first
  uint64_t bytes() const;
};

MemoryEstimate estimate_memory(const SceneDescription& description);
/// Throws SceneError, which names what is largest, when the settings set a limit and the scene needs more.
void check_memory_limit(const SceneDescription& description);

}  // namespace ajar
