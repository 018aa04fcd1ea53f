// The events on the rays of a walk from the eye: the type of the ray for visibility and for the Light Path node, and
// the lights that it meets besides surfaces.
#pragma once

#include <array>
#include <cmath>

#include "film/film.h"
#include "scene/scene.h"

namespace ajar {

/// The type of the ray that leaves a surface after the sampled lobe, with Blender's distinctions. A ray through glass is a
/// glossy one as well; for visibility it is not (visibility_mask).
constexpr uint32_t ray_kind_after(uint32_t lobe_flags) {
  uint32_t kind = (lobe_flags & kTransmission) ? uint32_t(kRayTransmission) : uint32_t(kRayReflection);
  if (lobe_flags & kDiffuse) kind |= kRayDiffuse;
  if (lobe_flags & (kGlossy | kSpecular)) kind |= kRayGlossy;
  if (lobe_flags & kSpecular) kind |= kRaySingular;
  return kind;
}
/// That of a ray behind a smooth thin wall, which transmits it, although light sampling and shadow rays see it pass
/// straight on.
constexpr uint32_t kBehindThinWall = ray_kind_after(kTransmission | kSpecular);
inline uint32_t ray_kind_after(const BsdfSample& sample) {
  constexpr uint32_t kAllFlags = 2 * kTransparent - 1;
  static constexpr auto kKinds = [] {
    std::array<uint8_t, kAllFlags + 1> kinds{};
    for (uint32_t flags = 0; flags <= kAllFlags; ++flags) kinds[flags] = uint8_t(ray_kind_after(flags));
    return kinds;
  }();
  return kKinds[sample.flags & kAllFlags];
}

/// Updates the ray data before the ray of `sample` leaves `from`: `next`, the next vertex, gets its type and its
/// depths. Both may be the same object.
[[gnu::always_inline]] inline void count_bounce(const BsdfSample& sample, const ShadingPoint& from,
                                                ShadingPoint& next) {
  const bool diffuse = sample.flags & kDiffuse, transmitted = sample.flags & kTransmission;
  next.ray_kind = ray_kind_after(sample);
  next.ray_depth = from.ray_depth + 1;
  next.after_diffuse = from.after_diffuse || diffuse;
  next.diffuse_depth = from.diffuse_depth + (diffuse && !transmitted);
  next.glossy_depth = from.glossy_depth + (!diffuse && !transmitted);
  next.transmission_depth = from.transmission_depth + transmitted;
  next.transparent_depth = from.transparent_depth;
  next.time = from.time;
}

/// Whether a limit is exceeded. Then only the emission of the next surface still counts.
inline bool past_limits(const ShadingPoint& point, const BounceLimits& limits) {
  return point.ray_depth > limits.total || point.diffuse_depth > limits.diffuse || point.glossy_depth > limits.glossy ||
         point.transmission_depth > limits.transmission;
}

/// The part of f_cos by the kinds of lobes that see a light of this visibility. `kinds`: Bsdf::f_cos_of_kinds.
inline Color visible_to(uint32_t visibility, const std::array<Color, 3>& kinds) {
  Color sum(0.0f);
  if (visibility & kVisibleDiffuse) sum += kinds[0];
  if (visibility & kVisibleGlossy) sum += kinds[1];
  if (visibility & kVisibleTransmission) sum += kinds[2];
  return sum;
}
inline Color visible_to(uint32_t visibility, const Bsdf& bsdf, Vec3 wo, Vec3 wi) {
  return visible_to(visibility, bsdf.f_cos_of_kinds(wo, wi));
}

/// A light that a ray meets and that is not a surface. For distant light, all components of `position` are kInfinity.
struct LightMet {
  uint32_t light;
  Color radiance;
  Vec3 position, normal;
};

/// Calls visit for each emitting lamp with extent that the ray crosses before t_end. Lamps do not block the ray.
template <class F>
void for_each_lamp_crossed(const Scene& scene, const Ray& ray, float t_end, uint32_t ray_kind, F&& visit) {
  Ray segment = ray;
  segment.t_max = t_end;
  for (LampHit lamp = scene.intersect_lamp(segment, ray_kind); lamp.light != ~0u;
       lamp = scene.intersect_lamp(segment, ray_kind)) {
    const Vec3 on_lamp = ray.origin + ray.direction * lamp.t;
    const Color emitted = scene.lights().lamp_radiance(lamp.light, on_lamp, -ray.direction, ray.time,
                                                       ray.travelled + lamp.t);
    if (!is_black(emitted)) visit(LightMet{lamp.light, emitted, on_lamp, lamp.normal});
    segment.t_min = std::nextafter(lamp.t, kInfinity) * (1.0f + 1e-6f);
    if (!(segment.t_min < segment.t_max)) break;
  }
}

/// Calls visit for the environment and for the suns that a ray meets when it leaves the scene.
template <class F>
void for_each_distant_light(const Scene& scene, const Ray& ray, uint32_t ray_kind, bool with_environment, F&& visit) {
  const LightSet& lights = scene.lights();
  const int environment = lights.environment_index();
  if (with_environment && environment >= 0) {
    const Color emitted = lights.environment_radiance(ray.direction, ray_kind);
    if (!is_black(emitted)) visit(LightMet{uint32_t(environment), emitted, Vec3(kInfinity), -ray.direction});
  }
  lights.for_each_distant_disk(ray.direction, [&](uint32_t index) {
    if (!(lights.flags(index).visibility & visibility_mask(ray_kind))) return;
    const Color emitted = lights.lamp_radiance(index, Vec3(0.0f), -ray.direction, ray.time, 0.0f, ray_kind);
    visit(LightMet{index, emitted, Vec3(kInfinity), -ray.direction});
  });
}

}  // namespace ajar
