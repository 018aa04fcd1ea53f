#include "integrators/path_tracer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <type_traits>
#include <utility>

#include <tbb/combinable.h>

#include "film/filter.h"
#include "integrators/learned.h"
#include "integrators/tile_loop.h"
#include "sampling/sampler.h"
#include "transport/direct/estimators/make_estimator.h"
#include "transport/guiding/guided_bsdf.h"
#include "transport/direct/media_light.h"
#include "transport/guiding/path_guide.h"
#include "transport/paths/ray_events.h"
#include "transport/media/subsurface_walk.h"

namespace ajar {

namespace {

/// Dimensions of the sampler: the camera's, then a fixed number for each vertex.
constexpr uint32_t kTime = 4, kCameraDimensions = 6, kVertexDimensions = 8;
constexpr uint32_t kDirectLight = 0, kLobe = kDirectDimensions, kDirection = 4, kRoulette = 6, kGuide = 7;
constexpr int kSafeBounces = 2;     // before roulette
constexpr uint32_t kEnter = 8192;   // and the vertex: whether light goes below the surface
constexpr uint32_t kScatter = 12288, kStretchDimensions = 2 + kMediumLightDimensions;   // for each stretch of a ray through media
constexpr int kMostBounds = 1024;   // surfaces that only enclose volumes along one path, as in Cycles

struct Counters {
  uint64_t rays = 0, paths = 0;
  MediaCounters media;
};

/// Where there are no media, their code is not there either.
struct NoMedia {
  static constexpr bool kThere = false;
};
/// A path's state in media.
struct InMedia {
  static constexpr bool kThere = true;
  const Media& media;
  MediaCounters& counters;
  Pcg32 rng;
  MediaStack stack;
};

/// Shares of diffuse, glossy and transmission in what is scattered; the sum is 1.
using Shares = std::array<Color, 3>;
struct NoParts {};
/// Of a sample's luminance: that of each source times its importance. What glows in media is no source.
struct ImportantLight {
  float luminance = 0.0f;
  float of_source = 1.0f;   // of the light to be added next
};

/// Where nothing is scattered (light beyond the terminator), the shares are those of the albedo.
Shares shares_of(const Bsdf& bsdf, const Shares& scattered) {
  Shares shares;
  const Shares albedo = bsdf.albedo_of_kinds();
  for (int c = 0; c < 3; ++c) {
    const Shares& of = scattered[0][c] + scattered[1][c] + scattered[2][c] > 0.0f ? scattered : albedo;
    const float sum = of[0][c] + of[1][c] + of[2][c];
    for (size_t k = 0; k < 3; ++k) shares[k][c] = sum > 0.0f ? of[k][c] / sum : k == 0 ? 1.0f : 0.0f;
  }
  return shares;
}

class PathTracer final : public Integrator {
 public:
  Honesty honesty() const override { return honesty_; }
  GoalSupport goal_support() const override {
    return {.follows = true, .learns = wants_guide() || (mixture_ && mixture_->learns()), .equal = wants_guide() ? PathGuide::kEqualSamples : 0};
  }

  using Integrator::prepare;
  void prepare(std::shared_ptr<const Scene> scene, const RenderPlan& plan, uint32_t seed) override {
    scene_ = std::move(scene);
    seed_ = seed;
    samples_done_ = 0;
    statistics_ = {};
    media_counters_ = {};
    const RenderSettings& settings = scene_->settings();
    filter_ = PixelFilter(settings.filter, settings.filter_width);
    const DirectPlan& direct = plan.direct;
    pilot_samples_ = direct.pilot_samples;
    pilot_rays_ = 0;
    honesty_ = direct.biased ? Honesty::Biased : Honesty::Unbiased;
    // The default has its own copy of the loop, free of what the others need.
    mixture_.reset();
    const bool too_few = direct.method == DirectMethod::PmcHi && pilot_samples_ == 0.0f;
    if (direct.method != DirectMethod::Mis || direct.samples > 1)
      mixture_ = make_direct_estimator(*scene_, too_few ? DirectMethod::Mis : direct.method, {.samples = direct.samples});
    // With nothing to choose among, one sample of the learned mixture is one of the default.
    if (mixture_ && direct.method == DirectMethod::PmcHi && direct.samples <= 1 && !mixture_->wants_pilot()) mixture_.reset();
    ends_early_ = plan.ends_early;
    media_.reset();
    if (plan.media) media_ = std::make_unique<Media>(*scene_);
    guide_.reset();
    guide_past_.reset();
    guiding_ = plan.guiding;
  }

