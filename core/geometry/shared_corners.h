// Values of corners as values of vertices.
//
// Nearly all corners around a vertex have the same UVs and the same normal. They are stored once, with the vertex. Where they
// differ (at the seams of a map, at sharp edges), the vertex is divided into one for each set of values. So a triangle
// needs 12 bytes for its vertices and has no values of its own.
#pragma once

#include "geometry/geometry.h"

namespace ajar {

/// Stores the normals and attributes of corners with the vertices, each where this takes less memory. All lookups by
/// triangles give the same values. Only for meshes that do not change their shape: neither moving nor displaced.
void share_corners(BuiltMesh& mesh);

}  // namespace ajar
