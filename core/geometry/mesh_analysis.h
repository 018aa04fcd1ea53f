// What the Geometry node asks of a whole mesh, computed once when it is exported: Cycles' definitions, to the bit for
// islands and within rounding for pointiness.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/types.h"

namespace ajar {

/// Names of the attributes under which a mesh carries them.
inline constexpr const char* kRandomPerIsland = ".random_per_island";
inline constexpr const char* kPointiness = ".pointiness";

/// An edge's two vertices.
using MeshEdge = glm::u32vec2;

/// For each vertex a number in [0, 1] that all vertices connected with it share. Edges of vertices that do not exist
/// are ignored.
std::vector<float> random_per_island(size_t vertex_count, std::span<const MeshEdge> edges);

/// For each vertex how far it stands out: the angle between its normal and the mean direction of its edges, 0 to 1 for
/// 0 to 180 degrees (0.5 is flat), averaged with its neighbours. Vertices in the same place count as one.
std::vector<float> pointiness(std::span<const Vec3> positions, std::span<const Vec3> normals,
                              std::span<const MeshEdge> edges);

}  // namespace ajar
