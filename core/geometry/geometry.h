// Meshes and instances in the built scene.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "description/scene_description.h"
#include "geometry/deformation.h"
#include "geometry/motion.h"
#include "geometry/points.h"
#include "geometry/strands.h"
#include "geometry/voxel_grid.h"

namespace ajar {

/// A surface before its displacement, in the space of the displaced positions; see BuiltMesh for the fields.
struct Undisplaced {
  std::vector<Vec3> positions, normals;
  std::vector<Attribute> tangents;  ///< smooth tangents (uv_tangents.h), in object space
};

/// A triangle mesh, strands or a point cloud, shared by its instances. If only one instance uses it, its positions and normals can be
/// in world space (`baked`), which saves Embree an instance.
struct BuiltMesh {
  std::string name;
  std::vector<Vec3> positions;  ///< padded by one element, because Embree reads 16 bytes
  std::vector<UVec3> triangles;
  std::vector<uint16_t> material_slots;
  Domain normal_domain = Domain::Corner;
  std::vector<Vec3> normals;  ///< empty: flat shading
  std::vector<Attribute> attributes;
  int active_uv = -1;            ///< index into attributes
  int undeformed_position = -1;  ///< index into attributes
  Vec3 texture_space_location{0.0f}, texture_space_size{1.0f};
  bool baked = false;      ///< positions are in world space
  bool crowded = false;    ///< rays meet triangles of its instances in world space (instance_crowds.h)
  bool displaced = false;  ///< vertices were moved by the materials (scene/displace.h)
  bool divided = false;    ///< some vertices are at the same place, with different values (shared_corners.h)
  /// Null: no material bends the normals of the surface before the displacement.
  std::shared_ptr<const Undisplaced> undisplaced;
  /// One of these, or null for triangles. Then there are neither positions nor normals, and slots are per segment or per
  /// point.
  std::shared_ptr<const Strands> strands;
  std::shared_ptr<const Points> points;
  /// Of triangles, in the space of the positions; null: the shape stays as it is while the shutter is open. Strands and
  /// points have their own.
  std::shared_ptr<const Deformation> deformation;
  std::vector<VoxelGrid> grids;                   ///< of the volume inside; in object space, also if the mesh is baked
  bool density_in_object_space = false;           ///< see MeshDescription
  int velocity = -1;                              ///< index of a grid; -1: the volume does not flow
  float flow_scale = 0.0f, flow_frame = 0.5f;     ///< see VolumeFlow
  std::shared_ptr<const MeshDescription> source;  ///< the description it was built from, if later scenes can share it
  std::shared_ptr<void> structure;  ///< Embree's structure of a mesh that is not baked; accel.cpp knows its type
  size_t memory_bytes() const;
  bool has_triangles() const { return !strands && !points; }
  bool empty() const { return triangles.empty() && has_triangles(); }
  /// Whether its shape changes while the shutter is open.
  bool deforms() const {
    return deformation || (strands && !strands->motion.empty()) || (points && !points->motion.empty());
  }
  /// Positions of the vertices of a triangle at a time of the shutter interval.
  Corners corners(uint32_t triangle, float time) const {
    const UVec3 v = triangles[triangle];
    if (deformation) [[unlikely]]
      return deformation->corners(v, time);
    return {positions[v.x], positions[v.y], positions[v.z]};
  }
  /// Shading normals at the vertices of a triangle. There must be some.
  Corners corner_normals(uint32_t triangle, float time) const {
    const UVec3 v = normal_domain == Domain::Vertex ? triangles[triangle]
                                                    : UVec3(3 * triangle, 3 * triangle + 1, 3 * triangle + 2);
    if (deformation) [[unlikely]]
      return deformation->corner_normals(v, time);
    return {normals[v.x], normals[v.y], normals[v.z]};
  }

  /// Index of the attribute with this name, or -1.
  int find_attribute(const std::string& attribute_name) const;
  /// The grid with this name, or null.
  const VoxelGrid* find_grid(const std::string& grid_name) const;
  /// Value at a place on a triangle, on a segment or on a point of a cloud; missing components are 0 (alpha 1).
  Vec4 interpolate(const Attribute& attribute, uint32_t triangle, Vec2 barycentric) const;
};

/// Moves a valid description to a built mesh, in object space.
BuiltMesh take_mesh(MeshDescription&& description);

struct BuiltInstance {
  Mat4 world_from_object{1.0f}, object_from_world{1.0f};
  uint32_t mesh = 0;
  uint32_t object = 0;          ///< index into SceneDescription::objects
  uint32_t first_material = 0;  ///< index into the slot table of Scene
  uint32_t material_count = 0;
  uint32_t first_light = ~0u;  ///< of its emissive triangles, or ~0
  uint32_t visibility = kVisibleAll;
  float random = 0.0f;
  bool flips_orientation = false;          ///< negative determinant
  const InstanceOrigin* origin = nullptr;  ///< null: all its numbers are 0
  const Vec4* values = nullptr;            ///< its row of InstanceValues; null: it has none
  /// world_from_object at evenly spaced times while the shutter is open; null: no motion
  const Mat4* motion = nullptr;
  uint32_t motion_count = 0;
  uint32_t first_frame = ~0u;  ///< in Scene::frames: world_from_object one frame before and one after; ~0: no motion
};

/// The transform at a time of the shutter interval; `moved` is the storage for the transform of a moving instance.
inline const Mat4& world_from_object(const BuiltInstance& instance, float time, Mat4& moved) {
  if (!instance.motion) return instance.world_from_object;
  interpolate_straight(instance.motion, instance.motion_count, time, moved);
  return moved;
}
inline const Mat4& object_from_world(const BuiltInstance& instance, float time, Mat4& moved) {
  if (!instance.motion) return instance.object_from_world;
  interpolate_straight(instance.motion, instance.motion_count, time, moved);
  moved = glm::affineInverse(moved);
  return moved;
}

/// Where the grids have what an instance of a volume shows at a time of the shutter interval, in world space (VolumeFlow).
Vec3 before_flow(const BuiltMesh& mesh, const BuiltInstance& instance, Vec3 position, float time);
/// How far the volume flows at most along each axis while the shutter is open, in world space.
Vec3 farthest_flow(const BuiltMesh& mesh, const BuiltInstance& instance);

}  // namespace ajar
