#include <bit>
#include <cmath>

#include "lights/sources/lamp.h"
#include "transport/paths/path_vertex.h"
#include "transport/paths/shadow_terminator.h"
#include "transport/paths/walk.h"

namespace ajar {

namespace {

/// What blocks light from `to`, a light or another vertex.
uint32_t blockers_of(const Scene& scene, const PathVertex& to) {
  return to.kind == VertexKind::Light && to.light >= 0 && scene.lights().any_partial()
             ? scene.lights().flags(uint32_t(to.light)).blockers
             : uint32_t(kVisibleShadow);
}

/// The point on the light or surface of `to`, as it is seen along `direction`. Soft lamps are seen as the disk that
/// faces `p`.
LightPlace place_of(const Scene& scene, const PathVertex& to, Vec3 p, Vec3 direction, float distance) {
  if (to.kind == VertexKind::Light && to.light >= 0 && scene.lights().flags(uint32_t(to.light)).soft) {
    const Light lamp = scene.lights().light(uint32_t(to.light));
    if (const auto along = soft_lamp_distance(lamp, p, direction))
      return {direction,
              *along,
              p + *along * direction,
              glm::normalize(p - lamp.position),
              max_component(to.point.position_error),
              lamp.blockers};
  }
  return {direction,
          distance,
          to.position(),
          to.delta ? -direction : to.point.ng,
          max_component(to.point.position_error),
          blockers_of(scene, to)};
}

/// The ray of look_along, or nothing if it has no length.
struct Look {
  bool from_eye_end = false;
  const PathVertex *from = nullptr, *to = nullptr;
  Ray ray;
};

/// False if nothing can be seen along the edge.
bool look_ray(const Scene& scene, const PathVertex& light_end, const PathVertex& eye_end, const PathEdge& edge,
              Look& look) {
  const auto scatters = [](const PathVertex& v) {
    return v.kind == VertexKind::Surface || v.kind == VertexKind::Medium;
  };
  const bool from_eye_end = scatters(eye_end);
  const PathVertex& from = from_eye_end ? eye_end : light_end;
  const PathVertex& to = from_eye_end ? light_end : eye_end;
  if (!scatters(from)) return false;
  const Vec3 direction = from_eye_end ? -edge.to_eye : edge.to_eye;
  float distance = kInfinity;
  if (to.kind == VertexKind::Lens) {
    const Camera& camera = scene.camera();
    const Vec3 forward = camera.forward(to.point.time);
    distance = to.distant ? glm::dot(to.position() - from.position(), forward) / glm::dot(direction, forward)
                          : 1.0f / std::sqrt(edge.inverse_square);
    distance -= camera.clip_distance(direction, to.point.time);
    if (!(distance > 0.0f)) return false;
  } else if (!to.distant) {
    distance = 1.0f / std::sqrt(edge.inverse_square);
  }
  Ray ray = scene.spawn_ray(from.point, direction);
  if (to.kind == VertexKind::Lens) {
    ray.t_max = distance;
    ray.blockers = kVisibleCamera;  // what the camera does not see blocks nothing
  } else {
    ray = end_before(ray, place_of(scene, to, from.position(), direction, distance));
  }
  // Ribbons face each ray: the ray ends where it enters the tube that they stand for. A ray that leaves a sphere inwards
  // passes through it.
  if (on_strand_or_point(to.point)) [[unlikely]]
    ray.t_max -= way_out(to.point, -direction);
  look.from_eye_end = from_eye_end;
  look.from = &from;
  look.to = &to;
  look.ray = ray;
  return true;
}

/// Shadow rays do not see lamps that cast no shadow.
bool casts_no_shadow(const Scene& scene, const PathVertex& light) {
  return light.kind == VertexKind::Light && light.light >= 0 && !light.program &&
         light.light != scene.lights().environment_index() && !scene.lights().flags(uint32_t(light.light)).cast_shadow;
}

/// Random numbers for the transmittance of an edge, which is a function of its two ends.
Pcg32 numbers_of(const PathVertex& a, const PathVertex& b) {
  uint32_t hash = 0x65646765U;
  for (const Vec3 p : {a.position(), b.position()})
    for (int axis = 0; axis < 3; ++axis) hash = hash_combine(hash, std::bit_cast<uint32_t>(p[axis]));
  return Pcg32(hash, 0x6c6f6f6bU);
}

/// What may lie on an edge.
struct EdgeRules {
  RayKindSurfaces by_kind;
  bool to_light;  ///< one end is the light

