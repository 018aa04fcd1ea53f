// Values of the Geometry node that depend on a whole mesh. The exporter computes them once. They follow the definitions
// of Cycles: islands are equal to the bit, pointiness within rounding.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/types.h"

namespace ajar {

/// Names of the attributes that hold these values.
inline constexpr const char* kRandomPerIsland = ".random_per_island";
inline constexpr const char* kPointiness = ".pointiness";

/// An edge's two vertices.
using MeshEdge = glm::u32vec2;

/// A number in [0, 1] for each vertex, equal for all connected vertices. Edges with invalid vertices are ignored.
std::vector<float> random_per_island(size_t vertex_count, std::span<const MeshEdge> edges);

/// For each vertex, the angle between its normal and the mean direction of its edges: 0 to 1 for 0 to 180 degrees (0.5
/// is flat), averaged with its neighbours. Vertices at the same position count as one.
std::vector<float> pointiness(std::span<const Vec3> positions, std::span<const Vec3> normals,
                              std::span<const MeshEdge> edges);

}  // namespace ajar
