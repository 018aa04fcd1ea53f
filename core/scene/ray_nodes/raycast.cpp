#include "scene/scene.h"
#include "shading/functions/point_functions.h"
#include "shading/functions/ray_functions.h"

namespace ajar::nodes {

namespace {

/// Fills `there` with the point that the ray hits, and `distance` with the length of the way in metres.
bool find_hit(const ShadingPoint& point, const RaycastParameters& parameters, ShadingPoint& there, float& distance) {
  constexpr uint32_t kAnyRay = kRayCamera | kRayDiffuse | kRayGlossy | kRayTransmission | kRayShadow |
                               kRayVolumeScatter;
  const auto& [origin, direction, length, only_local] = parameters;
  const float speed = glm::length(direction);
  if (!point.scene || !point.instance || !(length > 0.0f) || !(speed > 0.0f) || !std::isfinite(speed)) return false;
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
  if (!hit.found()) return false;
  point.scene->shading_point(ray, hit, there);
  // The ray may start a little above the surface.
  distance = hit.t + glm::dot(ray.origin - origin, ray.direction);
  return true;
}

}  // namespace

RaycastHit raycast(const ShadingPoint& point, const RaycastParameters& parameters) {
  ShadingPoint there;
  float distance;
  if (!find_hit(point, parameters, there, distance)) return {.distance = parameters.length};
  return {true, there.instance == point.instance, distance / glm::length(parameters.direction), there.ns};
}

Vec4 attribute_at_hit(const ShadingPoint& point, const RaycastParameters& parameters, const std::string& name) {
  ShadingPoint there;
  float distance;
  if (!find_hit(point, parameters, there, distance)) return Vec4(0.0f);
  bool found;
  const Vec4 value = attribute(there, name, &found);
  return found ? value : Vec4(0.0f, 0.0f, 0.0f, 1.0f);
}

}  // namespace ajar::nodes
