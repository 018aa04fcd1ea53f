// Vertices that move before rays are traced: true displacement by the materials, and the boundaries of media.
#pragma once

#include <atomic>
#include <cstddef>
#include <span>
#include <vector>

#include "geometry/geometry.h"
#include "shading/shader_program.h"

namespace ajar {

/// For each mesh, whether materials may move its vertices.
std::vector<bool> moved_meshes(const SceneDescription& description);

/// Moves each vertex of `mesh` by the displacement of the first of its triangles whose material has one, as Cycles does.
/// The shader sees the mesh in `instance`, where it does not move, with smooth normals. Each program of `programs` that
/// `materials` lists belongs to a slot.
///
/// With the method Displacement, the smooth normals become those of the moved surface; flat faces stay flat. With Both,
/// the shader bends the normals of the surface before the displacement (`BuiltMesh::undisplaced`). Generated coordinates
/// stay those of the original positions. Smooth tangents are computed again.
///
/// Returns the number of vertices whose displacement is not finite. They stay where they are. If `stop` becomes true,
/// the mesh is left in an undefined state.
size_t displace(BuiltMesh& mesh, const BuiltInstance& instance, const ObjectDescription& object,
                std::span<const uint32_t> materials, const std::vector<ShaderProgram>& programs,
                const std::atomic<bool>* stop);

/// Moves the boundaries of media outwards by a little more than rounding, each mesh by another distance: fog often ends
/// exactly on a floor, or two media on each other, and a ray that met both at once would pass one of them. Meshes with
/// visible surfaces, volume objects, hair and points stay as they are. `material_table`: materials of the slots of instances.
void widen_media(std::vector<BuiltMesh>& meshes, const std::vector<BuiltInstance>& instances,
                 std::span<const uint32_t> material_table, const std::vector<ShaderProgram>& programs);

}  // namespace ajar