  std::vector<LearnedPart> begin_with(const Learned& learned) override {
    std::vector<LearnedPart> parts;
    if (learned.guide || wants_guide()) parts.push_back({"path guide", !wants_guide() ? "paths are not guided" : !learned.guide ? "the frame before has not learned enough" : ""});
    if (wants_guide()) guide_past_ = learned.guide;
    const bool adaptive = mixture_ && mixture_->wants_pilot();
    if (learned.direct || adaptive)
      parts.push_back({"choice of lights", !adaptive ? "lights are not learned" : !learned.direct ? "the frame before has learned none" : mixture_->begin_with(*learned.direct)});
    return parts;
  }

  void hand_on(Learned& learned) override {
    if (guide_ && guide_->tree().cell_count() <= Learned::kMostCells) learned.guide = guide_->past();
    if (mixture_) learned.direct = mixture_->past();
  }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    if (mixture_ && mixture_->wants_pilot() && !run_pilot(film, stop)) return;
    if (!guide_ && wants_guide()) {
      const auto mode = guiding_ == Guiding::On ? PathGuide::Mode::On : PathGuide::Mode::Auto;
      guide_ = std::make_unique<PathGuide>(mode, film.width(), film.height(), kTile, guide_past_.get());
      guide_past_.reset();
    }
    // What learns does so after 1, 2, 4, 8 ... samples, wherever iterations end, which depends on the clock.
    while (samples_per_pixel > 0) {
      int samples = samples_per_pixel;
      if (guide_) samples = guide_->begin(samples_done_, samples, statistics_.rays);
      if (mixture_ && mixture_->learns()) samples = std::min(samples, int(std::bit_ceil(samples_done_ + 1) - samples_done_));
      render_samples(film, samples, stop);
      if (stop.load(std::memory_order_relaxed)) return;
      samples_per_pixel -= samples;
      if (mixture_ && mixture_->learns() && std::has_single_bit(samples_done_)) mixture_->learn();
    }
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics statistics = statistics_;
    if (pilot_rays_ > 0) statistics.extra["pilot_rays"] = double(pilot_rays_);
    if (media_) {
      statistics.extra["media_bytes"] = double(media_->memory_bytes());
      statistics.extra["media_lookups"] = double(media_counters_.lookups);
      statistics.extra["media_majorant_exceeded"] = double(media_counters_.exceeded);
      statistics.extra["media_extinction_capped"] = double(media_counters_.capped);
      statistics.extra["media_refused_values"] = double(media_counters_.refused);
      statistics.extra["media_open_ends"] = double(media_counters_.open_ends);
      statistics.extra["media_too_deep"] = double(media_counters_.too_deep);
    }
    if (guide_) {
      statistics.extra["guide_followed"] = guide_->follows() ? 1.0 : 0.0;
      statistics.extra["guide_bytes"] = double(guide_->most_bytes());
      statistics.extra["guide_cells"] = double(guide_->tree().cell_count());
      if (guide_->measured_gain() > 0.0) statistics.extra["guide_measured_gain"] = guide_->measured_gain();
    }
    return statistics;
  }

  /// For `measure_important_light`, after `prepare`.
  std::vector<Vec2> important_light(float samples_per_pixel, const std::atomic<bool>& stop) {
    const auto& r = scene_->settings().region;
    Film film(r[0], r[1], r[2], r[3], {"Combined"});
    std::vector<uint32_t> goals(size_t(film.width()) * size_t(film.height()));
    for (uint32_t i = 0; i < goals.size(); ++i) goals[i] = uint32_t(samples_per_pixel + to_unit_float(hash_combine(seed_, i)));
    film.set_goals(std::move(goals));
    tbb::combinable<Counters> counters;
    if (media_) render_with<ImportantLight, InMedia>(MisDirectLight(), Unguided(), film, stop, counters);
    else render_with<ImportantLight, NoMedia>(MisDirectLight(), Unguided(), film, stop, counters);
    const std::vector<float> pairs = film.resolve("Combined", 1.0f);
    std::vector<Vec2> light(pairs.size() / 4);
    for (size_t i = 0; i < light.size(); ++i) light[i] = Vec2(pairs[4 * i], pairs[4 * i + 1]);
    return light;
  }

