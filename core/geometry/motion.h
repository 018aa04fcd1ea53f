// Transforms that move while the shutter is open.
//
// The artist's keys are evenly spaced over the shutter interval [0, 1]. Each is split into translation, rotation and
// stretch, which are interpolated separately; rotations follow the shortest great circle, as in Cycles. For geometry,
// Embree and the shading must agree to the last bits. The motion is therefore divided into matrices that are so close
// that linear interpolation between them is sufficient.
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
/// Gram-Schmidt. The stretch contains mirrored axes. A singular matrix has no rotation.
SplitTransform split(const Mat4& matrix);
Mat4 join(const SplitTransform& transform);

/// The transform at a time in [0, 1] between evenly spaced keys.
Mat4 interpolate(const std::vector<SplitTransform>& keys, float time);

/// Matrices at evenly spaced times whose linear interpolation follows `keys`. The rotation between two of them is at
/// most five degrees (an error of a thousandth of the radius), unless that needs more than `max_matrices`.
std::vector<Mat4> straightened(const std::vector<SplitTransform>& keys, int max_matrices);

/// Linear interpolation of the elements, as in Embree.
inline void interpolate_straight(const Mat4* keys, uint32_t count, float time, Mat4& result) {
  const float place = glm::clamp(time, 0.0f, 1.0f) * float(count - 1);
  const uint32_t first = glm::min(uint32_t(place), count - 2);
  const float t = place - float(first);
  result = (1.0f - t) * keys[first] + t * keys[first + 1];
}

}  // namespace ajar
