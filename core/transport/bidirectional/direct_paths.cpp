#include "transport/bidirectional/direct_paths.h"

#include "transport/direct/direct_light.h"
#include "transport/direct/lobe_split.h"
#include "transport/paths/eye_history.h"
#include "transport/paths/record.h"
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
  MediaStack stack;                     ///< of the ray
  uint32_t receiver_set = kEveryLight;  ///< of the vertex that the ray leaves
  bool excludes_photons = false;        ///< a vertex before does
  PathPasses first{};                   ///< by the first scattering, if the film separates light
};

/// The state of one sample.
class DirectTracer {
 public:
  DirectTracer(const PathScene& where, Sampler& sampler, SampleAux* aux, uint64_t& rays, const VertexMerging* merging,
               LightPasses* passes)
      : scene_(where.scene),
        media_(where.media),
        limits_(scene_.settings().bounces),
        max_vertices_(max_path_vertices(limits_)),
        sampler_(sampler),
        aux_(aux),
        rays_(rays),
        merging_(merging),
        passes_(passes) {}

  DirectSample trace(Vec2 film) {
    float density;
    const Vec2 u_lens = scene_.camera().has_lens() ? sampler_.get_2d() : Vec2(0.5f);
    const float time = merging_ ? merging_->time() : sample_time(scene_, sampler_);
    const Ray camera_ray = start_at_lens(scene_, film, u_lens, time, previous_, density);
    if (!(density > 0.0f)) {
      found_.alpha = 1.0f;
      return found_;
    }
    SpecularBranches<Walk> branches(
        {camera_ray,
         {},
         Color(1.0f),
         1,
         media_ ? stack_towards(scene_, *media_, previous_, camera_ray.direction) : MediaStack(),
         kEveryLight});
    Walk walk;
    while (branches.next(walk)) follow(walk, branches);
    return found_;
  }

 private:
  void follow(Walk& walk, SpecularBranches<Walk>& branches) {
    auto& [ray, start, beta, i, stack, receiver, excludes_photons, first] = walk;
    receiver_set_ = receiver;
    const bool transparent_film = scene_.settings().transparent_film;
    vertex_.point = start;
    vertex_.media.present = media_ != nullptr;
    vertex_.media.stack = stack;
    pdf_to_light_ = 0.0f;
    for (; i + 1 <= max_vertices_; ++i) {
      const uint32_t base = kFirst + kPerVertex * uint32_t(i);
      const auto watch = [&](const Ray& stretch, float t_end, bool found, const Through& passed) {
        const auto meet_light = [&](const LightMet& met) {
          make_light_vertex(scene_, met, -ray.direction, ray.time, light_);
          const Through before = media_ ? through_to(*media_, vertex_.media.stack, stretch, distance_to(stretch, met),
                                                     vertex_.point, sampler_, passed)
                                        : passed;
          meet(beta * before.transmittance / (pdf_to_light_ > 0.0f ? passed.surface_pass : passed.pass), i - 1, first);
        };
        if (scene_.has_lamp_shapes()) for_each_lamp_crossed(scene_, stretch, t_end, vertex_.point.ray_kind, meet_light);
        if (!found) {
          record_background(scene_, ray.direction, i == 1, beta * passed.transmittance / passed.pass, aux_);
          for_each_distant_light(scene_, stretch, vertex_.point.ray_kind, !(transparent_film && i == 1), meet_light);
          if (i == 1) found_.alpha = transparent_film ? 1.0f - luminance(passed.transmittance) / passed.pass : 1.0f;
        }
      };
      sampler_.set_dimension(base + kThrough);
      Through through;
      // After the first bounce that is not specular, only emission counts: there are no collisions.
      const bool last = pdf_to_light_ > 0.0f;
      through.collisions = {last ? Collisions::Kind::None : Collisions::Kind::Sampled};
      through.by_kind = RayKindSurfaces::Follow;
      if (!find_vertex(PathScene{scene_, media_}, ray, sampler_, vertex_, through, rays_, watch)) break;
      const float stop = vertex_.kind == VertexKind::Medium ? through.end_rate : 1.0f - vertex_.pass;
      if (!(stop > 0.0f)) break;
      beta *= through.transmittance / ((last ? through.surface_pass : through.pass) * stop);
      if (vertex_.kind == VertexKind::Surface) record_seen(beta, i);
      if (i == 1) found_.alpha = 1.0f - vertex_.shading.holdout;
      if (vertex_.emits()) meet_emitter(beta, i - 1, first);
      const bool exceeded = vertex_.point.glossy_depth > limits_.glossy ||
                            vertex_.point.transmission_depth > limits_.transmission;
      Bsdf& bsdf = vertex_.shading.bsdf;
      excludes_photons |= vertex_.excludes_photons() || through.eye_only;
      // The light that goes below the surface is found elsewhere.
      if (!last && enters(vertex_, false)) [[unlikely]]
        bsdf.remove_subsurface(vertex_.point.wo);
      if (last || exceeded || !vertex_.scatters() || i + 2 > max_vertices_) break;
      found_.polished = found_.polished || has_sharp_lobe(bsdf);

      if (vertex_.connectable()) {
        if (merging_ && i >= 2 && vertex_.stores_photons() && !excludes_photons) merge(beta, i, first);
        sampler_.set_dimension(base + kLight);
        look_for_light(beta, i, first);
      }
      if (vertex_.kind == VertexKind::Surface) split(branches, beta, i, excludes_photons, first);
      if (vertex_.kind == VertexKind::Surface && branches.follows_all()) break;
      sampler_.set_dimension(base + kLobe);
      const auto sample = sample_bounce();
      if (!sample || !(sample->pdf_solid_angle > 0.0f)) break;
      if (vertex_.kind == VertexKind::Surface && branches.follows(*sample)) break;
      if (passes_ && i == 1) [[unlikely]]
        first = passes_->scattered_at(vertex_, vertex_.point.wo, sample->wi, sample->specular);
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
      receiver_set_ = receiver_set(vertex_);
      ShadingPoint next;
      count_bounce_at(vertex_, *sample, next);
      ray = scene_.spawn_ray(vertex_.point, sample->wi);
      enter_media({scene_, media_}, vertex_, ray.direction, vertex_);
      vertex_.point = next;
    }
  }