 private:
  bool wants_guide() const { return guiding_ != Guiding::Off; }

  /// Samples to learn from that leave no trace in the picture. They end before its first sample, so that all its samples
  /// choose by the same shares: a sequence that is cut into pieces with different shares is stratified in pieces only, and
  /// loses more than later learning gains.
  bool run_pilot(const Film& film, const std::atomic<bool>& stop) {
    Film discarded(film.x0(), film.y0(), film.x0() + film.width(), film.y0() + film.height(), {"Combined"});
    const uint32_t seed = seed_;
    seed_ = hash_combine(seed, 0x70696c6fU);
    std::vector<uint32_t> goals(size_t(film.width()) * size_t(film.height()), 0);
    for (uint32_t iteration = 0; mixture_->wants_pilot() && !stop.load(std::memory_order_relaxed); ++iteration) {
      for (uint32_t i = 0; i < goals.size(); ++i) goals[i] += uint32_t(pilot_samples_ + to_unit_float(hash_combine(seed_ + iteration, i)));
      discarded.set_goals(goals);
      render_samples(discarded, 1, stop);
      if (!stop.load(std::memory_order_relaxed)) mixture_->learn();
    }
    seed_ = seed;
    samples_done_ = 0;
    pilot_rays_ = statistics_.rays;
    return !mixture_->wants_pilot();
  }

  void render_samples(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) {
    samples_done_ += uint32_t(samples_per_pixel);
    tbb::combinable<Counters> counters;
    const auto with = [&](const auto& direct_light, auto parts) {
      if constexpr (std::is_same_v<std::decay_t<decltype(direct_light)>, MisDirectLight>) {
        if (media_) {
          render_with<decltype(parts), InMedia>(direct_light, Unguided(), film, stop, counters);
          return;
        }
      }
      if (guide_ && guide_->active()) render_with<decltype(parts), NoMedia>(direct_light, Guided{}, film, stop, counters);
      else render_with<decltype(parts), NoMedia>(direct_light, Unguided(), film, stop, counters);
    };
    if (mixture_) with(*mixture_, NoParts());
    else if (film.wants_parts()) with(MisDirectLight(), SampleParts());
    else with(MisDirectLight(), NoParts());
    counters.combine_each([&](const Counters& c) {
      statistics_.rays += c.rays;
      statistics_.paths += c.paths;
      media_counters_.add(c.media);
    });
  }

  template <class Parts, class Medium, class DirectLight, class Guide>
  void render_with(const DirectLight& direct_light, Guide, Film& film, const std::atomic<bool>& stop, tbb::combinable<Counters>& counters) {
    struct Tile {
      Sampler sampler;
      Counters& counter;
      SampleAux aux;
    };
    const uint32_t full_width = uint32_t(scene_->settings().width);
    const bool moves = scene_->moves();
    for_each_sample(
        film, samples_done_, stop, [&] { return Tile{Sampler(Sampler::Kind::Sobol, seed_), counters.local(), SampleAux()}; },
        [&](Tile& tile, int px, int py, uint32_t index) {
          const uint32_t pixel = uint32_t(py) * full_width + uint32_t(px);
          tile.sampler.start(pixel, index);
          const Vec2 offset = filter_.sample(tile.sampler.get_2d());
          const Vec2 on_film(float(px) + 0.5f + offset.x, float(py) + 0.5f + offset.y);
          const Vec2 u_lens = scene_->camera().has_lens() ? tile.sampler.get_2d() : Vec2(0.5f);
          float time = 0.0f;
          if (moves) {
            tile.sampler.set_dimension(kTime);
            time = scene_->camera().time_of(tile.sampler.get_1d());
          }
          const Ray ray = scene_->camera().generate_ray(on_film, u_lens, time);
          SampleAux* const aux = film.wants_aux() ? &(tile.aux = SampleAux()) : nullptr;
          float alpha = 1.0f;
          if (sees_nothing(ray)) {
            film.add_sample(px, py, Color(0.0f), 1.0f, aux);
            return;
          }
          Guide guide;
          if constexpr (Guide::kGuided) guide = guide_->of_sample(px - film.x0(), py - film.y0(), pixel, index);
          Parts parts;
          const auto along = [&](auto medium) {
            return trace(direct_light, guide, std::move(medium), ray, px, py, tile.sampler, aux, parts, alpha, tile.counter);
          };
          Color radiance;
          if constexpr (Medium::kThere) {
            MediaCounters& media = tile.counter.media;
            const MediaStack around = media_->around(ray.origin + ray.t_min * ray.direction, ray.time, media);
            radiance = along(InMedia{*media_, media, Pcg32(hash_combine(seed_, pixel), index), around});
          } else {
            radiance = along(NoMedia());
          }
          if constexpr (std::is_same_v<Parts, ImportantLight>) radiance = Color(luminance(radiance), parts.luminance, 0.0f);
          if constexpr (Guide::kGuided) guide_->measure(px - film.x0(), py - film.y0(), scene_->settings().exposure * radiance);
          const bool added = film.add_sample(px, py, radiance, alpha, aux);
          if constexpr (std::is_same_v<Parts, SampleParts>)
            if (added) film.add_parts(px, py, parts);
        });
  }

