// The memory of a render, predicted from its description. A scene that needs too much is refused before anything is
// built.
//
// The prediction counts the arrays whose size depends on the scene. Meshes, textures and the film are exact. Photons
// count with their average memory, ray tracing structures with the maximum that was measured for Embree
// (docs/manual/memory.md has the numbers). Not counted are Blender's own copy of the scene, the libraries, shaders,
// lights, and data with a bound that does not depend on the scene (caches of shares, lookups of photon maps).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

/// Upper bounds of the memory that Embree allocates for its acceleration structures. The allocation depends on the
/// instruction set, the number of threads and the shapes. Measured with SSE4.2, AVX, AVX2 and AVX-512 and 1 to 64
/// threads: 54 to 84 bytes per triangle (meshes, and separate triangles of any size; 28 to 39 with a compact structure), 116 to 126 bytes per segment of
/// hair, 21 to 33 bytes per point of a cloud. The bounds are 14 % above the maximum. An instance has 73 to 150 bytes of tree and an object on the heap that
/// Embree does not count (`make bench` measures the sum).
inline constexpr uint64_t kStructureBytesPerTriangle = 96, kCompactBytesPerTriangle = 48,
                          kStructureBytesPerSegment = 144, kStructureBytesPerPoint = 38,
                          kStructureBytesPerInstance = 440, kStructureBytesPerMesh = 1500;
/// Maximum number of photons that a photon path or a step of a chain leaves, in scenes that are not all white.
inline constexpr uint64_t kPhotonsPerPath = 4;
/// Bytes of a photon in its map, in the list from which the next map is made, and in the order of its tree.
inline constexpr uint64_t kBytesPerPhoton = 32 + 36 + 24 + 4;

struct MemoryPart {
  std::string what;  ///< such as "geometry"
  uint64_t bytes = 0;
  std::string largest;  ///< name of its largest item; may be empty
  uint64_t largest_bytes = 0;
};

struct MemoryEstimate {
  std::vector<MemoryPart> parts;  ///< in descending order
  uint64_t bytes() const;
};

MemoryEstimate estimate_memory(const SceneDescription& description);
/// Throws SceneError with the names of the largest items if the settings have a limit and the scene needs more.
void check_memory_limit(const SceneDescription& description);

}  // namespace ajar
