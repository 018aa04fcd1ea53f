// Emissive triangles: their place in the world, and what their shader emits.
//
// A triangle shines from both sides, as in Cycles; a shader may tell the sides apart by
// Backfacing. Vertices stay in the mesh, shared by its instances. Sampling is uniform in solid angle where
// the triangle looks large and uniform over the area where it looks small.
#pragma once

#include "geometry/geometry.h"
#include "shading/bsdf/shading_point.h"
#include "shading/shader_program.h"

namespace ajar {

struct WorldTriangle {
  Vec3 p0, e1, e2;  ///< world space
  Vec3 normal;      ///< unit, to the outside of the mesh also when mirrored; zero for a degenerate triangle
  float area;
};
WorldTriangle world_triangle(const BuiltMesh& mesh, const BuiltInstance& instance, uint32_t primitive);

/// By which rounding may have moved a place on it off its plane, as shading_point finds it (scene.h).
float triangle_position_error(const BuiltMesh& mesh, const BuiltInstance& instance, uint32_t primitive);

/// A point of the triangle for p, and the density of its direction at p. Zero density: none.
struct TriangleSample {
  Vec2 barycentric;
  Vec3 wi;
  float distance;
  float pdf_solid_angle;
};
TriangleSample sample_triangle_li(const WorldTriangle& triangle, Vec3 p, Vec2 u);
float pdf_triangle_li(const WorldTriangle& triangle, Vec3 p, Vec3 wi, float distance);

/// Everything a shader may ask, at `barycentric` of the triangle seen from direction `wo`.
ShadingPoint triangle_point(const ObjectDescription& object, const BuiltMesh& mesh, const BuiltInstance& instance,
                            uint32_t primitive, const WorldTriangle& triangle, Vec2 barycentric, Vec3 wo);

/// Mean emitted radiance over the triangle and both sides, estimated at a few points.
Color mean_emission(const ShaderProgram& program, const ObjectDescription& object, const BuiltMesh& mesh,
                    const BuiltInstance& instance, uint32_t primitive, const WorldTriangle& triangle);

}  // namespace ajar
