// Transforms that move while the shutter is open.
//
// An artist's keys, evenly spaced over the shutter interval [0, 1], are split into translation, rotation and the rest,
// and each is interpolated: rotations along the shortest great circle, as in Cycles. For geometry, where Embree and the
// shading must agree to the last bits, the path is then cut into matrices so close that straight lines between them do.
#pragma once

#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "math/types.h"

namespace ajar {

/// matrix = translation * rotation * stretch.
struct SplitTransform {
  Vec3 translation{0.0f};
  glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};
  Mat3 stretch{1.0f};  ///< upper triangular
};
/// Gram-Schmidt; a mirrored axis goes to the stretch. Of a flat matrix the rotation is none.
SplitTransform split(const Mat4& matrix);
Mat4 join(const SplitTransform& transform);

/// At a time in [0, 1] between evenly spaced keys.
Mat4 interpolate(const std::vector<SplitTransform>& keys, float time);

/// Matrices at evenly spaced times whose straight interpolation follows `keys`: no rotation between two exceeds five
/// degrees (where the shortcut is a thousandth of the radius), as far as `max_matrices` allow.
std::vector<Mat4> straightened(const std::vector<SplitTransform>& keys, int max_matrices);

/// The straight interpolation, elementwise, as Embree's.
inline void interpolate_straight(const Mat4* keys, uint32_t count, float time, Mat4& result) {
  const float place = glm::clamp(time, 0.0f, 1.0f) * float(count - 1);
  const uint32_t first = glm::min(uint32_t(place), count - 2);
  const float t = place - float(first);
  result = (1.0f - t) * keys[first] + t * keys[first + 1];
}

}  // namespace ajar
