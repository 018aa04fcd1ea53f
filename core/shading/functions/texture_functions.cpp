#include "shading/functions/texture_functions.h"

#include <algorithm>

#include "shading/images/tile_cache.h"

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

namespace {

/// The sum over the images of a box. `value(u, v, mirrored)` is that of one: `u` and `v` are the components of the
/// coordinates along its width and its height.
template <class Value>
Vec4 sum_of_box(Vec3 n, float blend, Value&& value) {
  // The coordinates along the width and the height of the image, and the sign of the normal on the side where the image
  // is mirrored, so that it is not reversed on any side. As in Blender.
  static constexpr struct {
    int width, height;
    float mirrored;
  } kSides[3] = {{1, 2, -1.0f}, {0, 2, 1.0f}, {1, 0, 1.0f}};
  const Vec3 weights = box_weights(n, blend);
  Vec4 sum(0.0f);
  for (int axis = 0; axis < 3; ++axis) {
    if (!(weights[axis] > 0.0f)) continue;
    const auto& side = kSides[axis];
    sum += weights[axis] * value(side.width, side.height, n[axis] * side.mirrored > 0.0f);
  }
  return sum;
}

Vec4 over(const ImageLookup& lookup, Vec2 uv, const UvFootprint& footprint) {
  return lookup.texture->sample_over(uv, footprint, lookup.interpolation, lookup.extension, lookup.unassociate);
}

}  // namespace

Vec4 image_box(const ImageLookup& lookup, Vec3 p, Vec3 n) {
  return sum_of_box(n, lookup.blend, [&](int u, int v, bool mirrored) {
    return image(lookup, {mirrored ? 1.0f - p[u] : p[u], p[v]});
  });
}

Vec4 image_over(const ImageLookup& lookup, const CoordinatesBeside& at, float step) {
  return over(lookup, Vec2(at.here), {Vec2(at.x - at.here) / step, Vec2(at.y - at.here) / step});
}

Vec4 image_box_over(const ImageLookup& lookup, const CoordinatesBeside& at, float step, Vec3 n) {
  const Vec3 x = (at.x - at.here) / step, y = (at.y - at.here) / step;
  return sum_of_box(n, lookup.blend, [&](int u, int v, bool mirrored) {
    return over(lookup, {mirrored ? 1.0f - at.here[u] : at.here[u], at.here[v]}, {{x[u], x[v]}, {y[u], y[v]}});
  });
}

}  // namespace ajar::nodes
