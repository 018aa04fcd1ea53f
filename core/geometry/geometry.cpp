#include "geometry/geometry.h"

namespace ajar {

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
  const float b0 = 1.0f - barycentric.x - barycentric.y;
  return element(i0) * b0 + element(i1) * barycentric.x + element(i2) * barycentric.y;
}

}  // namespace ajar
