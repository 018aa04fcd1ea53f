#include "geometry/geometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ajar {

BuiltMesh take_mesh(MeshDescription&& d) {
  BuiltMesh mesh;
  mesh.name = std::move(d.name);
  if (!d.strands.empty()) {
    mesh.strands = make_strands(d);
    for (uint32_t i = 0; !d.material_slots.empty() && i < mesh.strands->segment_count(); ++i)
      mesh.material_slots.push_back(d.material_slots[mesh.strands->strand_of(i)]);
  } else if (d.is_points()) {
    mesh.points = make_points(d);
  } else {
    mesh.deformation = make_deformation(d);
    for (std::vector<Vec3>* used : {&d.motion_positions, &d.motion_normals}) std::vector<Vec3>().swap(*used);
  }
  if (!mesh.has_triangles()) std::vector<Vec3>().swap(d.positions);
  mesh.positions = std::move(d.positions);
  mesh.positions.push_back(Vec3(0.0f));
  mesh.triangles = std::move(d.triangles);
  if (!mesh.strands) mesh.material_slots = std::move(d.material_slots);
  mesh.normal_domain = d.normal_domain;
  mesh.normals = std::move(d.normals);
  mesh.attributes = std::move(d.attributes);
  for (VolumeGrid& grid : d.grids) mesh.grids.emplace_back(std::move(grid));
  mesh.density_in_object_space = d.density_in_object_space;
  if (const VolumeFlow& flow = d.flow; flow.scale != 0.0f && mesh.find_grid(flow.velocity)) {
    mesh.velocity = int(mesh.find_grid(flow.velocity) - mesh.grids.data());
    mesh.flow_scale = flow.scale;
    mesh.flow_frame = flow.frame;
  }
  mesh.source = std::move(d.shared);
  mesh.texture_space_location = d.texture_space_location;
  mesh.texture_space_size = d.texture_space_size;
  mesh.active_uv = mesh.find_attribute(d.active_uv);
  mesh.undeformed_position = mesh.find_attribute(kUndeformedPosition);
  return mesh;
}

size_t BuiltMesh::memory_bytes() const {
  size_t bytes = positions.size() * sizeof(Vec3) + triangles.size() * sizeof(UVec3) +
                 material_slots.size() * sizeof(uint16_t) + normals.size() * sizeof(Vec3);
  for (const Attribute& attribute : attributes) bytes += attribute.values.size() * sizeof(float);
  for (const VoxelGrid& grid : grids) bytes += grid.memory_bytes();
  if (strands) bytes += strands->memory_bytes();
  if (points) bytes += points->memory_bytes();
  if (deformation) bytes += deformation->memory_bytes();
  if (undisplaced) {
    bytes += (undisplaced->positions.size() + undisplaced->normals.size()) * sizeof(Vec3);
    for (const Attribute& tangent : undisplaced->tangents) bytes += tangent.values.size() * sizeof(float);
  }
  return bytes;
}

int BuiltMesh::find_attribute(const std::string& attribute_name) const {
  for (size_t i = 0; i < attributes.size(); ++i) {
    if (attributes[i].name == attribute_name) return int(i);
  }
  return -1;
}

const VoxelGrid* BuiltMesh::find_grid(const std::string& grid_name) const {
  for (const VoxelGrid& grid : grids)
    if (grid.name() == grid_name) return &grid;
  return nullptr;
}

Vec4 BuiltMesh::interpolate(const Attribute& attribute, uint32_t triangle, Vec2 barycentric) const {
  const auto element = [&](size_t index) {
    const float* v = attribute.values.data() + index * size_t(attribute.components);
    Vec4 value(0.0f, 0.0f, 0.0f, 1.0f);
    for (int c = 0; c < attribute.components; ++c) value[c] = v[c];
    return value;
  };
  if (strands) {
    if (attribute.domain == Domain::Face) return element(strands->strand_of(triangle));
    const uint32_t point = strands->point_of(triangle);
    return element(point) * (1.0f - barycentric.x) + element(point + 1) * barycentric.x;
  }
  if (attribute.domain == Domain::Face || points) return element(triangle);
  size_t i0 = size_t(triangle) * 3, i1 = i0 + 1, i2 = i0 + 2;
  if (attribute.domain == Domain::Vertex) {
    const UVec3 v = triangles[triangle];
    i0 = v.x, i1 = v.y, i2 = v.z;
  }
  const float b1 = barycentric.x, b2 = barycentric.y, b0 = 1.0f - b1 - b2;
  const float* const values = attribute.values.data();
  if (attribute.components == 2) {
    const float *const v0 = values + i0 * 2, *const v1 = values + i1 * 2, *const v2 = values + i2 * 2;
    return {v0[0] * b0 + v1[0] * b1 + v2[0] * b2, v0[1] * b0 + v1[1] * b1 + v2[1] * b2, 0.0f, b0 + b1 + b2};
  }
  return element(i0) * b0 + element(i1) * b1 + element(i2) * b2;
}

Vec3 before_flow(const BuiltMesh& mesh, const BuiltInstance& instance, Vec3 position, float time) {
  const float scale = mesh.flow_scale * (time - mesh.flow_frame);
  if (mesh.velocity < 0 || scale == 0.0f) return position;
  Mat4 moved, moved_inverse;
  const Mat4& world = world_from_object(instance, time, moved);
  const Mat4& inverse = object_from_world(instance, time, moved_inverse);
  const auto back = [&](Vec3 from) {
    const Vec4 u = mesh.grids[size_t(mesh.velocity)].at(transform_point(inverse, from));
    return position - scale * transform_vector(world, Vec3(u));
  };
  return back(back(position));
}

Vec3 farthest_flow(const BuiltMesh& mesh, const BuiltInstance& instance) {
  if (mesh.velocity < 0) return Vec3(0.0f);
  const float time = std::max(mesh.flow_frame, 1.0f - mesh.flow_frame);
  const Vec3 fastest = mesh.grids[size_t(mesh.velocity)].largest();
  Vec3 farthest(0.0f);
  for (uint32_t key = 0; key < std::max(instance.motion_count, 1u); ++key) {
    const Mat4& world = instance.motion ? instance.motion[key] : instance.world_from_object;
    farthest = glm::max(farthest, glm::abs(Vec3(world[0])) * fastest.x + glm::abs(Vec3(world[1])) * fastest.y +
                                      glm::abs(Vec3(world[2])) * fastest.z);
  }
  return time * std::abs(mesh.flow_scale) * farthest;
}

}  // namespace ajar