  /// Records the surface at vertex i, which the walk has reached with `beta`.
  void record_seen(Color beta, int i) {
    const Bsdf& bsdf = vertex_.shading.bsdf;
    record_vertex(scene_, vertex_.point, bsdf, beta, aux_, BehindFirst::NotFound);
    if (passes_ && i == 1) [[unlikely]]
      passes_->add_color(bsdf, beta);
  }

  /// Adds a walk for each specular branch of the surface at vertex i, where the walk arrives with `beta`.
  void split(SpecularBranches<Walk>& branches, Color beta, int i, bool excludes_photons, const PathPasses& first) {
    branches.split(vertex_.shading.bsdf, vertex_.point.wo, beta, [&](const BsdfSample& event) {
      Walk next{scene_.spawn_ray(vertex_.point, event.wi),
                {},
                beta * event.f_cos,
                i + 1,
                {},
                receiver_set(vertex_),
                excludes_photons,
                first};
      if (passes_ && i == 1) [[unlikely]]
        next.first = passes_->scattered_at(vertex_, vertex_.point.wo, event.wi, true);
      count_bounce(event, vertex_.point, next.start);
      if (media_) next.stack = stack_towards(scene_, *media_, vertex_, event.wi);
      return next;
    });
  }

  void meet_emitter(Color carried, int bounces, const PathPasses& first) {
    make_light_vertex(vertex_, light_);
    meet(carried, bounces, first);
  }

  std::optional<BsdfSample> sample_bounce() {
    const Vec3 u = sampler_.get_3d();
    return vertex_.kind == VertexKind::Surface ? vertex_.shading.bsdf.sample(vertex_.point.wo, u.z, Vec2(u))
                                               : sample_direction(vertex_, vertex_.point.wo, u.z, Vec2(u));
  }

