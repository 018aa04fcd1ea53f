#include "shading/functions/point_functions.h"

#include "geometry/geometry.h"
#include "geometry/uv_tangents.h"
#include "math/hash.h"
#include "shading/bsdf/huang.h"
#include "shading/functions/math_functions.h"

namespace ajar::nodes {

Vec3 object_position(const ShadingPoint& point) {
  Mat4 moved;
  return point.instance ? transform_point(object_from_world(*point.instance, point.time, moved), point.position)
                        : point.position;
}

bool is_strand(const ShadingPoint& point) {
  return point.mesh && point.mesh->strands && point.primitive != kInsideVolume;
}

float hair_info(const ShadingPoint& point, HairOutput output) {
  if (!is_strand(point)) return 0.0f;
  const Strands& strands = *point.mesh->strands;
  const uint32_t segment = point.primitive, strand = strands.strand_of(segment);
  switch (output) {
    case HairOutput::IsStrand: return 1.0f;
    case HairOutput::Intercept: {
      const uint32_t first = strands.point_of(segment);
      return strands.intercepts[first] +
             point.barycentric.x * (strands.intercepts[first + 1] - strands.intercepts[first]);
    }
    case HairOutput::Length: return strands.lengths[strand];
    case HairOutput::Thickness: return 2.0f * strands.radius(segment, point.barycentric.x, point.time);
    case HairOutput::Random: {
      const uint32_t key[] = {strand, 0};
      return float(hash_words(key)) / float(0xffffffffu);
    }
    case HairOutput::Misses: break;
  }
  return 0.0f;
}

Vec3 hair_major_axis(const ShadingPoint& point, Vec3 curve_normal) {
  if (!is_strand(point)) return normalize_or_zero(glm::cross(point.dpdu, point.wo));
  const Vec3 t = normalize_or_zero(point.dpdu);
  if (length_squared(curve_normal) > 0.0f) return curve_normal;
  const Vec3 minor = t.x != t.y || t.x != t.z ? Vec3(t.z - t.y, t.x - t.z, t.y - t.x)
                                              : Vec3(t.z - t.y, t.x + t.z, -t.y - t.x);
  return glm::cross(t, normalize_or_zero(minor));
}

float hair_aspect(float ratio) {
  ratio = std::abs(ratio);
  return glm::clamp(ratio > 1.0f ? 1.0f / ratio : ratio, 0.001f, 1.0f);
}

float hair_misses(const ShadingPoint& point, Vec3 curve_normal, float ratio) {
  if (!is_strand(point)) return 0.0f;
  const float aspect = hair_aspect(ratio);
  const Vec3 major = hair_major_axis(point, curve_normal);
  return aspect < 1.0f && hair::misses_ellipse(point.ng, point.dpdu, major, aspect, point.wo) ? 1.0f : 0.0f;
}

bool is_point(const ShadingPoint& point) {
  return point.mesh && point.mesh->points && point.primitive != kInsideVolume;
}

Vec3 point_info(const ShadingPoint& point, PointOutput output) {
  if (!is_point(point) || !point.instance) return Vec3(0.0f);
  const Vec4 sphere = point.mesh->points->sphere(point.primitive, point.time);
  Mat4 moved;
  switch (output) {
    case PointOutput::Position:
      return point.mesh->baked ? Vec3(sphere)
                               : transform_point(world_from_object(*point.instance, point.time, moved), Vec3(sphere));
    case PointOutput::Radius: {
      if (point.mesh->baked) return Vec3(sphere.w);
      const Mat4& world = world_from_object(*point.instance, point.time, moved);
      return Vec3(sphere.w * glm::length(transform_vector(world, Vec3(1.0f))) / std::sqrt(3.0f));
    }
    case PointOutput::Random: {
      const uint32_t key[] = {point.primitive, 0};
      return Vec3(float(hash_words(key)) / float(0xffffffffu));
    }
  }
  return Vec3(0.0f);
}

Vec3 hair_tangent_normal(const ShadingPoint& point) {
  if (!is_strand(point)) return Vec3(0.0f);
  return normalize_or_zero(point.wo - point.dpdu * (glm::dot(point.dpdu, point.wo) / length_squared(point.dpdu)));
}

/// Normals are transformed by the transpose of the inverse matrix.
Vec3 normal_to_object(const BuiltInstance& instance, float time, Vec3 n) {
  Mat4 moved;
  return normalize_or_zero(Vec3(glm::transpose(Mat3(world_from_object(instance, time, moved))) * n));
}

namespace {

Vec3 normal_to_world(const BuiltInstance& instance, float time, Vec3 n) {
  Mat4 moved;
  return normalize_or_zero(Vec3(glm::transpose(Mat3(object_from_world(instance, time, moved))) * n));
}

/// `tangent`, projected to the plane of `normal`.
Vec3 tangent_of(Vec3 normal, Vec3 tangent) {
  return glm::cross(normal, normalize_or_zero(glm::cross(tangent, normal)));
}

}  // namespace

Vec3 object_incoming(const ShadingPoint& point) {
  return point.instance ? normal_to_object(*point.instance, point.time, point.wo) : object_normal(point);
}

Vec3 object_normal(const ShadingPoint& point) {
  return point.instance ? normal_to_object(*point.instance, point.time, point.ns) : point.ns;
}

Vec3 true_normal(const ShadingPoint& point) {
  return is_strand(point) && point.mesh->strands->shape == StrandShape::Ribbon ? point.wo : point.ng;
}

Vec3 generated(const ShadingPoint& point) {
  if (!point.mesh) return point.position;
  const BuiltMesh& mesh = *point.mesh;
  Mat4 moved;
  if (mesh.deformation && mesh.undeformed_position < 0 && point.primitive != kInsideVolume) [[unlikely]] {
    // The coordinates of a place stay what they are in the shape of the frame, as in Cycles.
    const UVec3 v = mesh.triangles[point.primitive];
    const Vec2 b = point.barycentric;
    const Vec3 still = (1.0f - b.x - b.y) * mesh.positions[v.x] + b.x * mesh.positions[v.y] + b.y * mesh.positions[v.z];
    const Vec3 on_mesh = mesh.baked && point.instance ? transform_point(point.instance->object_from_world, still)
                                                      : still;
    return divide((on_mesh - mesh.texture_space_location) * 0.5f, mesh.texture_space_size) + 0.5f;
  }
  // All points of a strand have the coordinates of its root, as in Cycles.
  const Vec3 position = is_strand(point) && mesh.undeformed_position < 0
                            ? (mesh.baked && point.instance
                                   ? transform_point(object_from_world(*point.instance, point.time, moved),
                                                     mesh.strands->root(point.primitive))
                                   : mesh.strands->root(point.primitive))
                        : mesh.undeformed_position < 0 || point.primitive == kInsideVolume
                            ? object_position(point)
                            : Vec3(mesh.interpolate(mesh.attributes[mesh.undeformed_position], point.primitive,
                                                    point.barycentric));
  return divide((position - mesh.texture_space_location) * 0.5f, mesh.texture_space_size) + 0.5f;
}

Vec3 active_uv(const ShadingPoint& point) {
  if (!point.mesh || point.mesh->active_uv < 0 || point.primitive == kInsideVolume) return Vec3(0.0f);
  const Attribute& uv = point.mesh->attributes[point.mesh->active_uv];
  const Vec4 value = point.mesh->interpolate(uv, point.primitive, point.barycentric);
  return {value.x, value.y, 0.0f};
}

namespace {

int find_attribute(const BuiltMesh& mesh, const std::string& name) {
  if (!name.empty() || mesh.points) return mesh.find_attribute(name);
  for (size_t i = 0; i < mesh.attributes.size(); ++i)
    if (mesh.attributes[i].components == 4) return int(i);
  return -1;
}

}  // namespace

Vec4 attribute(const ShadingPoint& point, const std::string& name, bool* found) {
  if (point.primitive == kInsideVolume) {
    const VoxelGrid* grid = point.mesh ? point.mesh->find_grid(name) : nullptr;
    if (found) *found = grid != nullptr;
    return grid ? grid->at(object_position(point)) : Vec4(0.0f);
  }
  const int index = point.mesh ? find_attribute(*point.mesh, name) : -1;
  if (found) *found = index >= 0;
  if (index < 0) return Vec4(0.0f);
  const Attribute& attribute = point.mesh->attributes[index];
  const Vec4 value = point.mesh->interpolate(attribute, point.primitive, point.barycentric);
  return attribute.components == 1 ? Vec4(Vec3(value.x), 1.0f) : value;
}

Vec4 object_property(const ShadingPoint& point, const std::string& name, bool of_instancer) {
  if (!point.object) return Vec4(0.0f, 0.0f, 0.0f, 1.0f);
  for (const ObjectProperty& property : point.object->properties)
    if (property.of_instancer == of_instancer && property.name == name) {
      const Vec4* own = property.column >= 0 && point.instance ? point.instance->values : nullptr;
      return own ? own[property.column] : property.value;
    }
  return Vec4(0.0f);
}

Vec3 from_instancer(const ShadingPoint& point, InstancerValue value) {
  static const InstanceOrigin kNothing;
  const InstanceOrigin& origin = point.instance && point.instance->origin ? *point.instance->origin : kNothing;
  switch (value) {
    case InstancerValue::Generated: return origin.generated;
    case InstancerValue::Uv: return {origin.uv, 0.0f};
    case InstancerValue::Index: return Vec3(origin.index);
    case InstancerValue::Random: return Vec3(float(hash_words<2>({uint32_t(int64_t(origin.index)), 0u})) * 0x1p-32f);
    case InstancerValue::Age: return Vec3(origin.age);
    case InstancerValue::Lifetime: return Vec3(origin.lifetime);
    case InstancerValue::Location: return origin.location;
    case InstancerValue::Size: return Vec3(origin.size);
    case InstancerValue::Velocity: return origin.velocity;
    case InstancerValue::AngularVelocity: return origin.angular_velocity;
  }
  return Vec3(0.0f);
}

Vec3 radial_tangent(const ShadingPoint& point, Axis axis) {
  if (is_strand(point)) return normalize_or_zero(point.dpdu);
  const Vec3 p = generated(point) - 0.5f;
  const Vec3 around = axis == Axis::X   ? Vec3(0.0f, -p.z, p.y)
                      : axis == Axis::Y ? Vec3(-p.z, 0.0f, p.x)
                                        : Vec3(-p.y, p.x, 0.0f);
  const Vec3 n = point.ns;
  return tangent_of(n, point.instance ? normal_to_world(*point.instance, point.time, around) : around);
}

namespace {

/// The unit tangent of the triangle along u, in world space. `sign` is -1 on mirrored islands.
bool triangle_tangent(const ShadingPoint& point, const std::string& name, Vec3& tangent, float& sign) {
  if (!point.mesh || point.primitive == kInsideVolume || !point.mesh->has_triangles()) return false;
  const int index = name.empty() ? point.mesh->active_uv : point.mesh->find_attribute(name);
  if (index < 0) return false;
  const Attribute& uv = point.mesh->attributes[index];
  const Vec2 uv0 = Vec2(point.mesh->interpolate(uv, point.primitive, Vec2(0.0f)));
  const Vec2 e1 = Vec2(point.mesh->interpolate(uv, point.primitive, Vec2(1.0f, 0.0f))) - uv0;
  const Vec2 e2 = Vec2(point.mesh->interpolate(uv, point.primitive, Vec2(0.0f, 1.0f))) - uv0;
  const float area = e1.x * e2.y - e1.y * e2.x;
  if (area == 0.0f) return false;
  sign = area < 0.0f ? -1.0f : 1.0f;
  tangent = normalize_or_zero((point.dpdu * e2.y - point.dpdv * e1.y) * sign);
  return true;
}

/// The normal of the front in object space, interpolated there. In a mesh that was moved to world space, this is not
/// the transformed world-space normal if the scale differs between the axes.
Vec3 front_in_object_space(const ShadingPoint& point, Vec3 front) {
  const BuiltMesh& mesh = *point.mesh;
  const auto in_object = [&](Vec3 n) { return point.instance ? normal_to_object(*point.instance, point.time, n) : n; };
  if (mesh.normals.empty()) return in_object(front);
  Corners n = mesh.corner_normals(point.primitive, point.time);
  if (mesh.baked)
    for (Vec3& normal : n) normal = in_object(normal);
  const Vec2 b = point.barycentric;
  const Vec3 sum = (1.0f - b.x - b.y) * n[0] + b.x * n[1] + b.y * n[2];
  return sum == Vec3(0.0f) ? in_object(front) : sum;
}

}  // namespace

bool smooth_tangent(const ShadingPoint& point, const std::string& uv, Vec3& tangent, float& sign) {
  if (!point.mesh || point.primitive == kInsideVolume || !point.mesh->has_triangles()) return false;
  constexpr std::string_view kPrefix = kTangentOf;
  for (const Attribute& attribute : point.undisplaced ? point.mesh->undisplaced->tangents : point.mesh->attributes) {
    if (attribute.name.size() != kPrefix.size() + uv.size() || !attribute.name.starts_with(kPrefix) ||
        !attribute.name.ends_with(uv) || attribute.components != 4)
      continue;
    const Vec4 value = point.mesh->interpolate(attribute, point.primitive, point.barycentric);
    tangent = Vec3(value);
    sign = value.w;
    return true;
  }
  return false;
}

Vec3 uv_tangent(const ShadingPoint& point, const std::string& name) {
  Vec3 tangent;
  float sign;
  if (smooth_tangent(point, name, tangent, sign))
    return tangent_of(point.ns, point.instance ? normal_to_world(*point.instance, point.time, tangent) : tangent);
  return triangle_tangent(point, name, tangent, sign) ? tangent_of(point.ns, tangent) : Vec3(0.0f);
}

Vec3 reflection(const ShadingPoint& point) {
  if (!point.instance) return point.wo;
  return 2.0f * glm::dot(point.ns, point.wo) * point.ns - point.wo;
}

namespace {

/// `n`, or a normal between it and that of the surface; the latter if `n` is 0.
Vec3 with_strength(Vec3 surface, Vec3 n, float strength) {
  if (strength != 1.0f) n = normalize_or_zero(surface + (n - surface) * std::max(strength, 0.0f));
  return n == Vec3(0.0f) ? surface : n;
}

}  // namespace

Vec3 normal_map(const ShadingPoint& point, NormalMapSpace space, NormalMapGeneration generation, const std::string& uv,
                float strength, Vec3 color) {
  const Vec3 surface = point.ns;
  const float side = point.backfacing ? -1.0f : 1.0f;
  Vec3 c = 2.0f * color - 1.0f, n;
  if (space == NormalMapSpace::Tangent) {
    Vec3 tangent;
    float sign;
    const Vec3 front = surface * side;
    if (generation != NormalMapGeneration::First) {
      c = {c.x * strength, c.y * strength, 1.0f + (c.z - 1.0f) * saturate(strength)};
      strength = 1.0f;
    }
    if (smooth_tangent(point, uv, tangent, sign)) {
      Vec3 up = front_in_object_space(point, front);
      if (generation == NormalMapGeneration::Third) up = normalize_or_zero(up);
      n = c.x * tangent + c.y * sign * glm::cross(up, tangent) + c.z * up;
      if (point.instance) n = normal_to_world(*point.instance, point.time, n);
      return with_strength(surface, normalize_or_zero(n) * side, strength);
    }
    if (!triangle_tangent(point, uv, tangent, sign)) return surface;
    if (point.instance && point.instance->flips_orientation) sign = -sign;
    tangent = tangent_of(front, tangent);
    n = c.x * tangent + c.y * sign * glm::cross(front, tangent) + c.z * front;
  } else {
    if (space == NormalMapSpace::BlenderObject || space == NormalMapSpace::BlenderWorld) c = {c.x, -c.y, -c.z};
    const bool object = space == NormalMapSpace::Object || space == NormalMapSpace::BlenderObject;
    n = object && point.instance ? normal_to_world(*point.instance, point.time, c) : c;
  }
  return with_strength(surface, normalize_or_zero(n) * side, strength);
}

bool is_near_edge(const ShadingPoint& point, float width) {
  if (!point.mesh || point.primitive == kInsideVolume || !point.mesh->has_triangles()) return false;
  const Vec3 from_first = point.barycentric.x * point.dpdu + point.barycentric.y * point.dpdv;
  const float most = sqr(0.5f * width);
  const auto is_near = [&](Vec3 edge, Vec3 from_corner) {
    return length_squared(glm::cross(edge, from_corner)) < length_squared(edge) * most;
  };
  return is_near(point.dpdu, from_first) || is_near(point.dpdv, from_first) ||
         is_near(point.dpdv - point.dpdu, from_first - point.dpdu);
}

float light_path(const ShadingPoint& point, LightPathOutput output) {
  const auto is = [&](uint32_t bit) { return point.ray_kind & bit ? 1.0f : 0.0f; };
  switch (output) {
    case LightPathOutput::IsCamera: return is(kRayCamera);
    case LightPathOutput::IsShadow: return is(kRayShadow);
    case LightPathOutput::IsDiffuse: return is(kRayDiffuse);
    case LightPathOutput::IsGlossy: return is(kRayGlossy);
    case LightPathOutput::IsSingular: return is(kRaySingular);
    case LightPathOutput::IsReflection: return is(kRayReflection);
    case LightPathOutput::IsTransmission: return is(kRayTransmission);
    case LightPathOutput::IsVolumeScatter: return is(kRayVolumeScatter);
    case LightPathOutput::RayLength: return point.ray_length;
    case LightPathOutput::RayDepth: return float(point.ray_depth);
    case LightPathOutput::DiffuseDepth: return float(point.diffuse_depth);
    case LightPathOutput::GlossyDepth: return float(point.glossy_depth);
    case LightPathOutput::TransparentDepth: return float(point.transparent_depth);
    case LightPathOutput::TransmissionDepth: return float(point.transmission_depth);
    case LightPathOutput::PortalDepth: return float(point.portal_depth);
  }
  return 0.0f;
}

float fresnel(float cosine, float eta) {
  const float c = std::abs(cosine), g2 = eta * eta - 1.0f + c * c;
  if (!(g2 > 0.0f)) return 1.0f;
  const float g = std::sqrt(g2), a = (g - c) / (g + c), b = (c * (g + c) - 1.0f) / (c * (g - c) + 1.0f);
  return 0.5f * a * a * (1.0f + b * b);
}

}  // namespace ajar::nodes
