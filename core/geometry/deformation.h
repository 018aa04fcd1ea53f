// Shapes that change while the shutter is open.
//
// The vertices have positions at evenly spaced times and move straight between two of them, as in Embree. Strands and
// point clouds keep their shapes themselves (strands.h, points.h).
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

/// Two consecutive keys, and the share of the second at a time.
struct KeyPair {
  size_t first;
  float share;
};
inline KeyPair keys_at(float time, size_t count) {
  const float place = glm::clamp(time, 0.0f, 1.0f) * float(count - 1);
  const size_t first = glm::min(size_t(place), count - 2);
  return {first, place - float(first)};
}

/// The values at the three vertices of a triangle.
using Corners = std::array<Vec3, 3>;

struct Deformation {
  struct Key {
    std::vector<Vec3> positions;  ///< padded by one element, because Embree reads 16 bytes
    std::vector<Vec3> normals;    ///< empty: flat shading
  };
  std::vector<Key> keys;  ///< at least two

  Corners corners(UVec3 v, float time) const {
    const KeyPair at = keys_at(time, keys.size());
    return mix(keys[at.first].positions, keys[at.first + 1].positions, v, at.share);
  }
  Corners corner_normals(UVec3 v, float time) const {
    const KeyPair at = keys_at(time, keys.size());
    return mix(keys[at.first].normals, keys[at.first + 1].normals, v, at.share);
  }
  /// Bounds of the absolute coordinates of these vertices at all keys around the time, for the bounds of rounding errors.
  Vec3 reach(UVec3 v, float time) const;
  size_t memory_bytes() const;

 private:
  static Corners mix(const std::vector<Vec3>& a, const std::vector<Vec3>& b, UVec3 v, float t) {
    return {(1.0f - t) * a[v.x] + t * b[v.x], (1.0f - t) * a[v.y] + t * b[v.y], (1.0f - t) * a[v.z] + t * b[v.z]};
  }
};

/// The number of times at which a valid mesh has a shape; 0 if its shape stays as it is.
inline size_t shape_count(const MeshDescription& mesh) {
  return mesh.positions.empty() ? 0 : mesh.motion_positions.size() / mesh.positions.size();
}
/// The shapes of a valid mesh of triangles; null if it has one shape only.
std::shared_ptr<const Deformation> make_deformation(const MeshDescription& mesh);
/// A transformed copy. `normal_matrix` transforms normals.
std::shared_ptr<const Deformation> transformed(const Deformation& deformation, const Mat4& matrix,
                                               const Mat3& normal_matrix);

}  // namespace ajar
