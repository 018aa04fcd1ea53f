// One step after another of a walk from the eye, for all integrators: the next surface, the lamps and the distant light
// that the ray meets on the way, holes in the film, the weight of emission, straight continuation through transparent
// surfaces, roulette.
//
// A caller traces, meets lamps, then either leaves the scene or arrives at a surface, and chooses how the walk goes on.
// Media and the choice of directions are the caller's. What a step does not need is not done: all functions are inline
// and none allocates.
#pragma once

#include <algorithm>

#include "sampling/sampler.h"
#include "scene/scene.h"
#include "transport/paths/ray_events.h"

namespace ajar {

/// Russian roulette: false when the walk ends, else throughputs become those of the walks that survive. `survival` is a
/// probability; at 1 no number is drawn.
template <class... Throughputs>
bool survives(float survival, Sampler& sampler, uint32_t dimension, Throughputs&... throughputs) {
  if (!(survival < 1.0f)) return true;
  sampler.set_dimension(dimension);
  if (!(sampler.get_1d() < survival)) return false;
  ((throughputs /= survival), ...);
  return true;
}

class EyeWalk {
 public:
  EyeWalk(const Scene& scene, const Ray& first, uint64_t& rays, const ShadingPoint& from = {})
      : ray(first), point(from), scene_(scene), rays_(rays) {}

  Ray ray;
  Hit hit;
  ShadingPoint point;      ///< kind and depths of the ray; from `arrive` on, the surface it has met
  SurfaceShading shading;  ///< of that surface

  /// Finds the closest surface along the ray.
  void trace() {
    hit = scene_.intersect(ray, point.ray_kind);
    ++rays_;
  }
  bool found() const { return hit.found(); }
  /// meet(LightMet) for each lamp with extent between here and the surface.
  template <class Meet>
  void meet_lamps(Meet&& meet) const {
    if (scene_.has_lamp_shapes()) for_each_lamp_crossed(scene_, ray, hit.t, point.ray_kind, meet);
  }
  /// meet(LightMet) for the environment and each sun in the direction of a ray that leaves the scene. A transparent
  /// film does not show the environment.
  template <class Meet>
  void meet_distant(Meet&& meet) const {
    for_each_distant_light(scene_, ray, point.ray_kind, !(seen_directly() && scene_.settings().transparent_film), meet);
  }
  /// Goes to the surface. False at a hole in the film.
  bool arrive() {
    scene_.shading_point(ray, hit, point);
    return !(point.object->holdout && seen_directly());
  }
  void shade() { scene_.material(hit).evaluate_surface(point, shading); }
  /// Nothing has scattered the ray since the camera.
  bool seen_directly() const { return point.ray_depth == 0; }
  /// Weight of the surface's emission: weight(light, position, normal) for one that is known as a light, 1 for others,
  /// which only walks find.
  template <class Weight>
  float emission_weight(Weight&& weight) const {
    const int light = scene_.light_of(hit);
    return light >= 0 ? weight(uint32_t(light), point.position, point.ng) : 1.0f;
  }
  /// Alpha that the film gets from a surface that is seen directly, of throughput `beta`; from a ray that leaves the
  /// scene, of all of it.
  float alpha_of_surface(Color beta, Color transparency) const {
    return luminance(beta * (Color(1.0f) - transparency)) * (1.0f - shading.holdout);
  }
  float alpha_of_nothing(Color beta) const {
    return seen_directly() && !scene_.settings().transparent_film ? luminance(beta) : 0.0f;
  }

  /// Straight on through the surface: bounces are not counted. False when that is once too often.
  bool pass_through() {
    if (++point.transparent_depth > scene_.settings().bounces.transparent) return false;
    ray = scene_.straight_on(point, ray, hit.t);
    return true;
  }
  /// Straight on through a surface that only encloses a volume, which is not counted at all.
  void pass_uncounted() { ray = scene_.straight_on(point, ray, hit.t); }
  /// Along a sampled direction; `count_bounce` has been called.
  void leave_along(Vec3 direction) { ray = scene_.spawn_ray(point, direction); }

 private:
  const Scene& scene_;
  uint64_t& rays_;
};

}  // namespace ajar
