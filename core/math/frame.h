// An orthonormal basis around a normal: local z is the normal.
// Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
#pragma once

#include "math/types.h"

namespace ajar {

struct Frame {
  Vec3 s{1, 0, 0}, t{0, 1, 0}, n{0, 0, 1};

  Frame() = default;
  explicit Frame(Vec3 normal) : n(normal) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    s = Vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    t = Vec3(b, sign + n.y * n.y * a, -n.y);
  }
  /// Basis whose s lies in the plane of `normal` and `tangent`; falls back to
  /// the arbitrary basis where the two are parallel or the tangent is zero.
  Frame(Vec3 normal, Vec3 tangent) : n(normal) {
    const Vec3 projected = tangent - normal * glm::dot(normal, tangent);
    const float len2 = length_squared(projected);
    if (!(len2 > 1e-12f)) {
      *this = Frame(normal);
      return;
    }
    s = projected / std::sqrt(len2);
    t = glm::cross(n, s);
  }

  Vec3 to_local(Vec3 v) const { return {glm::dot(v, s), glm::dot(v, t), glm::dot(v, n)}; }
  Vec3 to_world(Vec3 v) const { return s * v.x + t * v.y + n * v.z; }
};

}  // namespace ajar
