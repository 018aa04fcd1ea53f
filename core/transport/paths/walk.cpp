#include "transport/paths/walk.h"

#include "lights/sources/lamp.h"
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
  vertex.specular = vertex.distant = vertex.delta = vertex.exit = vertex.eye_only = false;
  vertex.light = -1;
  vertex.pass = 0.0f;
  vertex.program = nullptr;
  vertex.shading.bsdf = Bsdf();
  vertex.shading.emission = Color(0.0f);
  vertex.point = ShadingPoint();
}

/// MediaRay::attenuated_as.
uint32_t attenuated_as(const Through& through) {
  return through.by_kind >= RayKindSurfaces::FromLight ? uint32_t(kRayShadow) : 0u;
}

/// Multiplies the stretch into what the ray passed. The first stretch also gives the rate at the start.
void add_stretch(const MediaStretch& stretch, Through& through) {
  through.transmittance *= stretch.transmittance;
  through.pass *= stretch.pass;
  if (through.stretches++ == 0) through.start_rate = stretch.rate;
}

}  // namespace

bool walk_in_media(const PathMedia& media, const Ray& ray, const Hit& hit, Sampler& sampler, PathVertex& vertex,
                   Through& through) {
  Collisions& collisions = through.collisions;
  const MediaStack& stack = vertex.media.stack;
  const float t_end = hit.found() ? hit.t : kInfinity;
  const bool given = collisions.kind == Collisions::Kind::AtDistance, here = given && collisions.distance < t_end;
  if (stack.empty()) {
    collisions.distance -= t_end;
    if (here) vertex.kind = VertexKind::Surface;
    return here;
  }
  const MediaRay along{stack, ray, t_end, vertex.point, vertex.point.ray_kind, attenuated_as(through)};
  MediaStretch stretch;
  MediumPoint at;
  float t = 0.0f;
  bool collides = here;
  if (collisions.kind == Collisions::Kind::Sampled) {
    collides = media.sample(along, sampler, stretch, t, at);
  } else {
    MediaRay travelled = along;
    if (here) t = travelled.t_end = collisions.distance;
    Pcg32 rng = media_numbers(sampler);
    stretch = media.pass(travelled, rng);
    if (here) at = media.at(along, t);
    collisions.distance -= t_end;
  }
  add_stretch(stretch, through);
  if (!collides) return false;
  through.end_rate = stretch.rate;
  const ShadingPoint inside = inside_of(along);
  reset(vertex, VertexKind::Medium);
  vertex.shading.holdout = 0.0f;
  vertex.media.at = at;
  vertex.media.receiver_set = media.media().receiver_set(stack);
  vertex.point = inside;
  vertex.point.position = ray.origin + t * ray.direction;
  vertex.point.position_error = Vec3(0.0f);
  vertex.point.mesh = nullptr;
  vertex.point.instance = nullptr;
  vertex.point.object = nullptr;
  return true;
}

Through through_to(const PathMedia& media, const MediaStack& stack, const Ray& ray, float t, const ShadingPoint& path,
                   Sampler& sampler, const Through& passed) {
  Through through = passed;
  if (stack.empty()) return through;
  Pcg32 rng = media_numbers(sampler);
  const MediaStretch stretch = media.pass({stack, ray, t, path, path.ray_kind, attenuated_as(through)}, rng);
  add_stretch(stretch, through);
  return through;
}

bool passes_as_shadow(const Scene& scene, const Hit& hit, const ShadingPoint& point, Sampler& sampler,
                      Through& through) {
  if (!scene.shadow_rays_pass(hit) || through.surfaces >= scene.settings().bounces.transparent) return false;
  ShadingPoint of_shadow = point;
  of_shadow.ray_kind = kRayShadow;
  const ShaderProgram& program = scene.material(hit);
  const Color transparency = scene.transparency(hit, of_shadow);
  const float pass = pass_probability(program, transparency), chance = scene.is_eye_only(hit) ? 1.0f : 0.5f;
  if (!(pass > 0.0f)) return false;
  if (sampler.get_1d() >= chance * pass) {
    through.chance *= 1.0f - chance * pass;
    return false;
  }
  ++through.surfaces;
  through.transmittance *= transparency;
  through.pass *= pass;
  through.surface_pass *= pass;
  through.chance *= chance;
  through.by_ray_kind = true;
  return true;
}

