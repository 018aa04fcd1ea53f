#include "shading/functions/ray_functions.h"

#include <cmath>

#include "math/frame.h"
#include "sampling/sampler.h"
#include "scene/ray_nodes/place.h"
#include "scene/scene.h"

namespace ajar::nodes {
namespace {

/// A distance for the density that is proportional to r (1 - r)^3 on [0, 1]. With y = 1 - r, the probability of a
/// greater distance is y^4 (5 - 4 y), which Newton's method inverts.
float sample_distance(float u) {
  float y = std::pow(u, 0.25f) * (1.0f - 0.33125970f * (1.0f - u));  // (1/5)^(1/4) for small u
  for (int i = 0; i < 8; ++i) {
    const float y3 = y * y * y, slope = 20.0f * y3 * (1.0f - y);
    const float error = y3 * y * (5.0f - 4.0f * y) - u;
    if (std::abs(error) < 1e-6f || !(slope > 0.0f)) break;
    y = std::clamp(y - error / slope, 0.0f, 1.0f);
  }
  return 1.0f - std::max(y, 1e-3f);  // the falloff is not 0
}

/// The weight of a distance, as a part of the radius.
float falloff(float distance) { return distance < 1.0f ? (1.0f - distance) * sqr(1.0f - distance) : 0.0f; }

/// The axes of the lines: the normal of the triangle and two tangents, with their probabilities.
constexpr float kShare[3] = {0.5f, 0.25f, 0.25f};

/// Turns the place of a number in its share into a new number, and returns the share.
int choose_axis(float& u) {
  const int axis = u < 0.5f ? 0 : u < 0.75f ? 1 : 2;
  u = axis == 0 ? 2.0f * u : 4.0f * u - (axis == 1 ? 2.0f : 3.0f);
  return axis;
}

}  // namespace

// The lines sample the falloff over discs that face one of three axes, which the power heuristic combines (King et al.
// 2013, "BSSRDF Importance Sampling").
Vec3 bevelled_normal(const ShadingPoint& point, float radius, int samples) {
  constexpr int kMaxCrossings = 16;  // of a line
  if (!point.scene || !point.instance || !point.mesh || !point.mesh->has_triangles() ||
      point.primitive == kInsideVolume || samples < 1 || !(radius > 0.0f))
    return point.ns;
  const Frame frame(point.ng);
  const Vec3 axes[3] = {point.ng, frame.to_world({1, 0, 0}), frame.to_world({0, 1, 0})};
  // The direction of a sum of few normals depends on how evenly their lines are spread. Cycles uses such points as well.
  Sampler numbers(Sampler::Kind::Sobol, seed_of_place(point));
  Vec3 sum(0.0f);
  for (int i = 0; i < samples; ++i) {
    numbers.start(0, uint32_t(i));
    Vec2 u = numbers.get_2d();
    const int axis = choose_axis(u.x);
    const float r = sample_distance(u.y), height = radius * safe_sqrt(1.0f - r * r);
    const Vec3 across = axes[(axis + 1) % 3] * std::cos(2.0f * kPi * u.x) +
                        axes[(axis + 2) % 3] * std::sin(2.0f * kPi * u.x);
    Ray line;
    line.origin = point.position + axes[axis] * height + across * (radius * r);
    line.direction = -axes[axis];
    line.t_max = 2.0f * height;
    line.time = point.time;
    for (int crossing = 0; crossing < kMaxCrossings; ++crossing) {
      const Hit hit = point.scene->intersect_own(*point.instance, line);
      if (!hit.found()) break;
      ShadingPoint there;
      point.scene->shading_point(line, hit, there);
      float density = 0.0f, powers = 0.0f;
      for (int k = 0; k < 3; ++k) {
        const float d = kShare[k] * std::abs(glm::dot(axes[k], there.ng));
        powers += sqr(d);
        if (k == axis) density = d;
      }
      const float distance = glm::length(there.position - point.position) / radius;
      if (powers > 0.0f)
        sum += (density / powers * falloff(distance) / falloff(r)) * (there.backfacing ? -there.ns : there.ns);
      line.t_min = hit.t + 1e-6f * line.t_max;
    }
  }
  const float length = glm::length(sum);
  if (!(length > 0.0f) || !std::isfinite(length)) return point.ns;
  return sum * ((point.backfacing ? -1.0f : 1.0f) / length);
}

}  // namespace ajar::nodes
