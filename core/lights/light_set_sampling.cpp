#include "lights/light_set_data.h"

namespace ajar {

std::optional<LightSample> LightSet::sample_li(uint32_t index, Vec3 p, Vec2 u, float time, uint32_t ray_kind) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) return d.sample_lamp(d.lamps[index], p, u, time, ray_kind);
  LightSample s;
  s.delta = false;
  if (d.is_environment(index)) {
    s.wi = d.environment.sample(u, s.pdf_solid_angle);
    s.distance = kInfinity;
    s.radiance = d.environment.radiance(s.wi, ray_kind);
    s.position = Vec3(0.0f);
    s.normal = -s.wi;
    return s;
  }
  const Data::TriangleBlock& block = d.block_of(index);
  const uint32_t primitive = index - block.first;
  const BuiltInstance& instance = d.instances[block.instance];
  const BuiltMesh& mesh = d.meshes[instance.mesh];
  const WorldTriangle triangle = world_triangle(mesh, instance, primitive, time);
  const TriangleSample on_triangle = sample_triangle_li(triangle, p, u);
  if (!(on_triangle.pdf_solid_angle > 0.0f)) return std::nullopt;
  s.wi = on_triangle.wi;
  s.distance = on_triangle.distance;
  s.pdf_solid_angle = on_triangle.pdf_solid_angle;
  s.position = p + s.wi * s.distance;
  s.normal = triangle.normal;
  s.position_error = triangle_position_error(mesh, instance, primitive, time);
  s.blockers = block.blockers;
  const Data::SlotEmission& emission = d.emission_of(block, primitive);
  if (emission.constant) {
    s.radiance = emission.radiance;
  } else {
    ShadingPoint point = triangle_point(d.objects[instance.object],
                                        {mesh, instance, primitive, triangle, time, s.distance},
                                        on_triangle.barycentric, -s.wi);
    point.ray_kind = ray_kind;
    s.radiance = emission.program->evaluate_emission(point);
  }
  return s;
}

float LightSet::pdf_li(uint32_t index, Vec3 p, Vec3 wi, float distance, Vec3 light_normal, float time) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) {
    const Light& lamp = d.lamps[index];
    if (lamp.type == LightType::DistantDisk && !distant_disk_contains(index, wi)) return 0.0f;
    return pdf_lamp_li(lamp, p, wi, distance, light_normal);
  }
  if (d.is_environment(index)) return d.environment.pdf_solid_angle(wi);
  const Data::TriangleBlock& block = d.block_of(index);
  const BuiltInstance& instance = d.instances[block.instance];
  const WorldTriangle triangle = world_triangle(d.meshes[instance.mesh], instance, index - block.first, time);
  return pdf_triangle_li(triangle, p, wi, distance);
}

Color LightSet::lamp_radiance(uint32_t index, Vec3 position, Vec3 wo, float time, float distance,
                              uint32_t ray_kind) const {
  return data_->lamp_radiance(data_->lamps[index], position, wo, time, distance, ray_kind);
}

Color LightSet::environment_radiance(Vec3 wi, uint32_t ray_kind) const {
  return data_->environment.radiance(wi, ray_kind);
}

bool LightSet::distant_disk_contains(uint32_t index, Vec3 wi) const {
  const Light& sun = data_->lamps[index];
  // Compare tangents: cosines do not resolve half a degree.
  const Vec3 local = sun.frame.to_local(-wi);
  return local.z > 0.0f && local.x * local.x + local.y * local.y <= sqr(sun.radius * local.z);
}