void make_lens_vertex(const Scene& scene, Vec2 u_lens, float time, PathVertex& lens) {
  const Camera& camera = scene.camera();
  reset(lens, VertexKind::Lens);
  lens.distant = camera.is_orthographic();
  lens.point.time = time;
  lens.point.barycentric = camera.sample_lens(u_lens);
  lens.point.position = camera.lens_point(lens.point.barycentric, time);
  lens.point.ng = lens.distant ? camera.orthographic_direction(lens.point.barycentric, time) : camera.forward(time);
}

Ray leave_lens(const Scene& scene, Vec2 film, PathVertex& lens) {
  const Ray ray = scene.camera().ray_through(film, lens.point.barycentric, lens.point.time);
  if (scene.camera().lens_turns()) lens.point.position = ray.origin;
  return ray;
}

Ray start_at_lens(const Scene& scene, Vec2 film, Vec2 u_lens, float time, PathVertex& lens, float& density) {
  make_lens_vertex(scene, u_lens, time, lens);
  const Ray ray = leave_lens(scene, film, lens);
  density = sees_nothing(ray) ? 0.0f : scene.camera().film_density(ray.direction, time);
  return ray;
}

void make_light_vertex(const Scene& scene, uint32_t index, Vec3 position, Vec3 normal, Vec3 to_eye, float time,
                       PathVertex& light) {
  const LightSet& lights = scene.lights();
  const LightFlags flags = lights.flags(index);
  reset(light, VertexKind::Light);
  light.light = int(index);
  if (flags.type == LightType::Triangle) {
    const Light triangle = lights.light(index, time);
    Hit hit;
    hit.instance = triangle.instance;
    hit.primitive = triangle.primitive;
    hit.barycentric = barycentric_of(triangle, position);
    Ray ray;
    ray.direction = -to_eye;
    ray.time = time;
    light.program = &scene.material(hit);
    scene.shading_point(ray, hit, light.point);
    light.point.ray_kind = 0;
    light.shading.emission = light.program->evaluate_emission(light.point);
    // No other ray passes eye-only surfaces alike: of those that emit, the probability is left out of the weights.
    if (light.program->may_be_transparent() && !scene.is_eye_only(hit))
      light.pass = pass_probability(*light.program, light.program->evaluate_transparency(light.point));
    return;
  }
  light.distant = is_distant(flags.type);
  light.delta = is_delta(flags.type);
  light.point.time = time;
  light.point.position = position;
  if (flags.soft) {
    const Light lamp = lights.light(index);
    normal = soft_lamp_normal(lamp, position, to_eye).value_or(normal);
    light.point.position = position = lamp.position - lamp.radius * normal;
  }
  if (!light.distant) light.point.position_error = Vec3(lamp_position_error(position));
  light.point.ng = light.distant ? to_eye : normal;
  light.point.wo = to_eye;
}

void make_light_vertex(const PathVertex& surface, PathVertex& light) {
  light.kind = VertexKind::Light;
  light.specular = light.distant = light.delta = light.exit = light.eye_only = false;
  light.light = surface.light;
  light.pass = surface.eye_only ? 0.0f : surface.pass;
  light.program = surface.program;
  light.point = surface.point;
  light.shading.bsdf = Bsdf();
  light.shading.emission = surface.shading.emission;
}

void make_light_vertex(const Scene& scene, const LightMet& met, Vec3 to_eye, float time, PathVertex& light) {
  make_light_vertex(scene, met.light, met.position, met.normal, to_eye, time, light);
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
  if (const LightSet& lights = scene.lights(); light.light >= 0 && lights.flags(uint32_t(light.light)).soft)
    ray.origin = soft_lamp_start(lights.light(uint32_t(light.light)), ray.origin, to_eye);
  ray.direction = to_eye;
  ray.time = light.point.time;
  return ray;
}