  template <class DirectLight, class Guide, class Medium, class Parts>
  Color trace(const DirectLight& direct_light, const Guide& guide, Medium medium, Ray ray, int pixel_x, int pixel_y, Sampler& sampler, SampleAux* aux, Parts& parts,
              float& alpha, Counters& counter) const {
    constexpr bool kParts = std::is_same_v<Parts, SampleParts>;
    constexpr bool kSources = std::is_same_v<Parts, ImportantLight>;
    std::conditional_t<kParts, Shares, NoParts> shares;   // of kinds of lobes in the first scattering
    const Scene& scene = *scene_;
    const LightSet& lights = scene.lights();
    const RenderSettings& settings = scene.settings();
    const bool lamp_shapes = scene.has_lamp_shapes();
    Color radiance(0.0f), beta(1.0f);
    ShadingPoint point;
    SurfaceShading shading;
    DirectVertex previous;         // that chose the direction travelled
    bool last_chance = false;      // a bounce limit is reached: only what the next surface emits still counts
    int vertex = 0;
    [[maybe_unused]] GuidedBsdf guided;
    [[maybe_unused]] float plain = Guided::kPlainShare;   // probability that the BSDF alone chooses all directions, given those so far
    [[maybe_unused]] float unguided_beta = 1.0f;          // the throughput, had it done so
    [[maybe_unused]] OpenVertex open[Guide::kGuided ? kMostOpenVertices : 1];
    [[maybe_unused]] int open_count = 0;
    [[maybe_unused]] int volume_depth = 0, stretch = 0, bounds = 0;
    [[maybe_unused]] bool volume_pass = false;       // light was first scattered by a medium
    [[maybe_unused]] bool from_medium = false;       // the direction travelled was chosen by a phase function
    [[maybe_unused]] Vec3 chosen_from(0.0f);         // and lights for there
    alpha = 0.0f;
    ++counter.paths;

    // Where majorants were exceeded, weights are negative.
    const auto largest = [](Color c) { return max_component(Medium::kThere ? glm::abs(c) : c); };

    // `bounces` is how often the light was scattered before; the optional clamp tells direct from indirect by it.
    const auto add = [&](Color contribution, int bounces) {
      const float limit = bounces > 1 ? settings.clamp_indirect : settings.clamp_direct;
      if (limit > 0.0f) {
        const float sum = contribution.x + contribution.y + contribution.z;
        if (sum > 3.0f * limit) contribution *= 3.0f * limit / sum;
      }
      radiance += contribution;
      if constexpr (kSources) parts.luminance += parts.of_source * luminance(contribution);
      if constexpr (kParts) {
        if (bounces == 0) {
          parts.emission += contribution;
          return;
        }
        if constexpr (Medium::kThere) {
          if (volume_pass) {
            parts.volume[bounces == 1 ? 0 : 1] += contribution;
            return;
          }
        }
        for (size_t k = 0; k < 3; ++k) (bounces == 1 ? parts.direct : parts.indirect)[k] += contribution * shares[k];
      }
    };
    // Weight of light found by following the BSDF, against having sampled that light.
    const auto weight_of_hit = [&](uint32_t light, Vec3 wi, Vec3 position, Vec3 normal) {
      if constexpr (Medium::kThere)
        if (from_medium) return weight_of_hit_in_medium(scene, previous.bsdf_pdf, chosen_from, previous.position, light, wi, position, normal);
      return direct_light.weight_of_hit(scene, previous, light, wi, position, normal);
    };

    for (;;) {
      const Hit hit = scene.intersect(ray, point.ray_kind);
      ++counter.rays;

      const auto add_met = [&](const LightMet& met) {
        if constexpr (kSources) parts.of_source = scene.light_importance(met.light);
        if constexpr (kParts) {
          if (point.ray_depth == 0 && int(met.light) == lights.environment_index()) {
            const Color seen = std::exchange(parts.emission, Color(0.0f));
            add(beta * met.radiance, 0);
            parts.environment += std::exchange(parts.emission, seen);
            return;
          }
        }
        Color arriving = beta * met.radiance;
        if constexpr (Medium::kThere) {
          if (!medium.stack.empty() && is_finite(met.position))
            arriving *= medium.media.transmittance({medium.stack, ray, glm::dot(met.position - ray.origin, ray.direction), point, point.ray_kind}, medium.rng, medium.counters);
        }
        add(arriving * weight_of_hit(met.light, ray.direction, met.position, met.normal), point.ray_depth);
      };
      if (lamp_shapes) for_each_lamp_crossed(scene, ray, hit.t, point.ray_kind, add_met);

      if constexpr (Medium::kThere) {
        if (!hit.found()) medium.media.leave_all(medium.stack, medium.counters);
        if (!medium.stack.empty()) {
          const Color before = beta;
          Color emitted(0.0f);
          float t = 0.0f;
          MediumPoint at;
          const uint32_t here = kScatter + kStretchDimensions * uint32_t(stretch++);
          const MediaRay along{medium.stack, ray, hit.found() ? hit.t : kInfinity, point, point.ray_kind};
          const bool uniform = medium.media.is_uniform(along, at, medium.counters), may_scatter = !last_chance;
          Color direct(0.0f);
          Vec3 lights_for(0.0f);
          uint32_t sampled_light = 0;
          if (uniform && may_scatter && at.scatters() && lights.can_choose())
            direct = estimate_direct_along(scene, medium, along, at, PhaseFunction(at), beta, sampler, here + 2, lights_for, sampled_light, counter.rays);
          sampler.set_dimension(here);
          const bool scattered = uniform ? medium.media.scatter_uniform(along, at, may_scatter, sampler.get_2d(), beta, emitted, t)
                                         : medium.media.scatter_varying(along, may_scatter, medium.rng, beta, emitted, t, at, medium.counters);
          const PhaseFunction phase(at);
          const Vec3 place = ray.origin + t * ray.direction;
          if (scattered && !uniform && lights.can_choose()) {
            lights_for = place;
            direct = beta * estimate_direct_at(scene, medium, place, ray, point, phase, sampler, here + 2, sampled_light, counter.rays);
          }
          if constexpr (kSources) parts.of_source = 1.0f;
          if (!is_black(emitted)) add(emitted, point.ray_depth);
          if (point.ray_depth == 0) volume_pass = true;
          if constexpr (kSources)
            if (!is_black(direct)) parts.of_source = scene.light_importance(sampled_light);
          if (!is_black(direct)) add(direct, point.ray_depth + 1);
          if (point.ray_depth == 0) volume_pass = scattered;
          if (point.ray_depth == 0) alpha += luminance(scattered ? before : before - beta);
          if (!(largest(beta) > 0.0f)) break;
          if (scattered) {
            const uint32_t base = kCameraDimensions + kVertexDimensions * uint32_t(vertex++);
            sampler.set_dimension(base + kLobe);
            const float u_lobe = at.lobe_count > 1 ? sampler.get_1d() : 0.0f;
            sampler.set_dimension(base + kDirection);
            const Vec3 wi = phase.sample(ray.direction, u_lobe, sampler.get_2d());
            const float cosine = glm::dot(ray.direction, wi), pdf = phase.pdf_solid_angle(cosine);
            beta *= phase.evaluate(cosine) / pdf;
            ++point.ray_depth;
            last_chance = point.ray_depth > settings.bounces.total || ++volume_depth > settings.bounces.volume;
            point.ray_kind = kRayVolumeScatter;
            if (!survives(point.ray_depth, largest(beta), base, sampler, beta)) break;
            previous = DirectVertex();
            previous.bsdf_pdf = pdf;
            previous.position = place;
            from_medium = true;
            chosen_from = lights_for;
            Ray next;
            next.origin = place;
            next.direction = wi;
            next.time = ray.time;
            ray = next;
            continue;
          }
        }
      }

      if (!hit.found()) {
        const bool direct_view = point.ray_depth == 0;
        for_each_distant_light(scene, ray, point.ray_kind, !(direct_view && settings.transparent_film), add_met);
        if (direct_view && !settings.transparent_film) alpha += luminance(beta);
        break;
      }

      scene.shading_point(ray, hit, point);
      if (point.object->holdout && point.ray_depth == 0) break;
      const int material = scene.material_index(hit);
      const ShaderProgram& program = scene.programs()[size_t(material)];
      if constexpr (Medium::kThere) {
        if (program.has_volume() && !program.has_surface()) {
          if (++bounds > kMostBounds) break;
          medium.media.cross(hit, !point.backfacing, medium.stack, medium.counters);
          const float left = ray.t_max - hit.t;
          ray = scene.spawn_ray(point, ray.direction);
          ray.t_max = left;
          continue;
        }
      }
      program.evaluate_surface(point, shading);
      const Bsdf& bsdf = shading.bsdf;

      if (!is_black(shading.emission)) {
        const int light = scene.light_of(hit);
        // Without a light of its own (strength unknown at build) the emission is only found this way.
        if constexpr (kSources) parts.of_source = point.object->light_importance;
        const float weight = light >= 0 ? weight_of_hit(uint32_t(light), ray.direction, point.position, point.ng) : 1.0f;
        add(beta * shading.emission * weight, point.ray_depth);
      }
      SampleAux* const vertex_aux = point.ray_depth == 0 ? aux : nullptr;
      if (vertex_aux) {
        record_first_hit(scene, point, bsdf, *aux);
        aux = nullptr;
      }
      if constexpr (kParts) {
        if (point.ray_depth == 0) {
          const auto color = bsdf.albedo_of_kinds();
          for (size_t k = 0; k < 3; ++k) parts.color[k] += beta * color[k];
        }
      }
      const Color transparency = point.ray_depth == 0 || last_chance ? bsdf.transparency() : Color(0.0f);   // asked nowhere else
      if (point.ray_depth == 0) alpha += luminance(beta * (Color(1.0f) - transparency)) * (1.0f - shading.holdout);
      if (bsdf.empty()) break;
      const bool passes_only = last_chance && !is_black(transparency);
      if (last_chance && !passes_only) break;

      if constexpr (Guide::kGuided) {
        if (open_count > 0 && open[open_count - 1].sample.inverse_distance == 0.0f) open[open_count - 1].sample.inverse_distance = 1.0f / hit.t;
      }
      const uint32_t base = kCameraDimensions + kVertexDimensions * uint32_t(vertex++);
      if (bsdf.has_subsurface() && !last_chance && !point.mesh->strands) {   // below whose surface there is nowhere to walk: it is diffuse
        [[maybe_unused]] const float before = max_component(beta);
        sampler.set_dimension(kEnter + uint32_t(vertex));
        if (!enter_or_stay(hit, hash_combine(uint32_t(pixel_y) * uint32_t(settings.width) + uint32_t(pixel_x), base), sampler.get_1d(), point,
                           shading, beta, counter.rays))
          break;
        if constexpr (Guide::kGuided) unguided_beta *= max_component(beta) / before;
      }
      // By what scatters where light leaves, if it went below the surface.
      if constexpr (Guide::kGuided) guided.start(bsdf.has_non_delta() && !last_chance ? guide.tree : nullptr, bsdf, point.position, 1.0f - plain);
      DirectVertex here;
      if (bsdf.has_non_delta() && !last_chance && lights.can_choose()) {
        SampledLight sampled;
        const DirectLightContext context{scene, point, bsdf, uint32_t(material), pixel_x, pixel_y,
                                         Guide::kGuided ? &guided : nullptr, kParts || kSources ? &sampled : nullptr};
        Color direct;
        if constexpr (Medium::kThere) direct = direct_light.estimate(MediaDirectContext<Medium>{context, medium, hit}, sampler, base + kDirectLight, here, vertex_aux, counter.rays);
        else direct = direct_light.estimate(context, sampler, base + kDirectLight, here, vertex_aux, counter.rays);
        if constexpr (!std::is_same_v<DirectLight, MisDirectLight>) {
          if (has_soft_terminator(point)) direct += estimate_direct<true>(context, sampler, base + kDirectLight, counter.rays);
        }
        if constexpr (kParts)
          if (point.ray_depth == 0 && !is_black(direct)) shares = shares_of(bsdf, bsdf.f_cos_of_kinds(point.wo, sampled.wi));
        if constexpr (kSources) parts.of_source = scene.light_importance(sampled.light);
        if (!is_black(direct)) add(beta * direct, point.ray_depth + 1);
      }

      // Continue the path.
      float u_lobe = 0.5f;
      if (bsdf.lobe_count() > 1 || bsdf.lobe(0).kind != LobeKind::Diffuse) {
        sampler.set_dimension(base + kLobe);
        u_lobe = sampler.get_1d();
      }
      sampler.set_dimension(base + kDirection);
      const Vec2 u_direction = sampler.get_2d();
      std::optional<BsdfSample> sample;
      if constexpr (Guide::kGuided) {
        float u_guide = 0.0f, pdf_bsdf = 0.0f;
        if (guided.guided()) {
          sampler.set_dimension(base + kGuide);
          u_guide = sampler.get_1d();
        }
        sample = guided.sample(point.wo, u_guide, u_lobe, u_direction, pdf_bsdf);
        if (!sample || !(sample->pdf_solid_angle > 0.0f)) break;
        if (guide.samples && !sample->specular && open_count < kMostOpenVertices) {
          open[open_count++] = {{point.position, bsdf.n, sample->wi, 0.0f, 0.0f, pdf_bsdf / std::max(1.0f - guided.delta_chance(), 1e-6f), guided.kind(), guide.pixel, guide.index},
                                radiance, luminance(beta)};
        }
        if (!sample->specular) plain *= pdf_bsdf / sample->pdf_solid_angle;
        unguided_beta *= max_component(sample->f_cos) / (sample->specular ? sample->pdf_solid_angle : pdf_bsdf);
      } else {
        sample = bsdf.sample(point.wo, u_lobe, u_direction);
        if (!sample || !(sample->pdf_solid_angle > 0.0f)) break;
      }
      beta *= sample->f_cos / sample->pdf_solid_angle;
      if (!(largest(beta) > 0.0f)) break;
      if constexpr (Medium::kThere)
        if (glm::dot(sample->wi, point.ng) < 0.0f) medium.media.cross(hit, !point.backfacing, medium.stack, medium.counters);

      if (sample->flags & kTransparent) {
        // Straight on: the light sampled from the vertex before still competes, and bounces are not counted.
        if (++point.transparent_depth > settings.bounces.transparent) break;
        const float left = ray.t_max - hit.t;
        ray = scene.spawn_ray(point, ray.direction);
        ray.t_max = left;
        continue;
      }
      if (last_chance) break;

      if constexpr (kParts) {
        if (point.ray_depth == 0) {
          const float passes_on = sample->flags & kTransmission ? 1.0f : 0.0f;
          if (sample->specular) shares = Shares{Color(0.0f), Color(1.0f - passes_on), Color(passes_on)};
          else shares = shares_of(bsdf, bsdf.f_cos_of_kinds(point.wo, sample->wi));
        }
      }
      count_bounce(*sample, point, point);
      last_chance = past_limits(point, settings.bounces);

      // Nothing is left to find where only lights would count, and they are counted already.
      if (last_chance && here.complete && !sample->specular && ends_early_) break;

      // Russian roulette: survival in proportion to what the path can still carry. A direction that the guide likes has a high density and so a low
      // throughput, just because much light comes from there: the guide must not count.
      if (point.ray_depth > kSafeBounces) {
        const float survival = std::min(1.0f, std::sqrt(Guide::kGuided ? unguided_beta : largest(beta)));
        if (survival < 1.0f) {
          sampler.set_dimension(base + kRoulette);
          if (sampler.get_1d() >= survival) break;
          beta /= survival;
          if constexpr (Guide::kGuided) unguided_beta /= survival;
        }
      }
      if constexpr (Medium::kThere) from_medium = false;
      previous = here;
      previous.bsdf_pdf = sample->specular ? 0.0f : sample->pdf_solid_angle;
      previous.position = point.position;
      previous.normal = bsdf.receiving_normal();
      ray = scene.spawn_ray(point, sample->wi);
    }
    if constexpr (Guide::kGuided) {
      // What came along each direction is what was found after it was chosen.
      for (int i = 0; guide.samples && i < open_count; ++i) {
        OpenVertex& o = open[i];
        o.sample.weight = luminance(radiance - o.before) / o.beta;
        if (o.sample.weight > 0.0f && std::isfinite(o.sample.weight)) guide.samples->push_back(o.sample);
      }
    }
    return radiance;
  }

