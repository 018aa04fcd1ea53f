#include "integrators/path_tracer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <type_traits>
#include <utility>

#include <tbb/combinable.h>

#include "film/filter.h"
#include "film/tile_loop.h"
#include "integrators/learned.h"
#include "integrators/path_walk.h"
#include "sampling/sampler.h"
#include "scene/pass_names.h"
#include "transport/direct/estimators/make_estimator.h"

namespace ajar {

namespace {

using D = PathDimensions;

class PathTracer final : public Integrator {
 public:
  Bias bias() const override { return bias_; }
  GoalSupport goal_support() const override {
    return {.follows = true,
            .learns = wants_guide() || (mixture_ && mixture_->learns()),
            .equal = wants_guide() ? PathGuide::kEqualSamples : 0};
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
    bias_ = direct.biased ? Bias::Biased : Bias::Unbiased;
    // The default method has its own copy of the loop without the code of the other methods.
    mixture_.reset();
    if (direct.method != DirectMethod::Mis || direct.samples > 1)
      mixture_ = make_direct_estimator(*scene_, direct.method, {.samples = direct.samples});
    // If there is only one choice, one sample of the learned mixture equals one of the default method.
    if (mixture_ && direct.method == DirectMethod::PmcHi && direct.samples <= 1 && !mixture_->wants_pilot())
      mixture_.reset();
    ends_early_ = plan.ends_early;
    media_.reset();
    if (plan.media) media_ = std::make_unique<Media>(*scene_);
    media_of_catchers_.reset();
    if (const Scene* catchers = scene_->catchers().get(); catchers && catchers->has_media())
      media_of_catchers_ = std::make_unique<Media>(*catchers);
    guide_.reset();
    guide_past_.reset();
    guiding_ = plan.guiding;
    lens_light_.reset();
    tries_lens_light_ = plan.lens_light;
  }

  bool begin_at(uint32_t first) override {
    if (wants_guide() || (mixture_ && (mixture_->learns() || mixture_->wants_pilot()))) return false;
    samples_done_ = first;
    return true;
  }

  std::vector<LearnedPart> begin_with(const Learned& learned) override {
    std::vector<LearnedPart> parts;
    if (learned.guide || wants_guide())
      parts.push_back({"path guide", !wants_guide()   ? "paths are not guided"
                                     : !learned.guide ? "the frame before has not learned enough"
                                                      : ""});
    if (wants_guide()) guide_past_ = learned.guide;
    const bool adaptive = mixture_ && mixture_->wants_pilot();
    if (learned.direct || adaptive)
      parts.push_back({"choice of lights", !adaptive         ? "lights are not learned"
                                           : !learned.direct ? "the frame before has not learned lights"
                                                             : mixture_->begin_with(*learned.direct)});
    return parts;
  }

  void hand_on(Learned& learned) override {
    if (guide_ && guide_->tree().cell_count() <= Learned::kMaxCells) learned.guide = guide_->past();
    if (mixture_) learned.direct = mixture_->past();
  }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    if (scene_->catchers()) film.enable_catchers(scene_->settings().transparent_film);
    if (mixture_ && mixture_->wants_pilot() && !run_pilot(film, stop)) return;
    if (tries_lens_light_ && !lens_light_) lens_light_ = std::make_unique<LensLight>(*scene_);
    if (has_lens_light()) film.enable_splats();
    if (!guide_ && wants_guide()) {
      const auto mode = guiding_ == Guiding::On ? PathGuide::Mode::On : PathGuide::Mode::Auto;
      guide_ = std::make_unique<PathGuide>(mode, film.width(), film.height(), kTile, guide_past_.get());
      guide_past_.reset();
    }
    // Training steps happen after 1, 2, 4, 8 ... samples and not at the end of iterations, which depends on the clock.
    while (samples_per_pixel > 0) {
      int samples = samples_per_pixel;
      if (guide_) samples = guide_->begin(samples_done_, samples, statistics_.rays);
      if (mixture_ && mixture_->learns())
        samples = std::min(samples, int(std::bit_ceil(samples_done_ + 1) - samples_done_));
      render_samples(film, samples, stop);
      if (stop.load(std::memory_order_relaxed)) return;
      samples_per_pixel -= samples;
      if (mixture_ && mixture_->learns() && std::has_single_bit(samples_done_)) mixture_->learn();
    }
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics statistics = statistics_;
    if (pilot_rays_ > 0) statistics.extra["pilot_rays"] = double(pilot_rays_);
    if (media_) add_statistics_of(media_counters_, media_->memory_bytes(), statistics);
    if (guide_) {
      statistics.extra["guide_followed"] = guide_->follows() ? 1.0 : 0.0;
      statistics.extra["guide_bytes"] = double(guide_->max_bytes());
      statistics.extra["guide_cells"] = double(guide_->tree().cell_count());
      if (guide_->measured_gain() > 0.0) statistics.extra["guide_measured_gain"] = guide_->measured_gain();
    }
    if (has_lens_light()) {
      statistics.extra["lens_light_share"] = double(lens_light_->share());
      statistics.extra["lens_light_trial_rays"] = double(lens_light_->trial_rays());
    }
    return statistics;
  }

