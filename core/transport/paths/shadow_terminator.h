// Light beyond the terminator of coarse smooth meshes: what the flat triangles hide and the curved surface they stand
// for would receive.
//
// Interpolated normals light a triangle from directions in which it, or its neighbours, are in the way: a dark band
// follows the edges of the mesh. Cycles starts shadow rays there on a parabola through the vertex normals instead of on
// the triangle, and lets light sampling count light below the triangle's plane. Ajar adds, to the light that is found
// along unmoved rays, the light of directions in which only the moved ray gets through or which only the normals
// disagree about: the same image, but a property of paths. No walk can find these paths, neither from the eye nor from
// the light, so light sampling counts them fully (a density of zero has no weight).
//
// Held by light sampling from eye paths: `path` by every method, `bdpt`, and the direct light of the others, which do
// without in light that arrives by further bounces (docs/agreement.md).
#pragma once

#include "scene/scene.h"

namespace ajar {

/// Can there be such light at all?
inline bool has_soft_terminator(const ShadingPoint& point) {
  return point.object && point.object->shadow_terminator_offset > 0.0f && point.mesh && !point.mesh->normals.empty();
}

/// How far towards the curved surface shadow rays start: all the way (1) where light grazes, not at all (0) above the
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

/// Does light from wi come so near the point's horizon that it may be?
inline bool grazes_terminator(const ShadingPoint& point, Vec3 wi) {
  return has_soft_terminator(point) && share_of_terminator_offset(point, wi) > 0.0f;
}

/// The ray that must get through for that light to count, and f |cos| along it: `f` is given as the BSDF's for the
/// unmoved ray, which was black or blocked. False when there is none; a ray of length 0 when nothing can block it.
bool beyond_terminator(const Scene& scene, const ShadingPoint& point, const Bsdf& bsdf, const LightPlace& light,
                       bool shadows, Color& f, Ray& ray);
/// f |cos| times transmittance towards a place on a light. `shadows`: does the light cast any?
Color beyond_terminator(const Scene& scene, const ShadingPoint& point, const Bsdf& bsdf, const LightPlace& light,
                        Color f_cos, bool shadows, uint64_t& rays);

}  // namespace ajar
