// The values that input nodes read from the shading point. A point without an instance belongs to the world or to a
// lamp. The position of a point of the world is the direction of view. Normals face the viewer, except those of area
// lamps, as in Cycles.
#pragma once

#include <string>

#include "math/types.h"
#include "shading/bsdf/shading_point.h"

namespace ajar::nodes {

/// The values of an InstanceOrigin (description/scene_description.h), in the order of the outputs of Particle Info. Random
/// is a hash of the index, as in Cycles.
enum class InstancerValue : uint8_t {
  Generated,
  Uv,
  Index,
  Random,
  Age,
  Lifetime,
  Location,
  Size,
  Velocity,
  AngularVelocity
};

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
  TransmissionDepth,
  PortalDepth
};
/// The last is only used by Principled Hair: hair_misses.
enum class HairOutput : uint8_t { IsStrand, Intercept, Length, Thickness, Random, Misses };
enum class PointOutput : uint8_t { Position, Radius, Random };
enum class Axis : uint8_t { X, Y, Z };
enum class Space : uint8_t { World, Object, Camera };
/// First: the strength blends the normals. Second (Blender 4): in tangent space, it multiplies the slope. Third (Blender
/// 5.1): and the interpolated normal, to which the slope is added, is normalized.
enum class NormalMapGeneration : uint8_t { First, Second, Third };
enum class NormalMapSpace : uint8_t { Tangent, Object, World, BlenderObject, BlenderWorld };

Vec3 object_position(const ShadingPoint& point);
/// True on hair. False on triangles and inside volumes.
bool is_strand(const ShadingPoint& point);
/// 0 if the point is not on a strand. Lengths and thicknesses are in the object's space; the thickness for an object
/// that occurs only once is in world space.
float hair_info(const ShadingPoint& point, HairOutput output);
/// The major axis of the cross-section of hair whose curve has this normal. Curves without normals (0) and meshes have
/// the axes of Cycles.
Vec3 hair_major_axis(const ShadingPoint& point, Vec3 curve_normal);
/// The ratio of the minor to the major radius; which one is which does not matter.
float hair_aspect(float ratio);
/// 1 where the eye sees past the ellipse inside a round strand, else 0.
float hair_misses(const ShadingPoint& point, Vec3 curve_normal, float ratio);
/// True on points of a cloud.
bool is_point(const ShadingPoint& point);
/// 0 if the surface is not a point of a cloud. The position and the radius are in world space; the radius of an ellipsoid is
/// its radius along the diagonal of the space of the object, as in Cycles. Numbers have three equal components.
Vec3 point_info(const ShadingPoint& point, PointOutput output);
/// The normal of a strand that is perpendicular to it and faces the eye.
Vec3 hair_tangent_normal(const ShadingPoint& point);
Vec3 object_normal(const ShadingPoint& point);
/// The direction to the eye, transformed like a normal to the instance's space. The normal of lamps and of the world.
Vec3 object_incoming(const ShadingPoint& point);
/// The normal of the triangle, towards the eye. Ribbons of hair face the eye, so theirs is the direction to the eye, as
/// in Cycles.
Vec3 true_normal(const ShadingPoint& point);
/// Transforms a world-space normal to the instance's space. The result has unit length.
Vec3 normal_to_object(const BuiltInstance& instance, float time, Vec3 n);
/// Position within the bounding box of the mesh's texture space, [0, 1] on each axis.
Vec3 generated(const ShadingPoint& point);
Vec3 active_uv(const ShadingPoint& point);
/// The UV map or attribute of this name (empty: the first colour attribute). Zero if the mesh does not have it. `found`
/// may be null.
Vec4 attribute(const ShadingPoint& point, const std::string& name, bool* found);
/// Zero if the object has no property of this name. Black if there is no object, as in Cycles.
Vec4 object_property(const ShadingPoint& point, const std::string& name, bool of_instancer);
/// A value of the InstanceOrigin. Numbers have three equal components. Zero if there is none.
Vec3 from_instancer(const ShadingPoint& point, InstancerValue value);
Vec3 radial_tangent(const ShadingPoint& point, Axis axis);
/// The interpolated tangent of a UV map (geometry/uv_tangents.h) in object space, and the sign of the bitangent. False
/// if the mesh does not have it.
bool smooth_tangent(const ShadingPoint& point, const std::string& uv, Vec3& tangent, float& sign);
/// The direction in which u of the UV map `name` (empty: the active one) increases, in world space.
Vec3 uv_tangent(const ShadingPoint& point, const std::string& name);
Vec3 reflection(const ShadingPoint& point);
Vec3 normal_map(const ShadingPoint& point, NormalMapSpace space, NormalMapGeneration generation, const std::string& uv,
                float strength, Vec3 color);
/// Returns true if the distance to an edge of the triangle is less than half of `width` (metres).
bool is_near_edge(const ShadingPoint& point, float width);
float light_path(const ShadingPoint& point, LightPathOutput output);
/// The Fresnel reflectance of a dielectric for unpolarised light. `eta` is the transmitted index over the incident
/// index.
float fresnel(float cosine, float eta);

}  // namespace ajar::nodes
