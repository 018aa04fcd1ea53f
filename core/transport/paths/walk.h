// Walks: vertices are found one after another, from the eye or from a light.
//
// A walk passes a transparent surface with `pass_probability`. Otherwise the surface is its next vertex, and
// PathVertex::pass stores that probability. `Through` describes the surfaces that were passed. A walk ends here only if
// it leaves the scene or is absorbed. Roulette and limits belong to the caller.
#pragma once

#include "transport/paths/path_vertex.h"
#include "transport/paths/ray_events.h"

namespace ajar {

/// For rays from lights, surfaces have the visibility that they have for rays from diffuse surfaces.
constexpr uint32_t kLightWalkKind = kRayDiffuse | kRayReflection;

/// What a walk does in media.
struct Collisions {
  enum class Kind : uint8_t { Sampled, None, AtDistance } kind = Kind::Sampled;
  float distance = 0.0f;  ///< of the collision, if that is given
};

/// What a walk has passed since its last vertex.
struct Through {
  Collisions collisions{};                         ///< set by the caller
  RayKindSurfaces by_kind = RayKindSurfaces::End;  ///< set by the caller
  Color transmittance{1.0f};
  float pass = 1.0f;          ///< probability to pass all surfaces, and the media without a collision
  float surface_pass = 1.0f;  ///< the same of the surfaces alone
  /// Density of a collision per metre at the start of the walk and at the vertex, if they are in media.
  float start_rate = 0.0f, end_rate = 0.0f;
  int surfaces = 0, stretches = 0, bounds = 0;
  bool by_ray_kind = false;  ///< surfaces were passed that depend on the kind of the ray ...
  bool eye_only = false;     ///< ... and such that are eye-only
  float chance = 1.0f;       ///< probability of the choices of AsShadow that are not in `pass`
};

/// Whether a walk from a light passes a surface that depends on the kind of the ray as shadow rays do. `point`: there.
/// If the surface is not eye-only, the walk scatters there at least in half of the cases.
bool passes_as_shadow(const Scene& scene, const Hit& hit, const ShadingPoint& point, Sampler& sampler,
                      Through& through);

struct NoRayWatcher {
  void operator()(const Ray&, float, bool, const Through&) const {}
};

/// The media of one stretch, up to `hit`. True if the walk ends on it: at a collision, which `vertex` becomes, or, with
/// a given distance of the collision, where there is no medium. vertex.media.stack is that of the stretch.
bool walk_in_media(const PathMedia& media, const Ray& ray, const Hit& hit, Sampler& sampler, PathVertex& vertex,
                   Through& through);

/// `passed` and the media of this stretch up to distance t, where a light is met. `stack`: of the stretch.
Through through_to(const PathMedia& media, const MediaStack& stack, const Ray& ray, float t, const ShadingPoint& path,
                   Sampler& sampler, const Through& passed);

/// Finds the next vertex along `ray`. Returns false if the ray leaves the scene or passes more surfaces than the scene
/// allows. Calls `watch(ray, t_end, found, through)` for every part of the ray between surfaces; lamps with extent are
/// met there, and distant light if no surface was found. On entry, `vertex.point` has the type and the depths of the
/// ray.
template <class Watch = NoRayWatcher>
bool find_vertex(const PathScene& where, Ray ray, Sampler& sampler, PathVertex& vertex, Through& through,
                 uint64_t& rays, Watch&& watch = {}) {
  const auto& [scene, media] = where;
  through = {through.collisions, through.by_kind};
  vertex.point.marks_subsurface = true;
  // Behind thin walls, materials see another kind of ray. What the ray sees does not change, because walks from the other
  // end do not know it.
  const uint32_t seen_by = vertex.point.ray_kind;
  const bool as_shadow_too = scene.shadow_rays_differ() && through.by_kind >= RayKindSurfaces::FromLight;
  for (;;) {
    const Hit hit = scene.intersect(ray, seen_by | (as_shadow_too ? uint32_t(kRayShadow) : 0u));
    ++rays;
    if (media && !hit.found()) [[unlikely]]
      media->leave_all(vertex.media.stack);
    watch(ray, hit.t, hit.found(), through);
    if (media && walk_in_media(*media, ray, hit, sampler, vertex, through)) [[unlikely]]
      return vertex.kind == VertexKind::Medium;
    if (!hit.found()) return false;
    scene.shading_point(ray, hit, vertex.point);
    vertex.program = &scene.material(hit);
    if (media && vertex.program->only_encloses()) [[unlikely]] {
      if (++through.bounds > kMaxVolumeBounds) return false;
      media->cross(hit, !vertex.point.backfacing, vertex.media.stack);
      ray = scene.straight_on(vertex.point, ray, hit.t);
      continue;
    }
    vertex.program->evaluate_surface(vertex.point, vertex.shading);
    if (vertex.point.object->holdout && (seen_by & kRayCamera)) {
      // A hole in the film.
      vertex.shading.bsdf = Bsdf();
      vertex.shading.emission = Color(0.0f);
      vertex.shading.holdout = 1.0f;
    }
    vertex.kind = VertexKind::Surface;
    vertex.specular = vertex.distant = vertex.delta = vertex.exit = false;
    vertex.light = vertex.emits() ? scene.light_of(hit) : -1;
    vertex.pass = 0.0f;
    vertex.eye_only = scene.is_eye_only(hit);
    const bool by_ray_kind = scene.depends_on_ray_kind(hit);
    if (by_ray_kind && through.by_kind != RayKindSurfaces::Follow) [[unlikely]] {
      if (through.by_kind == RayKindSurfaces::AsShadow &&
          passes_as_shadow(scene, hit, vertex.point, sampler, through)) {
        if (media) media->cross(hit, !vertex.point.backfacing, vertex.media.stack);
        ray = scene.straight_on(vertex.point, ray, hit.t);
        continue;
      }
      if (vertex.eye_only) {
        vertex.shading.bsdf = Bsdf();
        return true;
      }
    }
    if (!vertex.program->may_be_transparent()) return true;
    const Color transparency = vertex.shading.bsdf.transparency();
    vertex.pass = pass_probability(*vertex.program, transparency);
    if (!(vertex.pass > 0.0f) || sampler.get_1d() >= vertex.pass) {
      vertex.shading.bsdf.remove_transparency(vertex.point.wo);
      return true;
    }
    if (by_ray_kind && through.by_kind >= RayKindSurfaces::FromLight) [[unlikely]]
      return false;
    if (++through.surfaces > scene.settings().bounces.transparent) return false;
    ++vertex.point.transparent_depth;
    through.transmittance *= transparency;
    through.pass *= vertex.pass;
    through.surface_pass *= vertex.pass;
    through.by_ray_kind |= by_ray_kind;
    through.eye_only |= vertex.eye_only;
    if (media) [[unlikely]]
      media->cross(hit, !vertex.point.backfacing, vertex.media.stack);
    ray = scene.straight_on(vertex.point, ray, hit.t);
    if (vertex.shading.bsdf.passes_thin_wall()) [[unlikely]] {
      vertex.point.ray_kind = kBehindThinWall;
      ray.travelled = 0.0f;
    }
  }
}

/// Whether the camera can see light that comes from this surface.
inline bool shows_on_film(const ShadingPoint& point) {
  return !point.instance || ((point.instance->visibility & kVisibleCamera) && !point.object->holdout);
}

/// The time of a new path. It is 0, and no number is drawn, if nothing moves.
inline float sample_time(const Scene& scene, Sampler& sampler) {
  return scene.moves() ? scene.camera().time_of(sampler.get_1d()) : 0.0f;
}

/// The kind of the ray by which a walk from the eye looks for light beyond `vertex`. It matters only if a light is
/// hidden from some kinds of rays.
inline uint32_t kind_towards_light(const Scene& scene, const PathVertex& vertex, Vec3 to_eye, Vec3 direction) {
  if (!scene.lights().any_partial() || !vertex.specular) return kLightWalkKind;
  const bool transmits = glm::dot(vertex.point.ng, to_eye) * glm::dot(vertex.point.ng, direction) < 0.0f;
  return transmits ? uint32_t(kRayTransmission) : uint32_t(kRayGlossy | kRayReflection);
}

/// Makes the vertex of a lens point. Returns the ray through a film point. `density` is that of the ray if the film
/// point has density 1 per pixel^2: per solid angle, or per area across the ray for an orthographic camera. It is 0 if
/// the camera sees nothing at the film point.
Ray start_at_lens(const Scene& scene, Vec2 film, Vec2 u_lens, float time, PathVertex& lens, float& density);
/// The same vertex without a ray, for connections.
void make_lens_vertex(const Scene& scene, Vec2 u_lens, float time, PathVertex& lens);
/// The ray through a film point that leaves this lens vertex. Moves the vertex if the lens turns (Camera::lens_turns).
Ray leave_lens(const Scene& scene, Vec2 film, PathVertex& lens);

/// Distance along the ray at which it meets a lamp; infinite for distant light.
inline float distance_to(const Ray& ray, const LightMet& met) {
  return is_finite(met.position) ? glm::dot(met.position - ray.origin, ray.direction) : kInfinity;
}
/// Before a walk leaves `from`, `next` gets the volumes of its ray.
inline void enter_media(const PathScene& where, const PathVertex& from, Vec3 direction, PathVertex& next) {
  next.media.present = where.media != nullptr;
  if (where.media) [[unlikely]]
    next.media.stack = stack_towards(where.scene, *where.media, from, direction);
}
/// count_bounce at a surface or in a medium.
inline void count_bounce_at(const PathVertex& vertex, const BsdfSample& sample, ShadingPoint& next) {
  count_bounce(sample, vertex.point, next);
  if (vertex.kind != VertexKind::Medium) return;
  next.ray_kind = kRayVolumeScatter;
  next.glossy_depth = vertex.point.glossy_depth;
}
/// Fills the edge that a walk from `from` has found.
inline void set_edge(PathEdge& edge, const Through& through, const PathVertex& from, const PathVertex& found,
                     bool towards_light) {
  edge.transmittance = through.transmittance;
  edge.pass = through.pass;
  edge.surface_pass = through.surface_pass;
  edge.by_ray_kind = through.by_ray_kind;
  edge.eye_only = through.eye_only;
  const float start = from.kind == VertexKind::Medium ? through.start_rate
                      : towards_light                 ? from.stop_probability_from_light(-edge.to_eye)
                                                      : from.stop_probability(edge.to_eye),
              end = found.kind == VertexKind::Medium ? through.end_rate : 1.0f - found.pass;
  edge.stop_light_end = towards_light ? end : start;
  edge.stop_eye_end = towards_light ? start : end;
}

/// The flags of the rough lobes with the highest probability of sampling this direction.
uint32_t likely_flags(const Bsdf& bsdf, Vec3 wo, Vec3 wi);

/// Random numbers for the start of a walk at a light.
struct LightNumbers {
  float choice;
  Vec2 position, direction;
};
/// Samples a light and a ray that leaves it, by power and emission or along a hint. Returns false if there is none for
/// these random numbers, or if other objects than usual block the light: a walk would not find all that it lights, so
/// walks from the eye find this light. Densities and radiance follow from light_end when the next vertex is known.
bool start_at_light(const Scene& scene, const LightWalkGuide* guide, const LightNumbers& u, float time,
                    PathVertex& light, Ray& ray);

/// The ray that leaves a light, whose vertex was made for `to_eye`.
Ray leave_light(const Scene& scene, const PathVertex& light, Vec3 to_eye);

/// Makes a vertex on light `index` that emits along `to_eye`. `normal` is that of the light (for distant lights the
/// direction of travel).
void make_light_vertex(const Scene& scene, uint32_t index, Vec3 position, Vec3 normal, Vec3 to_eye, float time,
                       PathVertex& light);
/// Makes the end of a path that hit emission: a surface that emits, or a light that a ray met.
void make_light_vertex(const PathVertex& surface, PathVertex& light);
void make_light_vertex(const Scene& scene, const LightMet& met, Vec3 to_eye, float time, PathVertex& light);
/// Light sampling at a surface: makes a vertex on a sampled light. Returns false if the light cannot contribute there.
bool sample_light(const Scene& scene, const PathVertex& at, float u_choice, Vec2 u, PathVertex& light);

/// A walk from the eye that must end on a light takes one of the lights that its ray meets: each lamp on the way with
/// this probability, then the surface at the end of the ray or one of the distant lights in its direction.
constexpr float kLampStop = 0.9f;
/// On entry, light.point has the kind of the ray. Returns false if the ray meets no light, or only past surfaces that
/// depend on the kind of the ray. `through` describes the surfaces before the light.
bool find_light_end(const PathScene& where, const PathVertex& from, const Ray& ray, Sampler& sampler, PathVertex& light,
                    Through& through, uint64_t& rays);

}  // namespace ajar