  /// The walk hit a light, which is in light_, after `bounces` vertices.
  void meet(Color carried, int bounces, const PathPasses& first) {
    float weight = 1.0f;
    const LightSet& lights = scene_.lights();
    if (lights.any_linked() && light_.light >= 0 && !lights.flags(uint32_t(light_.light)).lights(receiver_set_)) return;
    if (pdf_to_light_ > 0.0f) {
      const PathEdge edge = join(light_, previous_);
      const LightEnd end = light_end(scene_, light_, previous_, edge, nullptr);
      if (!end.can_be_hit_from(previous_)) return;
      weight = power_heuristic(pdf_to_light_ * edge.to_light_area(), end.pdf_sampled);
    }
    add_found(carried * light_.shading.emission * weight, bounces, first);
  }

  /// Adds light of light_ that is scattered by this number of vertices.
  void add_found(Color light, int bounces, const PathPasses& first) {
    found_.radiance += light;
    if (passes_) [[unlikely]]
      passes_->add(passes_->of(scene_, light_, bounces, first), light);
  }

  void merge(Color beta, int i, const PathPasses& first) {
    const Color light = beta * merging_->radiance(vertex_, i);
    found_.merged += light;
    if (!passes_) return;
    passes_->add(passes_->part_of(i + 1, first), light);
    for (int g = 0; g < passes_->group_count(); ++g)
      passes_->add(passes_->of_group(g), beta * merging_->radiance_of_group(vertex_, i, g));
  }

  /// Samples a light at vertex_, the vertex number `i`.
  void look_for_light(Color beta, int i, PathPasses first) {
    const Vec3 u = sampler_.get_3d();
    if (!sample_light(scene_, vertex_, u.z, Vec2(u), light_)) return;
    if (is_past_bounces(scene_, light_, vertex_.point.ray_depth)) return;
    PathEdge edge = join(light_, vertex_);
    const LightEnd end = light_end(scene_, light_, vertex_, edge, nullptr);
    if (!(end.pdf_sampled > 0.0f)) return;
    Bsdf::Evaluation scattered;
    if (vertex_.kind == VertexKind::Medium) {
      const Scattering at = scatter(vertex_, vertex_.point.wo, -edge.to_eye, false, nullptr);
      scattered = {at.f, at.pdf_to_light};
    } else {
      scattered = vertex_.shading.bsdf.evaluate(vertex_.point.wo, -edge.to_eye);
    }
    scattered.f_cos = visible_part(scene_, light_, vertex_, vertex_.point.wo, -edge.to_eye, false, scattered.f_cos);
    if (passes_ && i == 1) [[unlikely]]
      first = passes_->scattered_at(vertex_, vertex_.point.wo, -edge.to_eye, false);
    Color direct = beta * scattered.f_cos * end.radiance * edge.to_light_area();
    if (!is_black(direct) && look_along({scene_, media_}, light_, vertex_, edge, rays_, RayKindSurfaces::Follow)) {
      if (end.can_be_hit_from(vertex_))
        direct *= power_heuristic(end.pdf_sampled, scattered.pdf_solid_angle * edge.to_light_area());
      add_found(direct * edge.transmittance / end.pdf_sampled, i, first);
    } else {
      add_found(beta * light_beyond_terminator({scene_, media_}, light_, vertex_, edge, end, scattered.f_cos, rays_) /
                    end.pdf_sampled,
                i, first);
    }
  }

  const Scene& scene_;
  const PathMedia* media_;
  const BounceLimits& limits_;
  const int max_vertices_;
  Sampler& sampler_;
  SampleAux* aux_;
  uint64_t& rays_;
  const VertexMerging* merging_;
  LightPasses* passes_;
  DirectSample found_;
  PathVertex previous_, vertex_, light_;
  /// Density of the walk's direction after a bounce that is not specular, for MIS with light sampling; 0 otherwise.
  float pdf_to_light_ = 0.0f;
  uint32_t receiver_set_ = kEveryLight;  ///< of the vertex that the walk has left
};

}  // namespace

DirectSample trace_direct_paths(const PathScene& where, Vec2 film, Sampler& sampler, SampleAux* aux, uint64_t& rays,
                                const VertexMerging* merging, LightPasses* passes) {
  return DirectTracer(where, sampler, aux, rays, merging, passes).trace(film);
}

}  // namespace ajar
