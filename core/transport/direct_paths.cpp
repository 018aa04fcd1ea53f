#include "transport/direct_paths.h"

#include "transport/direct_light.h"

namespace ajar {

Color trace_direct_paths(const Scene& scene, Vec2 film, Sampler& sampler, SampleAux* aux, float& alpha, uint64_t& rays, const VertexMerging* merging) {
  constexpr uint32_t kFirst = 4, kPerVertex = 16, kThrough = 8, kLight = 0, kLobe = 3;
  const RenderSettings& settings = scene.settings();
  const BounceLimits& limits = settings.bounces;
  const int max_vertices = max_path_vertices(limits);
  Color radiance(0.0f), beta(1.0f);
  alpha = 0.0f;
  PathVertex previous, vertex, light;
  float density;
  Ray ray = start_at_lens(scene, film, scene.camera().has_lens() ? sampler.get_2d() : Vec2(0.5f), previous, density);
  if (!(density > 0.0f)) {
    alpha = 1.0f;
    return radiance;
  }
  vertex.point = ShadingPoint();
  float pdf_to_light = 0.0f;  // of the direction travelled, where light sampling competes
  bool last = false;          // the bounce before was not specular
  for (int i = 1; i + 1 <= max_vertices; ++i) {
    const uint32_t base = kFirst + kPerVertex * uint32_t(i);
    const auto meet = [&](const PathVertex& end, const PathEdge& edge, Color carried) {
      float weight = 1.0f;
      if (pdf_to_light > 0.0f) {
        const LightEnd found = light_end(scene, end, previous, edge, nullptr);
        weight = power_heuristic(pdf_to_light * edge.to_light_area(), found.pdf_sampled);
      }
      radiance += carried * end.shading.emission * weight;
    };
    const auto watch = [&](const Ray& stretch, float t_end, bool found, const Through& passed) {
      const auto meet_light = [&](const LightMet& met) {
        make_light_vertex(scene, met, -ray.direction, light);
        meet(light, join(light, previous), beta * passed.transmittance / passed.pass);
      };
      if (scene.has_lamp_shapes()) for_each_lamp_crossed(scene, stretch, t_end, vertex.point.ray_kind, meet_light);
      if (!found) {
        for_each_distant_light(scene, stretch, vertex.point.ray_kind, !(settings.transparent_film && i == 1), meet_light);
        if (i == 1) alpha = settings.transparent_film ? 1.0f - luminance(passed.transmittance) / passed.pass : 1.0f;
      }
    };
    sampler.set_dimension(base + kThrough);
    Through through;
    if (!find_vertex(scene, ray, sampler, vertex, through, rays, watch)) break;
    beta *= through.transmittance / (through.pass * (1.0f - vertex.pass));
    if (i == 1) {
      if (aux) record_first_hit(scene, vertex.point, vertex.shading.bsdf, *aux);
      alpha = 1.0f - vertex.shading.holdout;
    }
    if (vertex.emits()) {
      make_light_vertex(vertex, light);
      meet(light, join(light, previous), beta);
    }
    const bool exceeded = vertex.point.glossy_depth > limits.glossy || vertex.point.transmission_depth > limits.transmission;
    if (last || exceeded || vertex.shading.bsdf.empty() || i + 2 > max_vertices) break;

    if (vertex.connectable()) {
      if (merging && i >= 2) radiance += beta * merging->radiance(vertex, i);
      sampler.set_dimension(base + kLight);
      const Vec2 u = sampler.get_2d();
      if (sample_light(scene, vertex, sampler.get_1d(), u, light)) {
        PathEdge edge = join(light, vertex);
        const LightEnd end = light_end(scene, light, vertex, edge, nullptr);
        const Bsdf::Evaluation scattered = vertex.shading.bsdf.evaluate(vertex.point.wo, -edge.to_eye);
        Color direct = beta * scattered.f_cos * end.radiance * edge.to_light_area();
        if (end.pdf_sampled > 0.0f && !is_black(direct) && look_along(scene, light, vertex, edge, rays)) {
          if (end.can_be_hit) direct *= power_heuristic(end.pdf_sampled, scattered.pdf_solid_angle * edge.to_light_area());
          radiance += direct * edge.transmittance / end.pdf_sampled;
        } else if (end.pdf_sampled > 0.0f) {
          radiance += beta * light_beyond_terminator(scene, light, vertex, edge, end, scattered.f_cos, rays) / end.pdf_sampled;
        }
      }
    }
    sampler.set_dimension(base + kLobe);
    const float u_lobe = sampler.get_1d();
    const auto sample = vertex.shading.bsdf.sample(vertex.point.wo, u_lobe, sampler.get_2d());
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) break;
    if (sample->specular) {
      const Bsdf::SpecularEvaluation event = vertex.shading.bsdf.evaluate_specular(vertex.point.wo, sample->wi);
      if (!(event.probability > 0.0f)) break;
      beta *= event.weight / event.probability;
    } else {
      beta *= sample->f_cos / sample->pdf_solid_angle;
    }
    if (!(max_component(beta) > 0.0f)) break;
    last = !sample->specular;
    pdf_to_light = last ? sample->pdf_solid_angle : 0.0f;
    ShadingPoint next;
    count_bounce(*sample, vertex.point, next);
    ray = scene.spawn_ray(vertex.point, sample->wi);
    previous = vertex;
    vertex.point = next;
  }
  return radiance;
}

}  // namespace ajar
