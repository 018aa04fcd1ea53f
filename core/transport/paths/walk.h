// Walks: how vertices are found one after another, from the eye or from a light.
//
// A walk passes a surface that lets light straight through with `pass_probability`, else the surface is its next
// vertex and PathVertex::pass keeps that probability; what was passed is in `Through`. Nothing here ends a walk but
// leaving the scene or absorption; roulette and limits belong to the caller.
#pragma once

#include "transport/paths/path_vertex.h"
#include "transport/paths/ray_events.h"

namespace ajar {

/// Rays that leave lights see surfaces as those that leave a diffuse surface do.
constexpr uint32_t kLightWalkKind = kRayDiffuse | kRayReflection;

/// Surfaces a walk has passed since its last vertex.
struct Through {
  Color transmittance{1.0f};
  float pass = 1.0f;
  int surfaces = 0;
};

struct NoRayWatcher {
  void operator()(const Ray&, float, bool, const Through&) const {}
};

/// The next vertex along `ray`; false when the ray leaves the scene or passes more surfaces than the scene's limit.
/// `watch(ray, t_end, found, through)` sees every stretch between surfaces: lamps with extent are met there, and
/// distant light where nothing was found. `vertex.point` holds the kind and the depths of the ray when called.
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

/// Whether the camera sees light that comes from this surface.
inline bool shows_on_film(const ShadingPoint& point) {
  return !point.instance || ((point.instance->visibility & kVisibleCamera) && !point.object->holdout);
}

/// The vertex of a lens point, and the ray through a film point. `density` is that of the ray: per solid angle (per
/// area across it for an orthographic camera) when the film point has density 1 per pixel^2; 0 where nothing is seen.
Ray start_at_lens(const Scene& scene, Vec2 film, Vec2 u_lens, PathVertex& lens, float& density);
/// The same vertex without a ray, to connect to.
void make_lens_vertex(const Scene& scene, Vec2 u_lens, PathVertex& lens);

/// Kind of the rough lobes that most likely draw this direction.
uint32_t likely_flags(const Bsdf& bsdf, Vec3 wo, Vec3 wi);

/// A light and a ray that leaves it, by power and emission or along a hint. False when the numbers lead nowhere.
/// Densities and radiance follow from light_end once the next vertex is known.
bool start_at_light(const Scene& scene, const LightWalkGuide* guide, float u_choice, Vec2 u_position, Vec2 u_direction,
                    PathVertex& light, Ray& ray);

/// The ray that leaves a light made for `to_eye` as a vertex.
Ray leave_light(const Scene& scene, const PathVertex& light, Vec3 to_eye);

/// Vertex on light `index`, which shines along `to_eye`. `normal`: on the light (direction of travel for distant ones).
void make_light_vertex(const Scene& scene, uint32_t index, Vec3 position, Vec3 normal, Vec3 to_eye, PathVertex& light);
/// The end of a path that hit emission: a surface that emits, or a light met by a ray.
void make_light_vertex(const PathVertex& surface, PathVertex& light);
void make_light_vertex(const Scene& scene, const LightMet& met, Vec3 to_eye, PathVertex& light);
/// Light sampling at a surface: a vertex on a chosen light. False when it cannot shine there.
bool sample_light(const Scene& scene, const PathVertex& at, float u_choice, Vec2 u, PathVertex& light);

/// A walk from the eye that must end on a light takes one of those its ray meets: each lamp in front
/// with this probability, then the surface that stops it, or one of the distant lights of its direction.
constexpr float kLampStop = 0.9f;
/// False when it meets none. `through` is what lies before the light.
bool find_light_end(const Scene& scene, const Ray& ray, uint32_t ray_kind, Sampler& sampler, PathVertex& light,
                    Through& through, uint64_t& rays);

}  // namespace ajar
