#include "scene/scene.h"

#include <algorithm>

#include "scene/accel.h"

namespace ajar {

namespace {

/// Absolute values without the comparisons of glm::abs.
Vec3 absolute(Vec3 v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
Mat3 absolute(const Mat3& m) { return Mat3(glm::abs(m[0]), glm::abs(m[1]), glm::abs(m[2])); }

}  // namespace

Hit Scene::intersect(const Ray& ray, uint32_t ray_kind) const {
  Hit hit;
  accel_->intersect(ray, ray_kind, hit);
  return hit;
}

LampHit Scene::intersect_lamp(const Ray& ray, uint32_t ray_kind) const {
  LampHit hit;
  accel_->intersect_lamp(ray, ray_kind, hit);
  return hit;
}

bool Scene::is_blocked(const Ray& ray) const { return accel_->occluded(ray); }

bool Scene::is_blocked_by(const BuiltInstance& instance, const Ray& ray) const {
  return accel_->occluded_by(instance, meshes_[instance.mesh], ray);
}

Hit Scene::intersect_own(const BuiltInstance& instance, const Ray& ray) const {
  Hit hit;
  if (accel_->intersect_own(instance, meshes_[instance.mesh], ray, hit))
    hit.instance = uint32_t(&instance - instances_.data());
  return hit;
}

bool Scene::has_lamp_shapes() const { return accel_->has_lamps(); }

Color Scene::transmittance(const Ray& shadow_ray, int max_transparent, bool* by_ray_kind) const {
  if (by_ray_kind) *by_ray_kind = false;
  const uint32_t kind = by_ray_kind ? shadow_kind(shadow_ray) : uint32_t(kRayShadow);
  if (!any_transparent_ && kind == kRayShadow) return accel_->occluded(shadow_ray) ? Color(0.0f) : Color(1.0f);
  Color through(1.0f);
  Ray ray = shadow_ray;
  ShadingPoint point;
  for (int crossed = 0;;) {
    const Hit hit = intersect(ray, kind);
    if (!hit.found()) return through;
    const bool hidden = hidden_from_shadow_rays(hit);
    if (!shadow_rays_pass(hit) || (!hidden && crossed++ >= max_transparent)) return Color(0.0f);
    if (by_ray_kind) *by_ray_kind |= depends_on_ray_kind(hit);
    shading_point(ray, hit, point);
    point.ray_kind = kRayShadow;
    through *= transparency(hit, point);
    if (!(max_component(through) > 0.0f)) return Color(0.0f);
    ray = straight_on_to_end(point, ray);
    if (!(ray.t_max > 0.0f)) return through;
  }
}

void Scene::shading_point(const Ray& ray, const Hit& hit, ShadingPoint& point) const {
  const BuiltInstance& instance = instances_[hit.instance];
  const BuiltMesh& mesh = meshes_[instance.mesh];
  point.wo = -ray.direction;
  point.barycentric = hit.barycentric;
  point.primitive = hit.primitive;
  point.mesh = &mesh;
  point.instance = &instance;
  point.scene = this;
  point.object = &objects_[instance.object];
  point.ray_length = ray.travelled + hit.t;
  point.time = ray.time;
  if (mesh.triangles.empty()) [[unlikely]] {
    mesh.strands ? strand_point(ray, hit, point) : sphere_point(ray, hit, point);
    return;
  }
  const auto [p0, p1, p2] = mesh.corners(hit.primitive, ray.time);
  const float b1 = hit.barycentric.x, b2 = hit.barycentric.y, b0 = 1.0f - b1 - b2;
  point.position = b0 * p0 + b1 * p1 + b2 * p2;
  point.position_error = gamma_bound(7) * (absolute(b0 * p0) + absolute(b1 * p1) + absolute(b2 * p2));
  if (mesh.deformation) [[unlikely]]
    point.position_error += gamma_bound(5) * mesh.deformation->reach(mesh.triangles[hit.primitive], ray.time);
  point.dpdu = p1 - p0;
  point.dpdv = p2 - p0;
  Vec3 ng = glm::cross(point.dpdu, point.dpdv);
  Vec3 ns(0.0f);
  if (!mesh.normals.empty()) {
    const auto [n0, n1, n2] = mesh.corner_normals(hit.primitive, ray.time);
    ns = b0 * n0 + b1 * n1 + b2 * n2;
  }
  if (!mesh.baked) {
    Mat4 moved;
    const Mat4& m = world_from_object(instance, ray.time, moved);
    const Mat3 linear(m);
    const Mat3 absolute_linear = absolute(linear);
    const Vec3 on_mesh = point.position;
    point.position_error = absolute_linear * (point.position_error + gamma_bound(4) * glm::abs(point.position)) +
                           gamma_bound(4) * glm::abs(Vec3(m[3]));
    if (mesh.crowded) point.position_error *= 2.0f;  // the corners that the ray has met are rounded in world space
    point.position = transform_point(m, point.position);
    point.dpdu = linear * point.dpdu;
    point.dpdv = linear * point.dpdv;
    ng = glm::cross(point.dpdu, point.dpdv);
    if (instance.motion) {
      // The interpolated matrix has its own rounding errors.
      point.position_error += gamma_bound(4) * (absolute_linear * glm::abs(on_mesh) + glm::abs(Vec3(m[3])));
      ns = ns * glm::inverse(linear);
    } else {
      ns = ns * Mat3(instance.object_from_world);  // row vector times inverse = inverse transpose times column
    }
  }
  // A cross product of tiny edges can underflow: scale before normalising.
  float len2 = length_squared(ng);
  if (!(len2 > 1e-30f) || !(len2 < 1e30f)) {
    const float scale = 1.0f / std::max(max_component(glm::abs(point.dpdu)), max_component(glm::abs(point.dpdv)));
    ng = glm::cross(point.dpdu * scale, point.dpdv * scale);
    len2 = length_squared(ng);
  }
  ng = len2 > 0.0f ? ng / std::sqrt(len2) : -ray.direction;
  if (instance.flips_orientation) ng = -ng;
  const float ns_len2 = length_squared(ns);
  ns = ns_len2 > 0.0f && ns_len2 < kInfinity ? ns / std::sqrt(ns_len2) : ng;
  point.backfacing = glm::dot(ng, point.wo) < 0.0f;
  point.ng = point.backfacing ? -ng : ng;
  point.ns = point.backfacing ? -ns : ns;
}

void Scene::strand_point(const Ray& ray, const Hit& hit, ShadingPoint& point) const {
  const BuiltInstance& instance = instances_[hit.instance];
  const BuiltMesh& mesh = meshes_[instance.mesh];
  const Strands& strands = *mesh.strands;
  const Vec3 position = ray.origin + hit.t * ray.direction;
  Mat4 moved, inverse(1.0f);
  const Mat4& world = mesh.baked ? inverse : world_from_object(instance, ray.time, moved);
  Vec3 along = strands.tangent(hit.primitive, hit.barycentric.x, ray.time), to_ray = -ray.direction,
       in_object = position;
  if (!mesh.baked) {
    inverse = instance.motion ? glm::affineInverse(world) : instance.object_from_world;
    to_ray = transform_vector(inverse, to_ray);
    in_object = transform_point(inverse, position);
  }
  Vec3 ns;
  if (strands.shape == StrandShape::Ribbon) {
    // The normal of the tube at the point that an orthographic view along the ray would see here.
    const Vec3 across = glm::cross(along, to_ray), outwards = glm::cross(across, along);
    const float width = glm::length(across), height = glm::length(outwards);
    const float sine = glm::clamp(hit.barycentric.y, -1.0f, 1.0f);
    ns = width > 0.0f && height > 0.0f ? across * (sine / width) + outwards * (safe_sqrt(1.0f - sqr(sine)) / height)
                                       : to_ray;
  } else {
    ns = in_object - strands.center(hit.primitive, hit.barycentric.x, ray.time);
  }
  if (!mesh.baked) {
    ns = ns * Mat3(inverse);  // the transpose of the inverse
    along = transform_vector(world, along);
  }
  const float length = glm::length(ns);
  point.ns = length > 0.0f && length < kInfinity ? ns / length : point.wo;
  // At the rim, the normal is perpendicular to the ray, and rounding could put it on the wrong side.
  if (!(glm::dot(point.ns, point.wo) > 1e-4f))
    point.ns = glm::normalize(point.ns + (1e-4f - glm::dot(point.ns, point.wo)) * point.wo);
  point.ng = point.ns;
  point.backfacing = false;
  point.position = position;
  // Embree transforms curves into a space around the ray, where the error grows with the distance.
  point.position_error = Vec3(gamma_bound(8) * (max_component(glm::abs(ray.origin)) + hit.t));
  point.dpdu = along;
  point.dpdv = glm::cross(along, point.ng);
}

void Scene::sphere_point(const Ray& ray, const Hit& hit, ShadingPoint& point) const {
  const BuiltInstance& instance = instances_[hit.instance];
  const BuiltMesh& mesh = meshes_[instance.mesh];
  const Vec4 sphere = mesh.points->sphere(hit.primitive, ray.time);
  Mat4 moved, moved_inverse;
  const Mat4 identity(1.0f);
  const Mat4& world = mesh.baked ? identity : world_from_object(instance, ray.time, moved);
  const Mat4& inverse = mesh.baked ? identity : object_from_world(instance, ray.time, moved_inverse);
  const Vec3 out = entry_of_sphere(sphere, transform_point(inverse, ray.origin),
                                   transform_vector(inverse, ray.direction));
  const Vec3 in_object = Vec3(sphere) + sphere.w * out;
  point.position = transform_point(world, in_object);
  point.position_error = absolute(Mat3(world)) * (gamma_bound(12) * (absolute(Vec3(sphere)) + sphere.w)) +
                         gamma_bound(8) * absolute(Vec3(world[3]));
  point.ng = glm::normalize(out * Mat3(inverse));  // the transpose of the inverse
  // On the ellipsoids of scaled instances, the shading normal is the direction from the centre, as in Cycles.
  point.ns = glm::normalize(transform_vector(world, out));
  // At the rim, the normal is perpendicular to the ray, and rounding could put it on the wrong side.
  for (Vec3* n : {&point.ng, &point.ns})
    if (!(glm::dot(*n, point.wo) > 1e-6f)) *n = glm::normalize(*n + (1e-6f - glm::dot(*n, point.wo)) * point.wo);
  point.backfacing = false;
  const Vec3 n = point.ns;  // the tangents of Cycles 5.2
  point.dpdu = glm::normalize(n.x != n.y || n.x != n.z ? Vec3(n.z - n.y, n.x - n.z, n.y - n.x)
                                                       : Vec3(n.z - n.y, n.x + n.z, -n.y - n.x));
  point.dpdv = glm::cross(n, point.dpdu);
}

int Scene::material_index(const Hit& hit) const {
  const BuiltInstance& instance = instances_[hit.instance];
  const BuiltMesh& mesh = meshes_[instance.mesh];
  uint32_t slot = mesh.material_slots.empty() ? 0 : mesh.material_slots[hit.primitive];
  // Blender uses the last slot for faces whose slot was removed.
  slot = std::min(slot, instance.material_count - 1);
  return int(material_table_[instance.first_material + slot]);
}

int Scene::material_index(const ShadingPoint& point) const {
  Hit hit;
  hit.instance = uint32_t(point.instance - instances_.data());
  hit.primitive = point.primitive;
  return material_index(hit);
}

const ShaderProgram& Scene::material(const Hit& hit) const { return programs_[size_t(material_index(hit))]; }

int Scene::light_of(const Hit& hit) const {
  const uint32_t first = instances_[hit.instance].first_light;
  return first == ~0u ? -1 : int(first + hit.primitive);
}

bool Scene::has_subsurface() const {
  return std::any_of(programs_.begin(), programs_.end(), [](const ShaderProgram& p) { return p.has_subsurface(); });
}

bool Scene::emission_without_lights() const {
  for (const BuiltInstance& instance : instances_) {
    if (instance.first_light != ~0u) continue;
    for (uint32_t slot = 0; slot < instance.material_count; ++slot) {
      if (programs_[material_table_[instance.first_material + slot]].emits()) return true;
    }
  }
  return false;
}

float Scene::light_importance(uint32_t light) const {
  if (light < lamp_importances_.size()) return lamp_importances_[light];
  if (int(light) == lights_.environment_index()) return world_light_importance_;
  return objects_[instances_[lights_.light(light).instance].object].light_importance;
}

bool Scene::any_light_importance() const {
  const auto emits = [&](uint32_t material) { return programs_[material].emits(); };
  return (world_light_importance_ != 1.0f && lights_.environment_index() >= 0) ||
         std::any_of(lamp_importances_.begin(), lamp_importances_.end(),
                     [](float importance) { return importance != 1.0f; }) ||
         std::any_of(instances_.begin(), instances_.end(), [&](const BuiltInstance& instance) {
           const auto materials = materials_of(instance);
           return objects_[instance.object].light_importance != 1.0f &&
                  std::any_of(materials.begin(), materials.end(), emits);
         });
}

int Scene::light_group(uint32_t light) const {
  if (light < lamp_groups_.size()) return lamp_groups_[light];
  if (int(light) == lights_.environment_index()) return world_group_;
  return object_groups_[instances_[lights_.light(light).instance].object];
}

int Scene::light_group_of(const ObjectDescription& object) const {
  return object_groups_[size_t(&object - objects_.data())];
}

std::array<float, 3> Scene::matte_ids(const ShadingPoint& point) const {
  const uint32_t object = point.instance->object;
  return {object_mattes_[object], material_mattes_[size_t(material_index(point))], asset_mattes_[object]};
}

namespace {

/// The rounding errors of the place where a sphere is left, and of its tangent plane, are added.
float way_out_of_sphere(const ShadingPoint& point, Vec3 direction) {
  const Vec4 sphere = point.mesh->points->sphere(point.primitive, point.time);
  Mat4 moved;
  const Mat4 identity(1.0f);
  const Mat4& inverse = point.mesh->baked ? identity : object_from_world(*point.instance, point.time, moved);
  const Vec3 out = transform_point(inverse, point.position) - Vec3(sphere), way = transform_vector(inverse, direction);
  const float chord = -2.0f * glm::dot(out, way) / length_squared(way);
  const float left = 1.0001f * chord + 4.0f * max_component(point.position_error);
  return chord > 0.0f && std::isfinite(left) ? left : 0.0f;
}

}  // namespace

float way_out(const ShadingPoint& point, Vec3 direction) {
  if (point.mesh->points) return way_out_of_sphere(point, direction);
  constexpr float kMaxRadii = 20.0f;  // nearly along the strand, the way is long and can cross other strands
  const Strands& strands = *point.mesh->strands;
  if (strands.shape != StrandShape::Ribbon) return 0.0f;
  const Mat3 linear = point.mesh->baked ? Mat3(1.0f) : Mat3(point.instance->world_from_object);
  const float scale = std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
  const float radius = scale * strands.radius(point.primitive, point.barycentric.x, point.time);
  const float sine = glm::length(glm::cross(direction, point.dpdu)) / glm::length(point.dpdu);
  const float way = radius * std::min(1.02f / std::max(sine, 1e-6f), kMaxRadii) +
                    4.0f * max_component(point.position_error);
  return std::isfinite(way) ? way : 0.0f;
}

void Scene::count_textures() {
  statistics_.tiled_textures = uint64_t(textures_->tiled_count());
  statistics_.made_textures = uint64_t(textures_->made_count());
  statistics_.kept_textures = uint64_t(textures_->kept_count());
  statistics_.texture_bytes = textures_->memory_bytes();
}

}  // namespace ajar
