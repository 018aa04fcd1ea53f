// The steps of a walk from the eye, for all integrators: the next surface, the lamps and the distant light that the ray
// meets on the way, holes in the film, the weight of emission, straight continuation through transparent surfaces,
// Russian roulette.
//
// A caller traces the ray and meets the lamps on it. Then it either leaves the scene or arrives at a surface, and
// chooses the continuation. Media and the choice of directions belong to the caller. Each step does only its own work:
// all functions are inline and none allocates memory.
#pragma once

#include <algorithm>

#include "sampling/sampler.h"
#include "scene/scene.h"
#include "transport/paths/ray_events.h"

namespace ajar {

/// Russian roulette. Returns false if the walk ends. Otherwise the throughputs are divided by `survival`, which is a
/// probability. If it is 1, no random number is used.
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
  ShadingPoint point;      ///< type and depths of the ray; after `arrive`, the surface
  SurfaceShading shading;  ///< the result of shading that surface
  /// Whether a transparent film is transparent where the ray ends: it has crossed nothing but clear glass
  /// (RenderSettings::transparent_glass). Only walks that call `note_bounce` may set it.
  bool clear = false;

  /// Finds the closest surface along the ray.
  void trace() {
    hit = scene_.intersect(ray, point.ray_kind);
    ++rays_;
  }
  bool found() const { return hit.found(); }
  /// Calls meet(LightMet) for each lamp with extent between the start of the ray and the surface.
  template <class Meet>
  void meet_lamps(Meet&& meet) const {
    if (scene_.has_lamp_shapes()) for_each_lamp_crossed(scene_, ray, hit.t, point.ray_kind, meet);
  }
  /// Calls meet(LightMet) for the environment and for each sun in the direction of a ray that leaves the scene. A
  /// transparent film does not show the environment.
  template <class Meet>
  void meet_distant(Meet&& meet) const {
    for_each_distant_light(scene_, ray, point.ray_kind,
                           !((seen_directly() || clear) && scene_.settings().transparent_film), meet);
  }
  /// Moves to the surface. Returns false at a hole in the film.
  bool arrive() {
    scene_.shading_point(ray, hit, point);
    return !(point.object->holdout && seen_directly());
  }
  void shade() { scene_.material(hit).evaluate_surface(point, shading); }
  /// True if the ray has not been scattered since the camera.
  bool seen_directly() const { return point.ray_depth == 0; }
  /// The weight of the surface's emission: weight(light, position, normal) if the surface is in the list of lights.
  /// Otherwise only walks find it, and the weight is 1.
  template <class Weight>
  float emission_weight(Weight&& weight) const {
    const int light = scene_.light_of(hit);
    return light >= 0 ? weight(uint32_t(light), point.position, point.ng) : 1.0f;
  }
  /// Alpha of the film. alpha_of_surface: from a surface that is seen directly, for the throughput `beta`.
  /// alpha_of_nothing: from a ray that leaves the scene.
  float alpha_of_surface(Color beta, Color transparency) const {
    return luminance(beta * (Color(1.0f) - transparency)) * (1.0f - shading.holdout);
  }
  float alpha_of_nothing(Color beta) const {
    // The glass has been counted as opaque.
    if (clear && !seen_directly()) [[unlikely]]
      return -(beta.x + beta.y + beta.z) / 3.0f;
    return seen_directly() && !scene_.settings().transparent_film ? luminance(beta) : 0.0f;
  }

  /// Continues straight through the surface, which is not counted as a bounce. Returns false if the limit of
  /// transparent surfaces is exceeded.
  bool pass_through() {
    if (++point.transparent_depth > scene_.settings().bounces.transparent) return false;
    ray = scene_.straight_on(point, ray, hit.t);
    if (shading.bsdf.passes_thin_wall()) [[unlikely]] {
      point.ray_kind = kBehindThinWall;
      ray.travelled = 0.0f;
    }
    return true;
  }
  /// Continues through a surface with a ray portal by a sample of a Transparent lobe: at another place, or straight on.
  bool pass_portal(const BsdfSample& sample) {
    constexpr float kSamePlace = 1e-9f;  // squared
    ++point.portal_depth;
    if (sample.flags < kPortal) return pass_through();
    if (++point.transparent_depth > scene_.settings().bounces.transparent) return false;
    const Bsdf::Portal portal = shading.bsdf.portal(sample);
    ray = scene_.spawn_ray(point, portal.direction);
    if (length_squared(portal.position - point.position) <= kSamePlace) return true;
    ray.origin = portal.position;
    ray.strand = Ray().strand;
    return true;
  }
  /// Continues straight through a surface that only encloses a volume. It is not counted at all.
  void pass_uncounted() { ray = scene_.straight_on(point, ray, hit.t); }
  void note_bounce(const BsdfSample& sample) {
    if (clear) [[unlikely]]
      clear = (sample.flags & kTransmission) && !(sample.flags & kDiffuse) &&
              (sample.specular || sample.roughness <= scene_.settings().transparent_glass_roughness);
  }
  /// Continues in a sampled direction. `count_bounce` has been called before.
  void leave_along(Vec3 direction) { ray = scene_.spawn_ray(point, direction); }

 private:
  const Scene& scene_;
  uint64_t& rays_;
};

}  // namespace ajar
