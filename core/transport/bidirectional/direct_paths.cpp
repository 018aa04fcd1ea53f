#include "transport/bidirectional/direct_paths.h"

#include "transport/direct/direct_light.h"
#include "transport/direct/lobe_split.h"
#include "transport/paths/specular_branches.h"

namespace ajar {

namespace {

constexpr uint32_t kFirst = 4, kPerVertex = 16, kThrough = 8, kLight = 0, kLobe = 3;

/// A walk of specular bounces. Its ray will find vertex number `i` (1: the first from the eye).
struct Walk {
  Ray ray;
  ShadingPoint start;
  Color beta;
  int i;
};

/// The state of one sample.
class DirectTracer {
 public:
  DirectTracer(const Scene& scene, Sampler& sampler, SampleAux* aux, uint64_t& rays, const VertexMerging* merging)
      : scene_(scene),
        limits_(scene.settings().bounces),
        max_vertices_(max_path_vertices(limits_)),
        sampler_(sampler),
        aux_(aux),
        rays_(rays),
        merging_(merging) {}

  DirectSample trace(Vec2 film) {
    float density;
    const Ray camera_ray = start_at_lens(scene_, film, scene_.camera().has_lens() ? sampler_.get_2d() : Vec2(0.5f),
                                         previous_, density);
    if (!(density > 0.0f)) {
      found_.alpha = 1.0f;
      return found_;
    }
    SpecularBranches<Walk> branches({camera_ray, {}, Color(1.0f), 1});
    Walk walk;
    while (branches.next(walk)) follow(walk, branches);
    return found_;
  }

 private:
  void follow(Walk& walk, SpecularBranches<Walk>& branches) {
    auto& [ray, start, beta, i] = walk;
    const bool transparent_film = scene_.settings().transparent_film;
    vertex_.point = start;
    pdf_to_light_ = 0.0f;
    for (; i + 1 <= max_vertices_; ++i) {
      const uint32_t base = kFirst + kPerVertex * uint32_t(i);
      const auto watch = [&](const Ray& stretch, float t_end, bool found, const Through& passed) {
        const auto meet_light = [&](const LightMet& met) {
          make_light_vertex(scene_, met, -ray.direction, light_);
          meet(beta * passed.transmittance / passed.pass);
        };
        if (scene_.has_lamp_shapes()) for_each_lamp_crossed(scene_, stretch, t_end, vertex_.point.ray_kind, meet_light);
        if (!found) {
          for_each_distant_light(scene_, stretch, vertex_.point.ray_kind, !(transparent_film && i == 1), meet_light);
          if (i == 1) found_.alpha = transparent_film ? 1.0f - luminance(passed.transmittance) / passed.pass : 1.0f;
        }
      };
      sampler_.set_dimension(base + kThrough);
      Through through;
      if (!find_vertex(scene_, ray, sampler_, vertex_, through, rays_, watch)) break;
      beta *= through.transmittance / (through.pass * (1.0f - vertex_.pass));
      if (i == 1) {
        if (aux_) record_first_hit(scene_, vertex_.point, vertex_.shading.bsdf, *aux_);
        found_.alpha = 1.0f - vertex_.shading.holdout;
      }
      if (vertex_.emits()) {
        make_light_vertex(vertex_, light_);
        meet(beta);
      }
      const bool last = pdf_to_light_ > 0.0f;  // the previous bounce was not specular
      const bool exceeded = vertex_.point.glossy_depth > limits_.glossy ||
                            vertex_.point.transmission_depth > limits_.transmission;
      const Bsdf& bsdf = vertex_.shading.bsdf;
      if (last || exceeded || bsdf.empty() || i + 2 > max_vertices_) break;
      found_.polished = found_.polished || has_sharp_lobe(bsdf);

      if (vertex_.connectable()) {
        if (merging_ && i >= 2) found_.merged += beta * merging_->radiance(vertex_, i);
        sampler_.set_dimension(base + kLight);
        look_for_light(beta);
      }
      branches.split(bsdf, vertex_.point.wo, beta, [&](const BsdfSample& event) {
        Walk next{scene_.spawn_ray(vertex_.point, event.wi), {}, beta * event.f_cos, i + 1};
        count_bounce(event, vertex_.point, next.start);
        return next;
      });
      if (branches.follows_all()) break;
      sampler_.set_dimension(base + kLobe);
      const float u_lobe = sampler_.get_1d();
      const auto sample = bsdf.sample(vertex_.point.wo, u_lobe, sampler_.get_2d());
      if (!sample || !(sample->pdf_solid_angle > 0.0f) || branches.follows(*sample)) break;
      if (sample->specular) {
        const Bsdf::SpecularEvaluation event = bsdf.evaluate_specular(vertex_.point.wo, sample->wi);
        if (!(event.probability > 0.0f)) break;
        beta *= event.weight / event.probability;
      } else {
        beta *= sample->f_cos / sample->pdf_solid_angle;
        pdf_to_light_ = sample->pdf_solid_angle;
        previous_ = vertex_;
      }
      if (!(max_component(beta) > 0.0f)) break;
      ShadingPoint next;
      count_bounce(*sample, vertex_.point, next);
      ray = scene_.spawn_ray(vertex_.point, sample->wi);
      vertex_.point = next;
    }
  }

  /// The walk hit a light, which is in light_.
  void meet(Color carried) {
    float weight = 1.0f;
    if (pdf_to_light_ > 0.0f) {
      const PathEdge edge = join(light_, previous_);
      weight = power_heuristic(pdf_to_light_ * edge.to_light_area(),
                               light_end(scene_, light_, previous_, edge, nullptr).pdf_sampled);
    }
    found_.radiance += carried * light_.shading.emission * weight;
  }

  /// Samples a light at vertex_.
  void look_for_light(Color beta) {
    const Vec2 u = sampler_.get_2d();
    if (!sample_light(scene_, vertex_, sampler_.get_1d(), u, light_)) return;
    PathEdge edge = join(light_, vertex_);
    const LightEnd end = light_end(scene_, light_, vertex_, edge, nullptr);
    if (!(end.pdf_sampled > 0.0f)) return;
    const Bsdf::Evaluation scattered = vertex_.shading.bsdf.evaluate(vertex_.point.wo, -edge.to_eye);
    Color direct = beta * scattered.f_cos * end.radiance * edge.to_light_area();
    if (!is_black(direct) && look_along(scene_, light_, vertex_, edge, rays_)) {
      if (end.can_be_hit) direct *= power_heuristic(end.pdf_sampled, scattered.pdf_solid_angle * edge.to_light_area());
      found_.radiance += direct * edge.transmittance / end.pdf_sampled;
    } else {
      found_.radiance += beta * light_beyond_terminator(scene_, light_, vertex_, edge, end, scattered.f_cos, rays_) /
                         end.pdf_sampled;
    }
  }

  const Scene& scene_;
  const BounceLimits& limits_;
  const int max_vertices_;
  Sampler& sampler_;
  SampleAux* aux_;
  uint64_t& rays_;
  const VertexMerging* merging_;
  DirectSample found_;
  PathVertex previous_, vertex_, light_;
  /// Density of the walk's direction after a bounce that is not specular, for MIS with light sampling; 0 otherwise.
  float pdf_to_light_ = 0.0f;
};

}  // namespace

DirectSample trace_direct_paths(const Scene& scene, Vec2 film, Sampler& sampler, SampleAux* aux, uint64_t& rays,
                                const VertexMerging* merging) {
  return DirectTracer(scene, sampler, aux, rays, merging).trace(film);
}

}  // namespace ajar
