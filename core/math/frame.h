// An orthonormal basis around a normal: local z is the normal.
// Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited"; its seam, where the basis turns from one normal
// to the next, is moved off the equator, on which the normals of all upright walls lie but for rounding. Normals of
// floors, walls and ceilings are away from it.
#pragma once

#include <algorithm>

#include "math/types.h"

namespace ajar {

struct Frame {
  Vec3 s{1, 0, 0}, t{0, 1, 0}, n{0, 0, 1};

  Frame() = default;
  explicit Frame(Vec3 normal) : n(normal) {
    constexpr float kSeam = -0.6f;
    const float sign = n.z < kSeam ? -1.0f : 1.0f;
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    s = Vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    t = Vec3(b, sign + n.y * n.y * a, -n.y);
  }
  /// Basis whose s lies in the plane of `normal` and `tangent`, which may have any length; falls back to
  /// the arbitrary basis where the two are parallel or the tangent is zero.
  Frame(Vec3 normal, Vec3 tangent) : n(normal) {
    tangent /= std::max(max_component(glm::abs(tangent)), std::numeric_limits<float>::min());
    Vec3 projected = tangent - normal * glm::dot(normal, tangent);
    if (!(length_squared(projected) > 1e-12f)) {
      *this = Frame(normal);
      return;
    }
    // Twice, as the first leaves of a tangent near the normal mostly what was rounded off (Parlett, "twice is enough").
    projected /= glm::length(projected);
    projected -= normal * glm::dot(normal, projected);
    s = projected / glm::length(projected);
    t = glm::cross(n, s);
  }

  Vec3 to_local(Vec3 v) const { return {glm::dot(v, s), glm::dot(v, t), glm::dot(v, n)}; }
  Vec3 to_world(Vec3 v) const { return s * v.x + t * v.y + n * v.z; }
};

}  // namespace ajar
