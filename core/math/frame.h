// An orthonormal basis around a normal: local z is the normal.
// Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited". The basis is discontinuous where n.z passes a
// limit. The paper has this seam at n.z = 0, where the normals of vertical walls are up to rounding. Here it is away
// from the normals of floors, walls and ceilings.
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
  /// Basis whose s is in the plane of `normal` and `tangent`. The tangent may have any length. If it is zero or
  /// parallel to the normal, the basis is that of the normal alone.
  Frame(Vec3 normal, Vec3 tangent) : n(normal) {
    tangent /= std::max(max_component(glm::abs(tangent)), std::numeric_limits<float>::min());
    Vec3 projected = tangent - normal * glm::dot(normal, tangent);
    if (!(length_squared(projected) > 1e-12f)) {
      *this = Frame(normal);
      return;
    }
    // Project twice: if the tangent is nearly parallel to the normal, the first result is mostly rounding error
    // (Parlett, "twice is enough").
    projected /= glm::length(projected);
    projected -= normal * glm::dot(normal, projected);
    s = projected / glm::length(projected);
    t = glm::cross(n, s);
  }

  Vec3 to_local(Vec3 v) const { return {glm::dot(v, s), glm::dot(v, t), glm::dot(v, n)}; }
  Vec3 to_world(Vec3 v) const { return s * v.x + t * v.y + n * v.z; }
};

}  // namespace ajar
