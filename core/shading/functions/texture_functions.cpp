#include "shading/functions/texture_functions.h"

namespace ajar::nodes {

Vec4 image(const ImageLookup& lookup, Vec2 uv) {
  return lookup.texture->sample(uv, lookup.interpolation, lookup.extension, lookup.unassociate);
}

// The weights live on the triangle x + y + z = 1 of absolute normals: one picture in each corner,
// two along an edge, three in the middle; `blend` is the width of the transitions.
Vec3 box_weights(Vec3 object_normal, float blend) {
  Vec3 n = glm::abs(object_normal);
  n /= n.x + n.y + n.z;
  const float limit = 0.5f * (1.0f + blend);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    if (n[i] > limit * (n[i] + n[j]) && n[i] > limit * (n[i] + n[k])) {
      Vec3 weights(0.0f);
      weights[i] = 1.0f;
      return weights;
    }
  }
  if (!(blend > 0.0f)) return {1.0f, 0.0f, 0.0f};
  for (const int k : {2, 0, 1}) {   // the axis that takes no part
    const int i = k == 0 ? 1 : 0, j = k == 2 ? 1 : 2;
    if (n[k] >= (1.0f - limit) * (n[i] + n[j])) continue;
    Vec3 weights(0.0f);
    weights[i] = saturate((n[i] / (n[i] + n[j]) - 0.5f * (1.0f - blend)) / blend);
    weights[j] = 1.0f - weights[i];
    return weights;
  }
  return ((2.0f - limit) * n + (limit - 1.0f)) / (2.0f * limit - 1.0f);
}

Vec4 image_box(const ImageLookup& lookup, Vec3 p, Vec3 n) {
  const Vec3 weights = box_weights(n, lookup.blend);
  Vec4 result(0.0f);
  if (weights.x > 0.0f) result += weights.x * image(lookup, {n.x < 0.0f ? 1.0f - p.y : p.y, p.z});
  if (weights.y > 0.0f) result += weights.y * image(lookup, {n.y > 0.0f ? 1.0f - p.x : p.x, p.z});
  if (weights.z > 0.0f) result += weights.z * image(lookup, {n.z > 0.0f ? 1.0f - p.y : p.y, p.x});
  return result;
}

}  // namespace ajar::nodes