bool start_at_light(const Scene& scene, const LightWalkGuide* guide, const LightNumbers& u, float time,
                    PathVertex& light, Ray& ray) {
  float u_choice = u.choice;
  const LightSet& lights = scene.lights();
  if (lights.empty()) return false;
  if (guide && guide->sets_out(u_choice)) {
    const LightWalkGuide::Start start = guide->start(lights, u_choice, u.position, u.direction);
    if (!lights.flags(start.light).starts_walks()) return false;
    make_light_vertex(scene, start.light, start.position, start.normal, start.direction, time, light);
    ray = leave_light(scene, light, start.direction);
    return true;
  }
  const LightSet::Choice choice = lights.choose_by_power(u_choice);
  if (!(choice.pmf > 0.0f) || !lights.flags(choice.light).starts_walks()) return false;
  const auto sample = lights.sample_le(choice.light, u.position, u.direction, time);
  if (!sample || is_black(sample->radiance)) return false;
  make_light_vertex(scene, choice.light, sample->ray.origin, sample->normal, sample->ray.direction, time, light);
  ray = leave_light(scene, light, sample->ray.direction);
  return true;
}

bool sample_light(const Scene& scene, const PathVertex& at, float u_choice, Vec2 u, PathVertex& light) {
  const LightSet& lights = scene.lights();
  if (!lights.can_choose()) return false;
  const LightSet::Choice choice = lights.choose(at.position(), receiving_normal(at), u_choice, receiver_set(at));
  if (!(choice.pmf > 0.0f)) return false;
  const auto sample = lights.sample_li(choice.light, at.position(), u, at.point.time);
  if (!sample || is_black(sample->radiance)) return false;
  make_light_vertex(scene, choice.light, sample->position, sample->normal, -sample->wi, at.point.time, light);
  return true;
}

bool find_light_end(const PathScene& where, const PathVertex& from, const Ray& ray, Sampler& sampler, PathVertex& light,
                    Through& through, uint64_t& rays) {
  const auto& [scene, media] = where;
  const uint32_t ray_kind = light.point.ray_kind;
  PathVertex surface;
  surface.point.ray_kind = ray_kind;
  enter_media(where, from, ray.direction, surface);
  bool chosen = false, escaped = false;
  Through before_light;
  const auto up_to = [&](const Ray& stretch, float t, const Through& passed) {
    return media ? through_to(*media, surface.media.stack, stretch, t, surface.point, sampler, passed) : passed;
  };
  const auto watch = [&](const Ray& stretch, float t_end, bool found, const Through& passed) {
    if (!chosen && scene.has_lamp_shapes())
      for_each_lamp_crossed(scene, stretch, t_end, ray_kind, [&](const LightMet& met) {
        if (chosen || sampler.get_1d() >= kLampStop) return;
        make_light_vertex(scene, met, -ray.direction, ray.time, light);
        before_light = up_to(stretch, distance_to(stretch, met), passed);
        chosen = true;
      });
    if (found) return;
    escaped = true;
    if (!chosen) before_light = up_to(stretch, kInfinity, passed);
  };
  through.collisions = {Collisions::Kind::None};
  const bool hit = find_vertex(where, ray, sampler, surface, through, rays, watch);
  if (chosen) {
    through = before_light;
    return !through.by_ray_kind;
  }
  if (hit) {
    if (!surface.emits() || through.by_ray_kind) return false;
    make_light_vertex(surface, light);
    return true;
  }
  if (!escaped || before_light.by_ray_kind) return false;  // or the walk passed too many surfaces
  through = before_light;
  int met_count = 0;
  const auto count = [&](const LightMet&) { ++met_count; };
  for_each_distant_light(scene, ray, ray_kind, true, count);
  if (met_count == 0) return false;
  int left = std::min(int(sampler.get_1d() * float(met_count)), met_count - 1);
  for_each_distant_light(scene, ray, ray_kind, true, [&](const LightMet& met) {
    if (left-- == 0) make_light_vertex(scene, met, -ray.direction, ray.time, light);
  });
  return true;
}

}  // namespace ajar
