// What input nodes read from the shading point. Without an instance the point belongs to the world or a lamp. The
// world's position is the direction looked in, and normals face the viewer, apart from those of area lamps, as in
// Cycles.
#pragma once

#include <string>

#include "math/types.h"
#include "shading/bsdf/shading_point.h"

namespace ajar::nodes {

enum class LightPathOutput : uint8_t {
  IsCamera,
  IsShadow,
  IsDiffuse,
  IsGlossy,
  IsSingular,
  IsReflection,
  IsTransmission,
  IsVolumeScatter,
  RayLength,
  RayDepth,
  DiffuseDepth,
  GlossyDepth,
  TransparentDepth,
  TransmissionDepth
};
enum class HairOutput : uint8_t { IsStrand, Intercept, Length, Thickness, Random };
enum class Axis : uint8_t { X, Y, Z };
enum class Space : uint8_t { World, Object, Camera };
enum class NormalMapSpace : uint8_t { Tangent, Object, World, BlenderObject, BlenderWorld };

Vec3 object_position(const ShadingPoint& point);
/// On hair, not on a triangle nor inside a volume.
bool is_strand(const ShadingPoint& point);
/// 0 where there is no strand. Length and thickness in the object's space; of objects that appear once the thickness in
/// the world's.
float hair_info(const ShadingPoint& point, HairOutput output);
/// Of a strand: towards the eye, perpendicular to it.
Vec3 hair_tangent_normal(const ShadingPoint& point);
Vec3 object_normal(const ShadingPoint& point);
/// That of the triangle, towards the eye; of ribbons of hair, which face it, the direction to the eye, as in Cycles.
Vec3 true_normal(const ShadingPoint& point);
/// A world-space normal in the instance's space, of unit length.
Vec3 normal_to_object(const BuiltInstance& instance, float time, Vec3 n);
/// Position within the bounding box of the mesh's texture space, [0, 1] on each axis.
Vec3 generated(const ShadingPoint& point);
Vec3 active_uv(const ShadingPoint& point);
/// UV map or attribute by name (empty: the first colour attribute); zero where the mesh has none. `found` may be null.
Vec4 attribute(const ShadingPoint& point, const std::string& name, bool* found);
/// Zero where the object has none of that name, and of black where there is no object, as in Cycles.
Vec4 object_property(const ShadingPoint& point, const std::string& name, bool of_instancer);
Vec3 radial_tangent(const ShadingPoint& point, Axis axis);
/// Direction of growing u of the UV map `name` (empty: the active one), in world space.
Vec3 uv_tangent(const ShadingPoint& point, const std::string& name);
Vec3 reflection(const ShadingPoint& point);
Vec3 normal_map(const ShadingPoint& point, NormalMapSpace space, const std::string& uv, float strength, Vec3 color);
/// Within half of `width` metres of an edge of the triangle.
bool is_near_edge(const ShadingPoint& point, float width);
float light_path(const ShadingPoint& point, LightPathOutput output);
/// Unpolarised Fresnel reflectance of a dielectric; `eta` is transmitted over incident index.
float fresnel(float cosine, float eta);

}  // namespace ajar::nodes
