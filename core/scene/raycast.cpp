#include "scene/scene.h"
#include "shading/functions/ray_functions.h"

namespace ajar::nodes {

RaycastHit raycast(const ShadingPoint& point, Vec3 origin, Vec3 direction, float length, bool only_local) {
  constexpr uint32_t kAnyRay = kRayCamera | kRayDiffuse | kRayGlossy | kRayTransmission | kRayShadow |
                               kRayVolumeScatter;
  RaycastHit result;
  result.distance = length;
  const float speed = glm::length(direction);
  if (!point.scene || !point.instance || !(length > 0.0f) || !(speed > 0.0f) || !std::isfinite(speed)) return result;
  Ray ray;
  if (origin == point.position) {
    ray = point.scene->spawn_ray(point, direction / speed);
  } else {
    ray.origin = origin;
    ray.direction = direction / speed;
    ray.time = point.time;
  }
  ray.t_max = length * speed;
  const Hit hit = only_local ? point.scene->intersect_own(*point.instance, ray) : point.scene->intersect(ray, kAnyRay);
  if (!hit.found()) return result;
  ShadingPoint there;
  point.scene->shading_point(ray, hit, there);
  // The ray may start a little above the surface.
  const float distance = hit.t + glm::dot(ray.origin - origin, ray.direction);
  return {true, there.instance == point.instance, distance / speed, there.ns};
}

}  // namespace ajar::nodes