  /// Russian roulette after light was scattered in a medium.
  static bool survives(int ray_depth, float carried, uint32_t base, Sampler& sampler, Color& beta) {
    const float survival = ray_depth > kSafeBounces ? std::min(1.0f, std::sqrt(carried)) : 1.0f;
    if (survival == 1.0f) return true;
    sampler.set_dimension(base + kRoulette);
    if (!(sampler.get_1d() < survival)) return false;
    beta /= survival;
    return true;
  }

  /// At a surface that light may enter: either walk below it, and `point` and `shading` become those of where the walk leaves, or go on with the
  /// other lobes alone. False when the walk is lost.
  bool enter_or_stay(const Hit& hit, uint32_t stream, float u, ShadingPoint& point, SurfaceShading& shading, Color& beta, uint64_t& rays) const {
    const Bsdf::SubsurfacePart part = shading.bsdf.subsurface_part();
    if (u >= part.selection) {
      shading.bsdf.remove_subsurface(point.wo);
      beta /= 1.0f - part.selection;
      return !shading.bsdf.empty();
    }
    Pcg32 rng(uint64_t(u * 0x1p32f), stream);
    Color weight = beta * part.weight / (glm::max(shading.medium.albedo, Color(1e-6f)) * part.selection);
    if (!walk_below_surface(*scene_, hit, part.normal, shading.medium, rng, point, shading.bsdf, weight, rays)) return false;
    beta = weight;
    return true;
  }

