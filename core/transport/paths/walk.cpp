#include "transport/paths/walk.h"

#include "transport/paths/light_walk_guide.h"

namespace ajar {

namespace {

/// Barycentric coordinates of p in the triangle.
Vec2 barycentric_of(const Light& triangle, Vec3 p) {
  const Vec3 d = p - triangle.position;
  const float d11 = glm::dot(triangle.edge1, triangle.edge1), d12 = glm::dot(triangle.edge1, triangle.edge2),
              d22 = glm::dot(triangle.edge2, triangle.edge2);
  const float p1 = glm::dot(d, triangle.edge1), p2 = glm::dot(d, triangle.edge2);
  const float determinant = d11 * d22 - d12 * d12;
  if (!(determinant > 0.0f)) return Vec2(1.0f / 3.0f);
  const float b1 = saturate((d22 * p1 - d12 * p2) / determinant);
  return {b1, std::clamp((d11 * p2 - d12 * p1) / determinant, 0.0f, 1.0f - b1)};
}

void reset(PathVertex& vertex, VertexKind kind) {
  vertex.kind = kind;
  vertex.specular = vertex.distant = vertex.delta = false;
  vertex.light = -1;
  vertex.pass = 0.0f;
  vertex.program = nullptr;
  vertex.shading.bsdf = Bsdf();
  vertex.shading.emission = Color(0.0f);
  vertex.point = ShadingPoint();
}

}  // namespace

void make_lens_vertex(const Scene& scene, Vec2 u_lens, PathVertex& lens) {
  const Camera& camera = scene.camera();
  reset(lens, VertexKind::Lens);
  lens.distant = camera.is_orthographic();
  lens.point.position = camera.sample_lens_point(u_lens);
  lens.point.ng = lens.distant ? camera.orthographic_direction(lens.point.position) : camera.forward();
}

Ray start_at_lens(const Scene& scene, Vec2 film, Vec2 u_lens, PathVertex& lens, float& density) {
  make_lens_vertex(scene, u_lens, lens);
  const Ray ray = scene.camera().generate_ray(film, u_lens, 0.0f);
  density = sees_nothing(ray) ? 0.0f : scene.camera().film_density(ray.direction);
  return ray;
}

void make_light_vertex(const Scene& scene, uint32_t index, Vec3 position, Vec3 normal, Vec3 to_eye, PathVertex& light) {
  const LightSet& lights = scene.lights();
  const LightFlags flags = lights.flags(index);
  reset(light, VertexKind::Light);
  light.light = int(index);
  if (flags.type == LightType::Triangle) {
    const Light triangle = lights.light(index);
    Hit hit;
    hit.instance = triangle.instance;
    hit.primitive = triangle.primitive;
    hit.barycentric = barycentric_of(triangle, position);
    Ray ray;
    ray.direction = -to_eye;
    light.program = &scene.material(hit);
    scene.shading_point(ray, hit, light.point);
    light.point.ray_kind = 0;
    light.shading.emission = light.program->evaluate_emission(light.point);
    if (light.program->may_be_transparent())
      light.pass = pass_probability(*light.program, light.program->evaluate_transparency(light.point));
    return;
  }
  light.distant = is_distant(flags.type);
  light.delta = is_delta(flags.type);
  light.point.position = position;
  if (!light.distant) light.point.position_error = Vec3(lamp_position_error(position));
  light.point.ng = light.distant ? to_eye : normal;
  light.point.wo = to_eye;
}

void make_light_vertex(const PathVertex& surface, PathVertex& light) {
  light.kind = VertexKind::Light;
  light.specular = light.distant = light.delta = false;
  light.light = surface.light;
  light.pass = surface.pass;
  light.program = surface.program;
  light.point = surface.point;
  light.shading.bsdf = Bsdf();
  light.shading.emission = surface.shading.emission;
}

void make_light_vertex(const Scene& scene, const LightMet& met, Vec3 to_eye, PathVertex& light) {
  make_light_vertex(scene, met.light, met.position, met.normal, to_eye, light);
  light.shading.emission = met.radiance;
}

uint32_t likely_flags(const Bsdf& bsdf, Vec3 wo, Vec3 wi) {
  const Bsdf::KindShares shares = bsdf.kind_shares(wo, wi, false);
  const float most = std::max({shares.diffuse, shares.glossy, shares.transmission, shares.diffuse_transmission});
  if (shares.diffuse == most) return kDiffuse;
  if (shares.glossy == most) return kGlossy;
  return shares.transmission == most ? uint32_t(kTransmission) : uint32_t(kTransmission | kDiffuse);
}

Ray leave_light(const Scene& scene, const PathVertex& light, Vec3 to_eye) {
  if (light.program) return scene.spawn_ray(light.point, to_eye);
  Ray ray;
  ray.origin = light.position();
  ray.direction = to_eye;
  return ray;
}

bool start_at_light(const Scene& scene, const LightWalkGuide* guide, float u_choice, Vec2 u_position, Vec2 u_direction,
                    PathVertex& light, Ray& ray) {
  const LightSet& lights = scene.lights();
  if (lights.empty()) return false;
  if (guide && guide->sets_out(u_choice)) {
    const LightWalkGuide::Start start = guide->start(lights, u_choice, u_position, u_direction);
    make_light_vertex(scene, start.light, start.position, start.normal, start.direction, light);
    ray = leave_light(scene, light, start.direction);
    return true;
  }
  const LightSet::Choice choice = lights.choose_by_power(u_choice);
  if (!(choice.pmf > 0.0f)) return false;
  const auto sample = lights.sample_le(choice.light, u_position, u_direction, 0.0f);
  if (!sample || is_black(sample->radiance)) return false;
  make_light_vertex(scene, choice.light, sample->ray.origin, sample->normal, sample->ray.direction, light);
  ray = light.program ? scene.spawn_ray(light.point, sample->ray.direction) : sample->ray;
  return true;
}

bool sample_light(const Scene& scene, const PathVertex& at, float u_choice, Vec2 u, PathVertex& light) {
  const LightSet& lights = scene.lights();
  if (!lights.can_choose()) return false;
  const LightSet::Choice choice = lights.choose(at.position(), at.shading.bsdf.receiving_normal(), u_choice);
  if (!(choice.pmf > 0.0f)) return false;
  const auto sample = lights.sample_li(choice.light, at.position(), u, at.point.time);
  if (!sample || is_black(sample->radiance)) return false;
  make_light_vertex(scene, choice.light, sample->position, sample->normal, -sample->wi, light);
  return true;
}

bool find_light_end(const Scene& scene, const Ray& ray, uint32_t ray_kind, Sampler& sampler, PathVertex& light,
                    Through& through, uint64_t& rays) {
  PathVertex surface;
  surface.point.ray_kind = ray_kind;
  bool chosen = false, escaped = false;
  Through before_light;
  const auto watch = [&](const Ray& stretch, float t_end, bool found, const Through& passed) {
    if (!chosen && scene.has_lamp_shapes())
      for_each_lamp_crossed(scene, stretch, t_end, kLightWalkKind, [&](const LightMet& met) {
        if (chosen || sampler.get_1d() >= kLampStop) return;
        make_light_vertex(scene, met, -ray.direction, light);
        before_light = passed;
        chosen = true;
      });
    if (!found) escaped = true, before_light = chosen ? before_light : passed;
  };
  const bool hit = find_vertex(scene, ray, sampler, surface, through, rays, watch);
  if (chosen) {
    through = before_light;
    return true;
  }
  if (hit) {
    if (!surface.emits()) return false;
    make_light_vertex(surface, light);
    return true;
  }
  if (!escaped) return false;  // the walk passed too many surfaces
  through = before_light;
  int met_count = 0;
  const auto count = [&](const LightMet&) { ++met_count; };
  for_each_distant_light(scene, ray, kLightWalkKind, true, count);
  if (met_count == 0) return false;
  int left = std::min(int(sampler.get_1d() * float(met_count)), met_count - 1);
  for_each_distant_light(scene, ray, kLightWalkKind, true, [&](const LightMet& met) {
    if (left-- == 0) make_light_vertex(scene, met, -ray.direction, light);
  });
  return true;
}

}  // namespace ajar