  /// For `measure_important_light`, after `prepare`.
  std::vector<Vec2> important_light(float samples_per_pixel, const std::atomic<bool>& stop) {
    const auto& r = scene_->settings().region;
    Film film(r[0], r[1], r[2], r[3], {"Combined"});
    std::vector<uint32_t> goals(size_t(film.width()) * size_t(film.height()));
    for (uint32_t i = 0; i < goals.size(); ++i)
      goals[i] = uint32_t(samples_per_pixel + to_unit_float(hash_combine(seed_, i)));
    film.set_goals(std::move(goals));
    tbb::combinable<PathCounters> counters;
    if (media_)
      render_with<ImportantLight, InMedia>(MisDirectLight(), Unguided(), film, stop, counters);
    else
      render_with<ImportantLight, NoMedia>(MisDirectLight(), Unguided(), film, stop, counters);
    const std::vector<float> pairs = film.resolve("Combined", 1.0f);
    std::vector<Vec2> light(pairs.size() / 4);
    for (size_t i = 0; i < light.size(); ++i) light[i] = Vec2(pairs[4 * i], pairs[4 * i + 1]);
    return light;
  }

 private:
  bool wants_guide() const { return guiding_ != Guiding::Off; }
  bool has_lens_light() const { return lens_light_ && lens_light_->active(); }

