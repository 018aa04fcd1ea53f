#include "shading/functions/texture_functions.h"

#include <algorithm>

namespace ajar::nodes {

Vec4 image(const ImageLookup& lookup, Vec2 uv) {
  return lookup.texture->sample(uv, lookup.interpolation, lookup.extension, lookup.unassociate);
}

// Definition: Blender's manual (Image Texture, Box) with the widths of Cycles. For n images whose axes have the shares
// p_i of the normal's absolute components, the weights are
//   w_i = ((1 + (n - 2) m) p_i - m) / blend,  m = (1 - blend) / 2.
// They sum to 1. While one weight is negative, the image of the smallest component is left out and the weights of the
// others are computed again. Three images blend around the diagonals, two along the edges of the box, and one is used
// around each axis. An image is left out where its weight is 0, so the weights are continuous.
Vec3 box_weights(Vec3 object_normal, float blend) {
  const Vec3 n = glm::abs(object_normal);
  constexpr Vec3 kAxes[3] = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&](int i, int j) { return n[i] > n[j]; });
  if (!(n[order[0]] > 0.0f)) return kAxes[0];
  // A sharp border. If two components are equal, Cycles uses the image of x.
  if (!(blend > 0.0f)) return n[order[0]] > n[order[1]] ? kAxes[order[0]] : kAxes[0];
  const float margin = 0.5f * (1.0f - blend);
  for (int count = 3; count > 1; --count) {
    float sum = 0.0f;
    for (int i = 0; i < count; ++i) sum += n[order[i]];
    const float slope = (1.0f + float(count - 2) * margin) / sum;
    if (slope * n[order[count - 1]] < margin) continue;
    Vec3 weights(0.0f);
    for (int i = 0; i < count; ++i) weights[order[i]] = std::max((slope * n[order[i]] - margin) / blend, 0.0f);
    return weights;
  }
  return kAxes[order[0]];
}

Vec4 image_box(const ImageLookup& lookup, Vec3 p, Vec3 n) {
  // The coordinates along the width and the height of the image, and the sign of the normal on the side where the image
  // is mirrored, so that it is not reversed on any side. As in Blender.
  static constexpr struct {
    int width, height;
    float mirrored;
  } kSides[3] = {{1, 2, -1.0f}, {0, 2, 1.0f}, {1, 0, 1.0f}};
  const Vec3 weights = box_weights(n, lookup.blend);
  Vec4 sum(0.0f);
  for (int axis = 0; axis < 3; ++axis) {
    if (!(weights[axis] > 0.0f)) continue;
    const auto& side = kSides[axis];
    const float u = p[side.width];
    sum += weights[axis] * image(lookup, {n[axis] * side.mirrored > 0.0f ? 1.0f - u : u, p[side.height]});
  }
  return sum;
}

}  // namespace ajar::nodes
