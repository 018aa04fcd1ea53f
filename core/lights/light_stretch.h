// A part of a ray for whose points together a light is chosen, for light that a medium scatters into the ray.
#pragma once

#include "math/types.h"

namespace ajar {

struct LightStretch {
  Vec3 origin{0.0f}, direction{0.0f};  ///< of the ray; the direction is a unit vector
  float begin = 0.0f, end = 0.0f;      ///< distances; lights that reach no point between them are not chosen
  /// The mean light between `begin` and `begin + reach` counts, where most of the scattering is. 0: a point.
  float reach = 0.0f;

  static LightStretch at(Vec3 point) { return {point, Vec3(0.0f), 0.0f, 0.0f, 0.0f}; }
  bool is_point() const { return !(reach > 0.0f); }
  Vec3 point(float t) const { return origin + t * direction; }
  /// The distance of the place on the part that counts which is nearest to `p`.
  float nearest(Vec3 p) const {
    if (is_point()) return begin;
    return glm::clamp(glm::dot(p - origin, direction), begin, begin + reach);
  }
};

}  // namespace ajar