  /// Draws training samples that are not part of the image. They end before its first sample, so that all its samples
  /// use the same shares. If the shares changed within a sequence, only the pieces would be stratified, and this loses
  /// more than later training gains.
  bool run_pilot(const Film& film, const std::atomic<bool>& stop) {
    Film discarded(film.x0(), film.y0(), film.x0() + film.width(), film.y0() + film.height(), {"Combined"});
    const uint32_t seed = seed_;
    seed_ = hash_combine(seed, 0x70696c6fU);
    std::vector<uint32_t> goals(size_t(film.width()) * size_t(film.height()), 0);
    for (uint32_t iteration = 0; mixture_->wants_pilot() && !stop.load(std::memory_order_relaxed); ++iteration) {
      for (uint32_t i = 0; i < goals.size(); ++i)
        goals[i] += uint32_t(pilot_samples_ + to_unit_float(hash_combine(seed_ + iteration, i)));
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
    tbb::combinable<PathCounters> counters;
    const bool guided = guide_ && guide_->active();
    const auto with = [&](const auto& direct_light, auto parts) {
      using P = decltype(parts);
      if constexpr (std::is_same_v<std::decay_t<decltype(direct_light)>, MisDirectLight>) {
        if (media_) {
          guided ? render_with<P, InMedia>(direct_light, Guided(), film, stop, counters)
                 : render_with<P, InMedia>(direct_light, Unguided(), film, stop, counters);
          return;
        }
      }
      guided ? render_with<P, NoMedia>(direct_light, Guided(), film, stop, counters)
             : render_with<P, NoMedia>(direct_light, Unguided(), film, stop, counters);
    };
    const bool direct = film.wants_direct();
    if (mixture_)
      direct ? with(*mixture_, DirectPart()) : with(*mixture_, NoParts());
    else if (film.wants_parts())
      with(MisDirectLight(), LightPasses());
    else
      direct ? with(MisDirectLight(), DirectPart()) : with(MisDirectLight(), NoParts());
    counters.combine_each([&](const PathCounters& c) {
      statistics_.rays += c.rays;
      statistics_.paths += c.paths;
      media_counters_.add(c.media);
    });
    if (has_lens_light()) {
      const double mean = film.sample_counts().mean;
      film.end_splats(mean > 0.0 ? 1.0 / mean : 0.0);
    }
  }

  float time_of_sample(Sampler& sampler, int py) const {
    sampler.set_dimension(D::kTime);
    return scene_->camera().time_of(sampler.get_1d(), py);
  }

  // What a sample finds besides its radiance.
  template <class Parts>
  Parts parts_for(const Film& film) const {
    if constexpr (std::is_same_v<Parts, LightPasses>)
      return LightPasses(*scene_, film);
    else
      return Parts();
  }
  template <class Parts>
  static void begin(Parts& parts) {
    parts = Parts();
  }
  static void begin(LightPasses& passes) { passes.begin(); }
  template <class Parts>
  static void add_to_film(Film&, int, int, const Parts&) {}
  static void add_to_film(Film& film, int x, int y, const DirectPart& part) {
    if (film.wants_direct()) film.add_direct(x, y, part.direct_paths);
  }
  static void add_to_film(Film& film, int x, int y, const LightPasses& passes) {
    film.add_parts(x, y, passes.parts());
    if (film.wants_direct()) film.add_direct(x, y, passes.parts().direct_paths);
  }

  template <class Parts, class Medium, class DirectLight, class Guide>
  void render_with(const DirectLight& direct_light, Guide, Film& film, const std::atomic<bool>& stop,
                   tbb::combinable<PathCounters>& counters) {
    struct Tile {
      Sampler sampler;
      PathCounters& counter;
      SampleRecord record;
      Parts parts;
    };
    const uint32_t full_width = uint32_t(scene_->settings().width);
    const bool moves = scene_->moves();
    for_each_sample(
        film, samples_done_, stop,
        [&] {
          return Tile{Sampler(Sampler::Kind::Sobol, seed_), counters.local(), SampleRecord(), parts_for<Parts>(film)};
        },
        [&](Tile& tile, int px, int py, uint32_t index) {
          const uint32_t pixel = uint32_t(py) * full_width + uint32_t(px);
          tile.sampler.start(pixel, index);
          const Vec2 offset = filter_.sample(tile.sampler.get_2d());
          const Vec2 on_film(float(px) + 0.5f + offset.x, float(py) + 0.5f + offset.y);
          const Vec2 u_lens = scene_->camera().has_lens() ? tile.sampler.get_2d() : Vec2(0.5f);
          const float time = moves ? time_of_sample(tile.sampler, py) : 0.0f;
          const Ray ray = scene_->camera().generate_ray(on_film, u_lens, time);
          SampleAux* const aux = tile.record.begin(film, px, py);
          const uint64_t rays_before = tile.counter.rays;
          float alpha = 1.0f;
          if (sees_nothing(ray)) {
            film.add_sample(px, py, Color(0.0f), 1.0f, aux);
            return;
          }
          Guide guide;
          [[maybe_unused]] typename Guide::Outcome outcome;
          if constexpr (Guide::kGuided) {
            guide = guide_->of_sample(px - film.x0(), py - film.y0(), pixel, index);
            if (guide_->measuring()) guide.outcome = &outcome;
          }
          Parts& parts = tile.parts;
          begin(parts);
          CaughtPath caught;
          PathStart start{*scene_,      ray,          px,
                          py,           tile.sampler, aux,
                          tile.counter, ends_early_,  scene_->catchers() ? &caught : nullptr};
          start.lens_light = has_lens_light() ? lens_light_.get() : nullptr;
          start.film = on_film;
          const auto along = [&](auto medium) {
            return PathWalk<DirectLight, Guide, Medium, Parts>(direct_light, guide, std::move(medium), parts, start)
                .trace(alpha);
          };
          Color radiance;
          if constexpr (Medium::kThere) {
            MediaCounters& media = tile.counter.media;
            const MediaStack around = media_->around(ray.origin + ray.t_min * ray.direction, ray.time, media);
            radiance = along(InMedia{*media_, media, Pcg32(hash_combine(seed_, pixel), index), around});
          } else {
            radiance = along(NoMedia());
          }
          if constexpr (std::is_same_v<Parts, ImportantLight>)
            radiance = Color(luminance(radiance), parts.luminance, 0.0f);
          if constexpr (Guide::kGuided)
            if (guide.outcome) {
              const float exposure = shown_exposure(scene_->settings());
              guide_->measure(px - film.x0(), py - film.y0(), exposure * luminance(radiance),
                              {exposure * outcome.unguided, outcome.share});
            }
          if (has_lens_light()) [[unlikely]]
            sample_lens_light(film, pixel, index, (index + uint32_t(px + py)) & 1, parts, tile.counter);
          const bool added = film.add_sample(px, py, radiance, alpha, aux);
          film.add_rays(px, py, tile.counter.rays - rays_before);
          if (added && film.has_catchers()) [[unlikely]] {
            const CaughtSample sample = compare(caught, start, index, radiance, alpha);
            if (is_finite(sample.alone) && is_finite(sample.background)) film.add_caught(px, py, sample);
          }
          if (added) add_to_film(film, px, py, parts);
        });
  }

  /// Draws the light sample of a sample of a pixel, if it has one. `odd`: the half of the splats.
  template <class Parts>
  void sample_lens_light(Film& film, uint32_t pixel, uint32_t index, bool odd, const Parts& parts,
                         PathCounters& counters) const {
    const uint32_t seed = hash_combine(seed_, 0x6c656e73U);
    if (!(to_unit_float(hash_combine(hash_combine(seed, pixel), index)) < lens_light_->share())) return;
    Sampler sampler(Sampler::Kind::Sobol, seed);
    sampler.start(index, pixel);  // one sequence over the film
    auto splat = lens_light_->sample(sampler, counters.rays);
    if (!splat) return;
    if (media_) {
      const Ray& ray = splat->ray;
      const MediaStack around = media_->around(ray.origin + ray.t_min * ray.direction, ray.time, counters.media);
      Pcg32 rng(hash_combine(seed, pixel), index);
      const float distance = glm::dot(splat->met.position - ray.origin, ray.direction);
      if (!around.empty())
        splat->light *= media_->transmittance({around, ray, distance, ShadingPoint(), kRayCamera}, rng, counters.media);
    }
    const RenderSettings& settings = scene_->settings();
    const Vec2 u = sampler.get_2d();
    const auto column = filter_.place(splat->film.x, 0, settings.width, u.x),
               row = filter_.place(splat->film.y, 0, settings.height, u.y);
    PathPasses passes;
    passes.is_direct = true;
    if constexpr (std::is_same_v<Parts, LightPasses>) {
      passes.part = PathPasses::Part::Emission;
      passes.group = parts.shown(splat->object ? scene_->light_group_of(*splat->object)
                                               : scene_->light_group(splat->met.light));
    }
    film.add_splat(column.pixel, row.pixel, splat->light * (column.weight * row.weight), odd, passes);
  }

  /// The part of a sample in the composite with shadow catchers. Where the path met a catcher, a second path meets it in
  /// the scene without the other objects.
  CaughtSample compare(const CaughtPath& path, const PathStart& start, uint32_t index, Color radiance, float alpha) {
    const Color background = start.ray.t_max > 0.0f && scene_->lights().environment_index() >= 0
                                 ? scene_->lights().environment_radiance(start.ray.direction, kRayCamera)
                                 : Color(0.0f);
    if (!path.caught) return {.matte = radiance, .alpha = alpha, .background = path.sees_background * background};
    CaughtPath again;
    const Ray& ray = path.past_glass ? *path.past_glass : start.ray;
    const PathStart same{*scene_->catchers(), ray,   start.pixel_x, start.pixel_y, start.sampler, nullptr,
                         start.counters,      false, &again};
    const MisDirectLight direct_light;
    const Unguided unguided{};
    NoParts parts;
    float unused = 0.0f;
    const auto along = [&](auto medium) {
      return PathWalk<MisDirectLight, Unguided, decltype(medium), NoParts>(direct_light, unguided, std::move(medium),
                                                                           parts, same)
          .trace(unused);
    };
    Color alone;
    if (const Media* media = media_of_catchers_.get()) {
      const uint32_t pixel = uint32_t(start.pixel_y) * uint32_t(scene_->settings().width) + uint32_t(start.pixel_x);
      MediaCounters& counters = start.counters.media;
      const MediaStack around = media->around(ray.origin + ray.t_min * ray.direction, ray.time, counters);
      alone = along(InMedia{*media, counters, Pcg32(hash_combine(seed_, pixel), index), around});
    } else {
      alone = along(NoMedia());
    }
    // Both paths have the same throughput in what fills the world. The first one may have passed other objects as well.
    const Color passed = path.throughput / glm::max(again.throughput, Color(1e-20f));
    return {.caught = true,
            .lit = radiance - path.before,
            .alone = again.caught ? passed * (alone - again.before) : Color(0.0f),
            .matte = path.before,
            .alpha = path.alpha_before,
            .background = path.throughput * background};
  }

  std::shared_ptr<const Scene> scene_;
  uint32_t seed_ = 0, samples_done_ = 0;
  PixelFilter filter_;
  Bias bias_ = Bias::Unbiased;
  std::unique_ptr<DirectEstimator> mixture_;           // null: the default method
  std::unique_ptr<PathGuide> guide_;                   // null: directions by the BSDF alone
  std::shared_ptr<const PathGuide::Past> guide_past_;  // from which the guide starts
  std::unique_ptr<Media> media_;                       // null: no media
  std::unique_ptr<Media> media_of_catchers_;           // of Scene::catchers; null: no media
  MediaCounters media_counters_;
  bool ends_early_ = false, tries_lens_light_ = false;
  std::unique_ptr<LensLight> lens_light_;  // null: not tried; it may be inactive
  Guiding guiding_ = Guiding::Off;
  float pilot_samples_ = 1.0f;  // per pixel, in each iteration of the pilot of direct light
  uint64_t pilot_rays_ = 0;
  IntegratorStatistics statistics_;
};

}  // namespace

std::unique_ptr<Integrator> make_path_tracer() { return std::make_unique<PathTracer>(); }

std::vector<Vec2> measure_important_light(std::shared_ptr<const Scene> scene, uint32_t seed, float samples_per_pixel,
                                          const std::atomic<bool>& stop) {
  PathTracer tracer;
  tracer.prepare(std::move(scene), seed);
  return tracer.important_light(samples_per_pixel, stop);
}

}  // namespace ajar