std::optional<LightRay> LightSet::sample_le(uint32_t index, Vec2 u_position, Vec2 u_direction, float time) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) {
    const Light& lamp = d.lamps[index];
    auto r = sample_lamp_le(lamp, u_position, u_direction, d.scene_center, d.scene_radius);
    if (!r) return r;
    r->ray.time = time;
    if (lamp.shader >= 0)
      r->radiance *= d.shader_factor(lamp, r->ray.origin, r->ray.direction, time, kUsualDistance, 0);
    return r;
  }
  LightRay r;
  r.ray.time = time;
  if (d.is_environment(index)) {
    const Vec3 wi = d.environment.sample(u_direction, r.pdf_solid_angle);
    r.radiance = d.environment.radiance(wi, 0);
    r.ray.direction = r.normal = -wi;
    const Vec2 on_disk = d.scene_radius * warp::square_to_disk(u_position);
    const Frame frame(r.ray.direction);
    r.ray.origin = d.scene_center - d.scene_radius * r.ray.direction + on_disk.x * frame.s + on_disk.y * frame.t;
    r.pdf_area = kInvPi / sqr(d.scene_radius);
    return r;
  }
  const Data::TriangleBlock& block = d.block_of(index);
  const uint32_t primitive = index - block.first;
  const BuiltInstance& instance = d.instances[block.instance];
  const BuiltMesh& mesh = d.meshes[instance.mesh];
  const WorldTriangle triangle = world_triangle(mesh, instance, primitive, time);
  if (!(triangle.area > 0.0f)) return std::nullopt;
  const Vec2 barycentric = warp::square_to_triangle(u_position);
  // Half of the random numbers for each side.
  const bool front = u_direction.x < 0.5f;
  u_direction.x = front ? 2.0f * u_direction.x : 2.0f * u_direction.x - 1.0f;
  const Vec3 side = front ? triangle.normal : -triangle.normal;
  const Vec3 local = warp::square_to_cosine_hemisphere(u_direction);
  r.ray.origin = triangle.p0 + barycentric.x * triangle.e1 + barycentric.y * triangle.e2;
  r.ray.direction = Frame(side).to_world(local);
  r.normal = triangle.normal;
  r.pdf_area = 1.0f / triangle.area;
  r.pdf_solid_angle = 0.5f * warp::cosine_hemisphere_pdf_solid_angle(local.z);
  if (!(r.pdf_solid_angle > 0.0f)) return std::nullopt;
  const Data::SlotEmission& emission = d.emission_of(block, primitive);
  if (!emission.program) return std::nullopt;
  r.barycentric = barycentric;
  const SeenTriangle seen{mesh, instance, primitive, triangle, time, kUsualDistance};
  r.radiance = emission.constant ? emission.radiance
                                 : emission.program->evaluate_emission(
                                       triangle_point(d.objects[instance.object], seen, barycentric, r.ray.direction));
  return r;
}

bool LightSet::depends_on_distance(uint32_t index) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) {
    const int shader = d.lamps[index].shader;
    return shader >= 0 && d.lamp_programs[shader].emission_depends_on_distance();
  }
  if (d.is_environment(index)) return false;
  const Data::TriangleBlock& block = d.block_of(index);
  const ShaderProgram* program = d.emission_of(block, index - block.first).program;
  return program && program->emission_depends_on_distance();
}

Color LightSet::falloff(uint32_t index, const LightRay& ray, float distance) const {
  const Data& d = *data_;
  const auto radiance_at = [&](float at) {
    if (d.is_lamp(index))
      return d.shader_factor(d.lamps[index], ray.ray.origin, ray.ray.direction, ray.ray.time, at, 0);
    const Data::TriangleBlock& block = d.block_of(index);
    const uint32_t primitive = index - block.first;
    const BuiltInstance& instance = d.instances[block.instance];
    const BuiltMesh& mesh = d.meshes[instance.mesh];
    const WorldTriangle triangle = world_triangle(mesh, instance, primitive, ray.ray.time);
    return d.emission_of(block, primitive)
        .program->evaluate_emission(triangle_point(d.objects[instance.object],
                                                   {mesh, instance, primitive, triangle, ray.ray.time, at},
                                                   ray.barycentric, ray.ray.direction));
  };
  const Color there = radiance_at(distance), usual = radiance_at(kUsualDistance);
  Color ratio(0.0f);
  for (int c = 0; c < 3; ++c)
    if (usual[c] != 0.0f) ratio[c] = there[c] / usual[c];
  return ratio;
}

LightSet::LePdf LightSet::pdf_le(uint32_t index, Vec3 normal, Vec3 direction, float time) const {
  const Data& d = *data_;
  LePdf pdf{0.0f, 0.0f};
  if (d.is_lamp(index)) {
    const Light& lamp = d.lamps[index];
    pdf_lamp_le(lamp, normal, direction, d.scene_radius, pdf.pdf_area, pdf.pdf_solid_angle);
    if (lamp.type == LightType::DistantDisk && !distant_disk_contains(index, -direction)) pdf.pdf_solid_angle = 0.0f;
    return pdf;
  }
  if (d.is_environment(index)) return {kInvPi / sqr(d.scene_radius), d.environment.pdf_solid_angle(-direction)};
  const Data::TriangleBlock& block = d.block_of(index);
  const BuiltInstance& instance = d.instances[block.instance];
  const WorldTriangle triangle = world_triangle(d.meshes[instance.mesh], instance, index - block.first, time);
  if (!(triangle.area > 0.0f)) return pdf;
  return {1.0f / triangle.area, 0.5f * kInvPi * abs_dot(triangle.normal, direction)};
}

}  // namespace ajar
