#include "geometry/motion.h"

#include <algorithm>
#include <cmath>

namespace ajar {

SplitTransform split(const Mat4& matrix) {
  SplitTransform result;
  result.translation = Vec3(matrix[3]);
  const Mat3 linear(matrix);
  const float volume = glm::determinant(linear),
              scale = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
  if (!(std::abs(volume) > 1e-9f * scale)) {
    result.stretch = linear;
    return result;
  }
  const Vec3 x = glm::normalize(linear[0]);
  const Vec3 y = glm::normalize(linear[1] - glm::dot(linear[1], x) * x);
  const Mat3 rotation(x, y, glm::cross(x, y));
  result.rotation = glm::normalize(glm::quat_cast(rotation));
  result.stretch = glm::transpose(rotation) * linear;
  return result;
}

Mat4 join(const SplitTransform& transform) {
  Mat4 matrix(glm::mat3_cast(transform.rotation) * transform.stretch);
  matrix[3] = Vec4(transform.translation, 1.0f);
  return matrix;
}

Mat4 interpolate(const std::vector<SplitTransform>& keys, float time) {
  if (keys.size() == 1) return join(keys[0]);
  const float place = std::clamp(time, 0.0f, 1.0f) * float(keys.size() - 1);
  const size_t first = std::min(size_t(place), keys.size() - 2);
  const float t = place - float(first);
  const SplitTransform &a = keys[first], &b = keys[first + 1];
  return join({glm::mix(a.translation, b.translation, t), glm::slerp(a.rotation, b.rotation, t),
               (1.0f - t) * a.stretch + t * b.stretch});
}

std::vector<Mat4> straightened(const std::vector<SplitTransform>& keys, int max_matrices) {
  constexpr float kStep = 0.0872665f;  // five degrees
  float widest = 0.0f;
  for (size_t i = 0; i + 1 < keys.size(); ++i)
    widest = std::max(widest,
                      2.0f * std::acos(std::min(1.0f, std::abs(glm::dot(keys[i].rotation, keys[i + 1].rotation)))));
  const int segments = int(keys.size()) - 1;
  const int parts = std::clamp(int(std::ceil(widest / kStep)), 1, std::max(1, (max_matrices - 1) / segments));
  std::vector<Mat4> matrices;
  for (int i = 0; i <= segments * parts; ++i) matrices.push_back(interpolate(keys, float(i) / float(segments * parts)));
  return matrices;
}

}  // namespace ajar
