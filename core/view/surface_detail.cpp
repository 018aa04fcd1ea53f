#include "view/surface_detail.h"

#include <algorithm>
#include <cmath>

#include "denoise/planes.h"
#include "math/types.h"

namespace ajar {

namespace {

constexpr float kAlike = 0.01f;    // squared difference of guides that halves a weight
constexpr float kDarkest = 0.02f;  // added to an albedo
constexpr float kMaxRatio = 2.5f;  // of albedos of pixels that are unlike each other
constexpr float kReach = 1.5f;     // coarse pixels

Vec3 at(const std::vector<float>& image, size_t pixel) {
  return {image[3 * pixel], image[3 * pixel + 1], image[3 * pixel + 2]};
}

float squared(Vec3 v) { return glm::dot(v, v); }

}  // namespace

std::vector<float> with_surfaces(const std::vector<float>& rgba, const GuidedPicture& coarse,
                                 const GuidedPicture& fine) {
  const auto &here = fine.size.region, &there = coarse.size.region;
  const int width = here[2] - here[0], height = here[3] - here[1];
  const int columns = there[2] - there[0], rows = there[3] - there[1];
  const float across = float(coarse.size.width) / float(fine.size.width),
              up = float(coarse.size.height) / float(fine.size.height);
  std::vector<float> result(size_t(width) * size_t(height) * 4);
  for_rows(height, [&](int y) {
    const float v = (float(here[1] + y) + 0.5f) * up - float(there[1]);  // in coarse pixels
    const int row = std::clamp(int(std::floor(v)), 0, rows - 1);
    for (int x = 0; x < width; ++x) {
      const float u = (float(here[0] + x) + 0.5f) * across - float(there[0]);
      const int column = std::clamp(int(std::floor(u)), 0, columns - 1);
      const size_t pixel = size_t(y) * size_t(width) + size_t(x);
      const Vec3 albedo = at(fine.albedo, pixel), normal = at(fine.normal, pixel);
      Vec3 light(0.0f);
      float alpha = 0.0f, weights = 0.0f;
      for (int j = std::max(0, row - 1); j <= std::min(rows - 1, row + 1); ++j)
        for (int i = std::max(0, column - 1); i <= std::min(columns - 1, column + 1); ++i) {
          const size_t other = size_t(j) * size_t(columns) + size_t(i);
          const Vec3 of_other = at(coarse.albedo, other);
          const float near = std::max(0.05f, kReach - std::abs(float(i) + 0.5f - u)) *
                             std::max(0.05f, kReach - std::abs(float(j) + 0.5f - v));
          const float unlike = squared(albedo - of_other) + squared(normal - at(coarse.normal, other));
          const float weight = near * near / (kAlike + unlike * unlike / kAlike + unlike);
          const float* color = &rgba[4 * other];
          const Vec3 ratio = glm::clamp((albedo + kDarkest) / (of_other + kDarkest), 1.0f / kMaxRatio, kMaxRatio);
          light += weight * ratio * Vec3(color[0], color[1], color[2]);
          alpha += weight * color[3];
          weights += weight;
        }
      const Vec3 color = light / weights;
      for (int c = 0; c < 3; ++c) result[4 * pixel + size_t(c)] = color[c];
      result[4 * pixel + 3] = alpha / weights;
    }
  });
  return result;
}

}  // namespace ajar
