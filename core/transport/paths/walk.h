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

/// The surfaces that a walk has passed since its last vertex.
struct Through {
  Color transmittance{1.0f};
  float pass = 1.0f;
  int surfaces = 0;
};

struct NoRayWatcher {
  void operator()(const Ray&, float, bool, const Through&) const {}
};

/// Finds the next vertex along `ray`. Returns false if the ray leaves the scene or passes more surfaces than the scene
/// allows. Calls `watch(ray, t_end, found, through)` for every part of the ray between surfaces; lamps with extent are
/// met there, and distant light if no surface was found. On entry, `vertex.point` has the type and the depths of the
/// ray.
template <class Watch = NoRayWatcher>
bool find_vertex(const Scene& scene, Ray ray, Sampler& sampler, PathVertex& vertex, Through& through, uint64_t& rays,
                 Watch&& watch = {}) {
  through = {};
  for (;;) {
    const Hit hit = scene.intersect(ray, vertex.point.ray_kind);
    ++rays;
    watch(ray, hit.t, hit.found(), through);
    if (!hit.found()) return false;
    scene.shading_point(ray, hit, vertex.point);
    vertex.program = &scene.material(hit);
    vertex.program->evaluate_surface(vertex.point, vertex.shading);
    if (vertex.point.object->holdout && (vertex.point.ray_kind & kRayCamera)) {
      // A hole in the film.
      vertex.shading.bsdf = Bsdf();
      vertex.shading.emission = Color(0.0f);
      vertex.shading.holdout = 1.0f;
    }
    vertex.kind = VertexKind::Surface;
    vertex.specular = vertex.distant = vertex.delta = false;
    vertex.light = vertex.emits() ? scene.light_of(hit) : -1;
    vertex.pass = 0.0f;
    if (!vertex.program->may_be_transparent()) return true;
    const Color transparency = vertex.shading.bsdf.transparency();
    vertex.pass = pass_probability(*vertex.program, transparency);
    if (!(vertex.pass > 0.0f) || sampler.get_1d() >= vertex.pass) {
      vertex.shading.bsdf.remove_transparency(vertex.point.wo);
      return true;
    }
    if (++through.surfaces > scene.settings().bounces.transparent) return false;
    ++vertex.point.transparent_depth;
    through.transmittance *= transparency;
    through.pass *= vertex.pass;
    ray = scene.straight_on(vertex.point, ray, hit.t);
  }
}

/// Whether the camera can see light that comes from this surface.
inline bool shows_on_film(const ShadingPoint& point) {
  return !point.instance || ((point.instance->visibility & kVisibleCamera) && !point.object->holdout);
}

/// Makes the vertex of a lens point. Returns the ray through a film point. `density` is that of the ray if the film
/// point has density 1 per pixel^2: per solid angle, or per area across the ray for an orthographic camera. It is 0 if
/// the camera sees nothing at the film point.
Ray start_at_lens(const Scene& scene, Vec2 film, Vec2 u_lens, PathVertex& lens, float& density);
/// The same vertex without a ray, for connections.
void make_lens_vertex(const Scene& scene, Vec2 u_lens, PathVertex& lens);

/// The flags of the rough lobes with the highest probability of sampling this direction.
uint32_t likely_flags(const Bsdf& bsdf, Vec3 wo, Vec3 wi);

/// Samples a light and a ray that leaves it, by power and emission or along a hint. Returns false if there is none for
/// these random numbers. Densities and radiance follow from light_end when the next vertex is known.
bool start_at_light(const Scene& scene, const LightWalkGuide* guide, float u_choice, Vec2 u_position, Vec2 u_direction,
                    PathVertex& light, Ray& ray);

/// The ray that leaves a light, whose vertex was made for `to_eye`.
Ray leave_light(const Scene& scene, const PathVertex& light, Vec3 to_eye);

/// Makes a vertex on light `index` that emits along `to_eye`. `normal` is that of the light (for distant lights the
/// direction of travel).
void make_light_vertex(const Scene& scene, uint32_t index, Vec3 position, Vec3 normal, Vec3 to_eye, PathVertex& light);
/// Makes the end of a path that hit emission: a surface that emits, or a light that a ray met.
void make_light_vertex(const PathVertex& surface, PathVertex& light);
void make_light_vertex(const Scene& scene, const LightMet& met, Vec3 to_eye, PathVertex& light);
/// Light sampling at a surface: makes a vertex on a sampled light. Returns false if the light cannot contribute there.
bool sample_light(const Scene& scene, const PathVertex& at, float u_choice, Vec2 u, PathVertex& light);

/// A walk from the eye that must end on a light takes one of the lights that its ray meets: each lamp on the way with
/// this probability, then the surface at the end of the ray or one of the distant lights in its direction.
constexpr float kLampStop = 0.9f;
/// Returns false if the ray meets no light. `through` describes the surfaces before the light.
bool find_light_end(const Scene& scene, const Ray& ray, uint32_t ray_kind, Sampler& sampler, PathVertex& light,
                    Through& through, uint64_t& rays);

}  // namespace ajar
