#include "shading/functions/bump.h"

#include "geometry/geometry.h"
#include "shading/functions/math_functions.h"
#include "shading/functions/point_functions.h"

namespace ajar::nodes {

float pixel_width(const ShadingPoint& point, const BumpFootprint& footprint) {
  if (footprint.camera == CameraKind::Orthographic) return footprint.pixel;
  const Vec3 p = transform_point(footprint.camera_from_world, point.position);
  const float distance = std::sqrt(length_squared(p));
  if (!(distance > 0.0f)) return footprint.pixel;
  if (footprint.camera != CameraKind::Perspective) return footprint.pixel * distance;
  // A pixel far from the centre of the image spans a smaller angle. The minimum of the cosine is for points behind the
  // camera or far outside its image, where the width is unknown.
  const Vec3 d = p / distance;
  const float cosine = std::max(-d.z, 0.3f);
  return 0.5f * footprint.pixel * distance * cosine * (safe_sqrt(1.0f - d.x * d.x) + safe_sqrt(1.0f - d.y * d.y));
}

BumpOffsets bump_offsets(const ShadingPoint& point, const BumpFootprint& footprint, float filter_width) {
  const Vec3 n = point.ng;
  // Apart from rounding and the size of the step, any direction in the plane is equally good. This is the direction
  // that Cycles uses.
  Vec3 x = n.x != n.y || n.x != n.z ? Vec3(n.z - n.y, n.x - n.z, n.y - n.x) : Vec3(n.z - n.y, n.x + n.z, -n.y - n.x);
  x = normalize_or_zero(x);
  const float size = pixel_width(point, footprint) * filter_width;
  return {size * x, size * glm::cross(n, x)};
}

ShadingPoint shifted(const ShadingPoint& point, Vec3 offset) {
  ShadingPoint moved = point;
  moved.position += offset;
  // Least squares: offset = a dpdu + b dpdv.
  const float uu = length_squared(point.dpdu), uv = glm::dot(point.dpdu, point.dpdv), vv = length_squared(point.dpdv);
  const float u = glm::dot(point.dpdu, offset), v = glm::dot(point.dpdv, offset), determinant = uu * vv - uv * uv;
  if (determinant > 0.0f) moved.barycentric += Vec2(vv * u - uv * v, uu * v - uv * u) / determinant;
  return moved;
}

ShadingPoint undisplaced(const ShadingPoint& point) {
  ShadingPoint original = point;
  if (!point.mesh || !point.mesh->undisplaced || !point.instance) return original;
  original.undisplaced = true;
  const BuiltMesh& mesh = *point.mesh;
  const Undisplaced& surface = *mesh.undisplaced;
  const UVec3 v = mesh.triangles[point.primitive];
  const float b1 = point.barycentric.x, b2 = point.barycentric.y, b0 = 1.0f - b1 - b2;
  const auto mean = [&](const Vec3& a, const Vec3& b, const Vec3& c) { return b0 * a + b1 * b + b2 * c; };
  original.position = mean(surface.positions[v.x], surface.positions[v.y], surface.positions[v.z]);
  original.dpdu = surface.positions[v.y] - surface.positions[v.x];
  original.dpdv = surface.positions[v.z] - surface.positions[v.x];
  const std::vector<Vec3>& n = surface.normals;
  const size_t first = size_t(point.primitive) * 3;
  original.ns = n.empty()                              ? Vec3(0.0f)
                : mesh.normal_domain == Domain::Vertex ? mean(n[v.x], n[v.y], n[v.z])
                                                       : mean(n[first], n[first + 1], n[first + 2]);
  if (!mesh.baked) {
    Mat4 moved, inverse;
    const Mat4& world = world_from_object(*point.instance, point.time, moved);
    original.position = transform_point(world, original.position);
    original.dpdu = transform_vector(world, original.dpdu);
    original.dpdv = transform_vector(world, original.dpdv);
    original.ns = original.ns * Mat3(object_from_world(*point.instance, point.time, inverse));
  }
  const float side = point.backfacing ? -1.0f : 1.0f;
  original.ng = normalize_or_zero(glm::cross(original.dpdu, original.dpdv)) *
                (point.instance->flips_orientation ? -side : side);
  if (original.ng == Vec3(0.0f)) original.ng = point.ng;
  original.ns = normalize_or_zero(original.ns) * side;
  if (original.ns == Vec3(0.0f)) original.ns = original.ng;
  // Directions below this surface are not bent: the displaced surface decides which normals are safe.
  if (!(glm::dot(original.wo, original.ng) > 0.0f)) original.wo = original.ng;
  return original;
}

Vec3 bump(const BumpOffsets& offsets, const BumpHeights& heights, float strength, float distance, Vec3 normal) {
  const Vec3 rx = glm::cross(offsets.y, normal), ry = glm::cross(normal, offsets.x);
  const float determinant = glm::dot(offsets.x, rx);
  const Vec3 gradient = (heights.x - heights.here) * rx + (heights.y - heights.here) * ry;
  const Vec3 turned = normalize_or_zero(std::abs(determinant) * normal -
                                        distance * std::copysign(1.0f, determinant) * gradient);
  Vec3 n = normal;
  if (turned != Vec3(0.0f)) {
    strength = std::max(strength, 0.0f);
    n = normalize_or_zero(strength * turned + (1.0f - strength) * normal);
  }
  return n == Vec3(0.0f) ? normal : n;
}

Vec3 displacement(const ShadingPoint& point, DisplacementSpace space, float amount, Vec3 normal) {
  if (space == DisplacementSpace::World || !point.instance) return amount * normal;
  const BuiltInstance& instance = *point.instance;
  Mat4 moved;
  return amount * transform_vector(world_from_object(instance, point.time, moved),
                                   normal_to_object(instance, point.time, normal));
}

Vec3 vector_displacement(const ShadingPoint& point, DisplacementSpace space, Vec3 vector) {
  if (space == DisplacementSpace::World || !point.instance) return vector;
  const BuiltInstance& instance = *point.instance;
  Mat4 moved;
  if (space == DisplacementSpace::Tangent) {  // tangent, normal, bitangent
    const Vec3 n = normal_to_object(instance, point.time, point.ns);
    Vec3 t;
    float sign = 1.0f;
    if (!smooth_tangent(point, "", t, sign))
      t = normalize_or_zero(transform_vector(object_from_world(instance, point.time, moved), uv_tangent(point, "")));
    vector = vector.x * t + vector.y * n + vector.z * sign * normalize_or_zero(glm::cross(n, t));
  }
  return transform_vector(world_from_object(instance, point.time, moved), vector);
}

}  // namespace ajar::nodes
