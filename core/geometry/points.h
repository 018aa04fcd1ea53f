// Point clouds: spheres, many in one geometry.
//
// A ray hits a sphere (Hit::primitive) from outside only, as in Cycles: a ray that leaves a sphere inwards passes through
// it. An instance with a scale that differs between the axes shows ellipsoids.
#pragma once

#include <memory>
#include <vector>

#include "geometry/deformation.h"

namespace ajar {

struct Points {
  std::vector<Vec4> spheres;  ///< centre and radius; a radius of -1: the point is invisible
  /// `spheres` at evenly spaced times while the shutter is open; empty: they do not move
  std::vector<std::vector<Vec4>> motion;

  /// The sphere of a point at a time of the shutter interval.
  Vec4 sphere(uint32_t point, float time) const {
    if (motion.empty()) return spheres[point];
    const KeyPair at = keys_at(time, motion.size());
    return (1.0f - at.share) * motion[at.first][point] + at.share * motion[at.first + 1][point];
  }
  size_t memory_bytes() const { return spheres.size() * (1 + motion.size()) * sizeof(Vec4); }
};

/// `mesh` must be a valid point cloud.
std::shared_ptr<const Points> make_points(const MeshDescription& mesh);
/// Whether the transform scales all axes alike, so that spheres stay spheres.
bool scales_evenly(const Mat4& m);
/// A transformed copy. The transform must scale all axes alike.
std::shared_ptr<const Points> transformed(const Points& points, const Mat4& matrix);

/// Direction from the centre to the place where a ray, which hits the sphere, enters it; of unit length. The ray may come
/// from far away.
Vec3 entry_of_sphere(Vec4 sphere, Vec3 origin, Vec3 direction);

}  // namespace ajar
