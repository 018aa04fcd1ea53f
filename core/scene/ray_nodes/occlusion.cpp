#include "shading/functions/ray_functions.h"

#include "math/frame.h"
#include "math/warps.h"
#include "scene/ray_nodes/place.h"
#include "scene/scene.h"

namespace ajar::nodes {

float openness(const ShadingPoint& point, const OcclusionParameters& parameters, Vec3 normal) {
  const float length2 = length_squared(normal);
  if (!point.scene || !point.instance || parameters.samples < 1 || !(parameters.distance > 0.0f) || !(length2 > 0.0f))
    return 1.0f;
  const Frame frame(normal * ((parameters.inside ? -1.0f : 1.0f) / std::sqrt(length2)));
  Pcg32 rng(seed_of_place(point));
  const Vec2 offset(rng.next_float(), rng.next_float());
  int open = 0;
  for (int i = 0; i < parameters.samples; ++i) {
    // A rank-1 lattice of the plastic number with a random offset: each of its points is uniform.
    const float x = offset.x + float(double(i) * 0.7548776662466927 - std::floor(double(i) * 0.7548776662466927));
    const float y = offset.y + float(double(i) * 0.5698402909980532 - std::floor(double(i) * 0.5698402909980532));
    const Vec2 u(std::min(x - std::floor(x), kOneMinusEpsilon), std::min(y - std::floor(y), kOneMinusEpsilon));
    Ray ray = point.scene->spawn_ray(point, frame.to_world(warp::square_to_cosine_hemisphere(u)));
    ray.t_max = parameters.distance;
    open += !(parameters.only_local ? point.scene->is_blocked_by(*point.instance, ray) : point.scene->is_blocked(ray));
  }
  return float(open) / float(parameters.samples);
}

}  // namespace ajar::nodes
