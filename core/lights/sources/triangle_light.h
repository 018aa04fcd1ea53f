// Emissive triangles: their geometry in world space, and the emission of their shader.
//
// A triangle emits from both sides, as in Cycles; a shader can distinguish the sides by Backfacing. Vertices stay in
// the mesh, which its instances share. Sampling is uniform in solid angle if the triangle looks large, and uniform over
// the area if it looks small.
#pragma once

#include "geometry/geometry.h"
#include "shading/bsdf/shading_point.h"
#include "shading/shader_program.h"

namespace ajar {

struct WorldTriangle {
  Vec3 p0, e1, e2;  ///< world space
  Vec3 normal;      ///< unit; points out of the mesh, also if mirrored; zero for a degenerate triangle
  float area;
};
/// At a time of the shutter interval.
WorldTriangle world_triangle(const BuiltMesh& mesh, const BuiltInstance& instance, uint32_t primitive, float time);
/// The middle of the shutter interval, for estimates.
inline constexpr float kMidShutter = 0.5f;
/// Whether its triangles are at other places at other times.
inline bool moves(const BuiltMesh& mesh, const BuiltInstance& instance) { return instance.motion || mesh.deforms(); }

/// Bound of the rounding error that moves a point of the triangle off its plane, as in shading_point (scene.h).
float triangle_position_error(const BuiltMesh& mesh, const BuiltInstance& instance, uint32_t primitive, float time);

/// A point of the triangle sampled for p, and the density of its direction at p. Density 0: no sample.
struct TriangleSample {
  Vec2 barycentric;
  Vec3 wi;
  float distance;
  float pdf_solid_angle;
};
TriangleSample sample_triangle_li(const WorldTriangle& triangle, Vec3 p, Vec2 u);
float pdf_triangle_li(const WorldTriangle& triangle, Vec3 p, Vec3 wi, float distance);

/// A triangle of an instance, at a time and seen from a distance.
struct SeenTriangle {
  const BuiltMesh& mesh;
  const BuiltInstance& instance;
  uint32_t primitive;
  const WorldTriangle& triangle;  ///< at the time
  float time = kMidShutter;
  float distance = 0.0f;
};
/// All inputs of a shader at `barycentric` of the triangle, seen from direction `wo`.
ShadingPoint triangle_point(const ObjectDescription& object, const SeenTriangle& seen, Vec2 barycentric, Vec3 wo);
/// Mean emitted radiance over the triangle and both sides, estimated at so many points.
Color mean_emission(const ShaderProgram& program, const ObjectDescription& object, const SeenTriangle& seen,
                    int points);

}  // namespace ajar
