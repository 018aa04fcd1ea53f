// Light beyond the terminator of coarse smooth meshes: light that the flat triangles block but that the curved surface,
// which they approximate, would receive.
//
// Interpolated normals light a triangle from directions that are blocked by the triangle itself or by its neighbours.
// The result is a dark band along the edges of the mesh. Cycles starts shadow rays there on a parabola through the
// vertex normals instead of on the triangle, and light sampling counts light below the plane of the triangle. Ajar
// adds, to the light along rays that start on the triangle, the light of directions in which only the moved ray is
// unblocked or only the normals disagree. The image is the same, but the added light is a property of paths. No walk
// can find these paths, neither from the eye nor from the light, so light sampling counts them fully (a density of zero
// has no weight).
//
// Light sampling from eye paths finds this light: `path` with every method, `bdpt`, and the direct light of the other
// integrators. After a bounce, chains, populations and photons leave it out, and walks from the eye add it
// (light_beyond.h, light_without_photons.cpp).
#pragma once

#include "scene/scene.h"

namespace ajar {

/// Whether such light is possible at this point.
inline bool has_soft_terminator(const ShadingPoint& point) {
  return point.object && point.object->shadow_terminator_offset > 0.0f && point.mesh && !point.mesh->normals.empty();
}

/// Whether light after a bounce can have such light in it.
bool has_soft_terminator(const Scene& scene);

/// The relative distance towards the curved surface at which shadow rays start: 1 for grazing light, 0 above the
/// object's cutoff.
inline float share_of_terminator_offset(const ShadingPoint& point, Vec3 wi) {
  const float cutoff = point.object->shadow_terminator_offset;
  float cos_shading = glm::dot(point.ns, wi), cos_geometric = glm::dot(point.ng, wi);
  if (cos_shading < 0.0f) {
    cos_shading = -cos_shading;
    cos_geometric = -cos_geometric;
  }
  return cos_shading < cutoff ? saturate(2.0f - (cos_geometric + cos_shading) / cutoff)
                              : saturate(1.0f - cos_geometric / cutoff);
}

/// Whether light from wi is so near the horizon of the point that it can be beyond the terminator.
inline bool grazes_terminator(const ShadingPoint& point, Vec3 wi) {
  return has_soft_terminator(point) && share_of_terminator_offset(point, wi) > 0.0f;
}

/// Computes the ray that must be unblocked for this light to count, and f |cos| along it. On entry, `f` is that of the
/// BSDF for the ray from the triangle, which was black or blocked. Returns false if there is no such light. The ray has
/// length 0 if nothing can block it.
bool beyond_terminator(const Scene& scene, const ShadingPoint& point, const Bsdf& bsdf, const LightPlace& light,
                       bool shadows, Color& f, Ray& ray);
/// f |cos| times the transmittance towards a point on a light. `shadows`: whether the light casts shadows.
Color beyond_terminator(const Scene& scene, const ShadingPoint& point, const Bsdf& bsdf, const LightPlace& light,
                        Color f_cos, bool shadows, uint64_t& rays);

}  // namespace ajar
