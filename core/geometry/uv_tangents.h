// Smooth tangents along the u axis of a UV map: the tangent space of Mikkelsen 2008 ("Simulation of Wrinkled Surfaces
// Revisited"), which Cycles uses for normal maps, for a mesh of triangles.
//
// Corners with the same position, normal and coordinates are one vertex. The triangles around a vertex that are
// connected by edges and have the same orientation in the UV map form a group. Its tangent is the mean of the
// triangles' tangents, projected to the plane of the normal and weighted by the angle at the vertex. A triangle without
// an area in the UV map belongs to the first group that reaches it, and adds nothing to the tangent.
#pragma once

#include <span>
#include <vector>

#include "math/types.h"

namespace ajar {

/// Attributes of corners with this name and that of a UV map hold the results; without the latter, of the active one.
inline constexpr const char* kTangentOf = ".tangent:";

/// For each corner, the tangent in object space and the sign of the bitangent (1 or -1). `normals` and `uvs` are per
/// corner; empty `uvs`: coordinates on a sphere around the origin. Corners that no triangle with an area in the UV map
/// reaches have the x axis and -1, as in Cycles.
std::vector<Vec4> uv_tangents(std::span<const Vec3> positions, std::span<const UVec3> triangles,
                              std::span<const Vec3> normals, std::span<const Vec2> uvs);

}  // namespace ajar