  std::shared_ptr<const Scene> scene_;
  uint32_t seed_ = 0, samples_done_ = 0;
  PixelFilter filter_;
  Honesty honesty_ = Honesty::Unbiased;
  std::unique_ptr<DirectEstimator> mixture_;   // none: the default method
  std::unique_ptr<PathGuide> guide_;         // none: directions by the BSDF alone
  std::shared_ptr<const PathGuide::Past> guide_past_;   // to begin with
  std::unique_ptr<Media> media_;             // none: nothing between surfaces
  MediaCounters media_counters_;
  bool ends_early_ = false;
  Guiding guiding_ = Guiding::Off;
  float pilot_samples_ = 1.0f;               // of a pixel, in each iteration of the pilot of direct light
  uint64_t pilot_rays_ = 0;
  IntegratorStatistics statistics_;
};

}  // namespace

std::unique_ptr<Integrator> make_path_tracer() { return std::make_unique<PathTracer>(); }

std::vector<Vec2> measure_important_light(std::shared_ptr<const Scene> scene, uint32_t seed, float samples_per_pixel, const std::atomic<bool>& stop) {
  PathTracer tracer;
  tracer.prepare(std::move(scene), seed);
  return tracer.important_light(samples_per_pixel, stop);
}

}  // namespace ajar