  /// The kind of the ray. Edges between vertices that both scatter are rays of walks, which see what diffuse rays see.
  /// `differ`: shadow rays see other objects than they do.
  uint32_t seen_as(const Ray& ray, bool differ) const {
    if (!differ || ray.blockers != kVisibleShadow) return kRayShadow;
    return to_light ? kRayShadow | kLightWalkKind : kLightWalkKind;
  }
  /// The kind of the ray that passes the surface at `hit`; 0: the edge is blocked. Notes in the edge what it passes.
  uint32_t passing(const Scene& scene, const Hit& hit, PathEdge& edge) const {
    const uint32_t shadow = scene.shadow_rays_pass(hit) ? uint32_t(kRayShadow) : 0u;
    if (!scene.depends_on_ray_kind(hit)) return shadow;
    if (by_kind == RayKindSurfaces::Follow) {
      edge.by_ray_kind = true;
      return shadow;
    }
    return to_light || scene.is_eye_only(hit) || !scene.material(hit).may_be_transparent() ? 0u : kLightWalkKind;
  }
};

/// The edge in a scene without media.
bool look_between_surfaces(const Scene& scene, Ray ray, EdgeRules rules, PathEdge& edge, uint64_t& rays) {
  const int limit = scene.settings().bounces.transparent;
  const uint32_t seen_as = rules.seen_as(ray, scene.shadow_rays_differ());
  if (!scene.statistics().transparent_shadows && seen_as == kRayShadow) {
    ++rays;
    return !is_black(scene.transmittance(ray, limit));
  }
  for (int crossed = 0;; ++crossed) {
    const Hit hit = scene.intersect(ray, seen_as);
    ++rays;
    if (!hit.found()) return true;
    const uint32_t kind = crossed < limit ? rules.passing(scene, hit, edge) : 0u;
    if (kind == 0) return false;
    ShadingPoint point;
    scene.shading_point(ray, hit, point);
    point.ray_kind = kind;
    const Color transparency = scene.transparency(hit, point);
    edge.transmittance *= transparency;
    edge.pass *= pass_probability(scene.material(hit), transparency);
    if (!(max_component(edge.transmittance) > 0.0f)) return false;
    const Vec3 end = ray.origin + ray.direction * ray.t_max;
    const float t_max = ray.t_max;
    const uint32_t blockers = ray.blockers;
    ray = scene.spawn_ray(point, ray.direction);
    ray.blockers = blockers;
    if (t_max < kInfinity) {
      ray.t_max = glm::dot(end - ray.origin, ray.direction);
      if (!(ray.t_max > 0.0f)) return true;
    }
  }
}

/// The edge in a scene with media. Sets the densities of collisions at its ends too.
bool look_through_media(const Scene& scene, const PathMedia& media, const Look& look, EdgeRules rules, PathEdge& edge,
                        uint64_t& rays) {
  const int limit = scene.settings().bounces.transparent;
  Ray ray = look.ray;
  MediaStack stack = stack_towards(scene, media, *look.from, ray.direction);
  Pcg32 rng = numbers_of(*look.from, *look.to);
  float first_rate = 0.0f, last_rate = 0.0f;
  const uint32_t attenuated_as = rules.to_light ? uint32_t(kRayShadow) : 0u;
  const uint32_t seen_as = rules.seen_as(ray, scene.shadow_rays_differ() || media.media().hides_volumes());
  for (int stretches = 0, crossed = 0, bounds = 0;; ++stretches) {
    const Hit hit = scene.intersect(ray, seen_as);
    ++rays;
    if (!hit.found() && ray.t_max == kInfinity) media.leave_all(stack);
    const MediaStretch stretch = media.pass(
        {stack, ray, hit.found() ? hit.t : ray.t_max, look.from->point, kLightWalkKind, attenuated_as}, rng);
    edge.transmittance *= stretch.transmittance;
    edge.pass *= stretch.pass;
    last_rate = stretch.rate;
    if (stretches == 0) first_rate = stretch.rate;
    if (!(max_component(glm::abs(edge.transmittance)) > 0.0f)) return false;
    if (!hit.found()) break;
    const ShaderProgram& program = scene.material(hit);
    const bool only_encloses = program.only_encloses();
    const uint32_t kind = only_encloses || crossed >= limit ? 0u : rules.passing(scene, hit, edge);
    if (only_encloses ? ++bounds > kMaxVolumeBounds : kind == 0) return false;
    crossed += !only_encloses;
    ShadingPoint point;
    scene.shading_point(ray, hit, point);
    point.ray_kind = kind;
    if (!only_encloses) {
      const Color transparency = scene.transparency(hit, point);
      const float pass = pass_probability(program, transparency);
      edge.transmittance *= transparency;
      edge.pass *= pass;
      edge.surface_pass *= pass;
      if (!(max_component(glm::abs(edge.transmittance)) > 0.0f)) return false;
    }
    media.cross(hit, !point.backfacing, stack);
    ray = scene.straight_on_to_end(point, ray);
    if (!(ray.t_max > 0.0f)) break;
  }
  // join has set the probabilities of surfaces.
  if (look.from->kind == VertexKind::Medium) (look.from_eye_end ? edge.stop_eye_end : edge.stop_light_end) = first_rate;
  if (look.to->kind == VertexKind::Medium) (look.from_eye_end ? edge.stop_light_end : edge.stop_eye_end) = last_rate;
  return true;
}

}  // namespace

bool look_along(const PathScene& where, const PathVertex& light_end, const PathVertex& eye_end, PathEdge& edge,
                uint64_t& rays, RayKindSurfaces by_kind) {
  const auto& [scene, media] = where;
  edge.transmittance = Color(1.0f);
  edge.pass = edge.surface_pass = 1.0f;
  edge.by_ray_kind = edge.eye_only = false;
  const EdgeRules rules{by_kind, light_end.kind == VertexKind::Light};
  Look look;
  if (media) [[unlikely]] {
    if (!look_ray(scene, light_end, eye_end, edge, look)) return false;
    if (!casts_no_shadow(scene, light_end)) return look_through_media(scene, *media, look, rules, edge, rays);
    // As if there were nothing in between, but with the densities of collisions.
    const MediaStack stack = stack_towards(scene, *media, *look.from, look.ray.direction);
    Pcg32 rng = numbers_of(*look.from, *look.to);
    const float rate = media->pass({stack, look.ray, look.ray.t_max, look.from->point, kLightWalkKind, kRayShadow}, rng)
                           .rate;
    if (eye_end.kind == VertexKind::Medium) edge.stop_eye_end = rate;
    return true;
  }
  if (casts_no_shadow(scene, light_end)) return true;
  if (!look_ray(scene, light_end, eye_end, edge, look)) return false;
  if (!look_between_surfaces(scene, look.ray, rules, edge, rays)) return false;
  edge.surface_pass = edge.pass;
  return true;
}

Color light_beyond_terminator(const PathScene& where, const PathVertex& light, const PathVertex& vertex,
                              const PathEdge& edge, const LightEnd& end, Color f_cos, uint64_t& rays) {
  const auto& [scene, media] = where;
  if (!has_soft_terminator(vertex.point)) return Color(0.0f);
  const bool lamp = light.light >= 0 && !light.program && light.light != scene.lights().environment_index();
  const bool shadows = !lamp || scene.lights().flags(uint32_t(light.light)).cast_shadow;
  const float distance = light.distant ? kInfinity : 1.0f / std::sqrt(edge.inverse_square);
  const LightPlace place = place_of(scene, light, vertex.position(), -edge.to_eye, distance);
  if (media) {
    Ray ray;
    if (!beyond_terminator(scene, vertex.point, vertex.shading.bsdf, place, shadows, f_cos, ray)) return Color(0.0f);
    if (ray.t_max > 0.0f) {
      ++rays;
      Pcg32 rng = numbers_of(vertex, light);
      f_cos *= media->transmittance_to_light(ray, stack_towards(scene, *media, vertex, ray.direction), vertex.point,
                                             rng);
    }
    return end.radiance * edge.to_light_area() * f_cos;
  }
  return end.radiance * edge.to_light_area() *
         beyond_terminator(scene, vertex.point, vertex.shading.bsdf, place, f_cos, shadows, rays);
}

}  // namespace ajar
