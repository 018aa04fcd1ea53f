#include "integrators/irradiance_cache.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>

#include <tbb/combinable.h>

#include "film/filter.h"

#include "film/tile_loop.h"
#include "math/warps.h"
#include "transport/direct/estimators/make_estimator.h"
#include "transport/direct/eye_media.h"
#include "transport/media/subsurface_walk.h"
#include "transport/paths/eye_walk.h"
#include "transport/paths/record.h"
#include "transport/paths/walk.h"
#include "transport/photons/cached_part.h"
#include "transport/photons/irradiance_records.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

namespace {

/// Dimensions of the sampler: those of the camera (for records: of the direction), then a fixed number for each vertex.
constexpr uint32_t kFirstDimensions = 6, kVertexDimensions = 8;
constexpr uint32_t kDirectLight = 0, kLobe = kDirectDimensions, kLookup = 4, kRoulette = 6, kSubsurface = 7;
constexpr int kRaysPerGatherRay = 25;  ///< of a record, per gather ray of the setting
/// Spacing of the pixels at which records are placed. It is halved in each step.
constexpr int kCoarsestStride = 16, kFinestStride = 2;
constexpr float kMinRadius = 3.0f, kMaxRadius = 32.0f;  ///< of records, in pixels
constexpr float kEnough = 0.4f;                         ///< coverage from which no further record is placed
constexpr int kMaxVertices = 64;                        ///< on the path to the position of a record

struct Counters {
  uint64_t rays = 0, paths = 0, lookups = 0, found = 0;
};
/// Whether diffuse lobes can receive indirect light here.
bool bounces_diffusely(const ShadingPoint& point, const BounceLimits& limits) {
  return point.ray_depth < limits.total && point.diffuse_depth < limits.diffuse;
}

class IrradianceCache final : public Integrator {
 public:
  Bias bias() const override { return Bias::Biased; }
  GoalSupport goal_support() const override { return {.follows = true, .by_passes = true, .learns = true}; }

  using Integrator::prepare;
  void prepare(std::shared_ptr<const Scene> scene, const RenderPlan& plan, uint32_t seed) override {
    scene_ = std::move(scene);
    media_ = plan.media ? std::make_unique<const PathMedia>(*scene_) : nullptr;
    seed_ = seed;
    pass_ = 0;
    statistics_ = {};
    records_made_ = lookups_ = found_ = 0;
    const RenderSettings& settings = scene_->settings();
    filter_ = PixelFilter(settings.filter, settings.filter_width);
    grid_ = HemisphereGrid(kRaysPerGatherRay * std::max(1, settings.gather_rays));
    mixture_.reset();
    if (plan.direct.method != DirectMethod::Mis || plan.direct.samples > 1)
      mixture_ = make_direct_estimator(*scene_, plan.direct.method, {.samples = plan.direct.samples, .deepest = 1});
    const Vec2 middle(0.5f * float(settings.width), 0.5f * float(settings.height));
    const Ray a = scene_->camera().generate_ray(middle, Vec2(0.5f), 0.0f),
              b = scene_->camera().generate_ray(middle + Vec2(1, 0), Vec2(0.5f), 0.0f);
    pixel_size_ = glm::length(a.origin - b.origin);
    pixel_angle_ = glm::length(a.direction - b.direction);
  }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    // Every sample of a pixel is a separate pass, so that the image does not depend on the division of a render into
    // iterations.
    for (int i = 0; i < samples_per_pixel && !stop.load(std::memory_order_relaxed); ++i) {
      if (mixture_)
        run_pass(*mixture_, film, stop);
      else
        run_pass(MisDirectLight(), film, stop);
    }
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics statistics = statistics_;
    add_statistics_of(media_.get(), statistics);
    statistics.extra["passes"] = double(pass_);
    statistics.extra["record_bytes"] = double(records_.memory_bytes());
    statistics.extra["records"] = pass_ > 0 ? double(records_made_) / double(pass_) : 0.0;
    statistics.extra["found_in_cache"] = lookups_ > 0 ? double(found_) / double(lookups_) : 0.0;
    return statistics;
  }

 private:
  /// The start of a path: at the eye, or at a record.
  struct Start {
    Ray ray;
    int pixel_x, pixel_y;
    Color to_lights{1.0f};              ///< throughput to lights that the first ray hits
    ShadingPoint from{};                ///< kind and depths of the first ray
    MediaStack stack{};                 ///< media of the first ray
    uint64_t media_seed = 0;            ///< of random numbers in media
    float* inverse_distance = nullptr;  ///< to the first surface; set for records, which do not use the cache
  };
  /// What a path carries.
  struct Throughputs {
    Color &radiance, &beta, &to_lights;
    bool& at_bounce_limit;
  };
  /// A sampler and the first dimension of a vertex.
  struct Numbers {
    Sampler& sampler;
    uint32_t first;
  };
  struct Tile {
    Sampler sampler;
    Counters& counter;
  };

  template <class DirectLight>
  void run_pass(const DirectLight& direct_light, Film& film, const std::atomic<bool>& stop) {
    tbb::combinable<Counters> counters;
    make_records(direct_light, film, stop, counters);
    if (stop.load(std::memory_order_relaxed)) return;
    const float time = time_of_pass(*scene_, seed_, pass_);
    ++pass_;
    for_each_sample(
        film, pass_, stop,
        [&] {
          return Tile{Sampler(Sampler::Kind::Sobol, seed_), counters.local()};
        },
        [&](Tile& tile, int px, int py, uint32_t index) {
          const Ray ray = start_sample(tile.sampler, px, py, index, time);
          SampleRecord record;
          SampleAux* const aux = record.begin(film, px, py);
          float alpha = 1.0f;
          ++tile.counter.paths;
          const uint64_t rays_before = tile.counter.rays;
          const Color radiance = sees_nothing(ray) ? Color(0.0f)
                                                   : trace(direct_light, start_at_camera(ray, px, py, index),
                                                           tile.sampler, aux, alpha, tile.counter);
          film.add_sample(px, py, radiance, alpha, aux);
          film.add_rays(px, py, tile.counter.rays - rays_before);
        });
    counters.combine_each([&](const Counters& c) {
      statistics_.rays += c.rays;
      statistics_.paths += c.paths;
      lookups_ += c.lookups;
      found_ += c.found;
    });
    // Methods that learn use whole passes. The images of the first passes have the same weight as the others.
    if constexpr (std::is_same_v<DirectLight, DirectEstimator>) {
      if (!stop.load(std::memory_order_relaxed) &&
          (mixture_->wants_pilot() || (mixture_->learns() && std::has_single_bit(pass_))))
        mixture_->learn();
    }
  }

  Ray start_sample(Sampler& sampler, int px, int py, uint32_t index, float time) const {
    sampler.start(pixel_number(px, py), index);
    const Vec2 offset = filter_.sample(sampler.get_2d());
    const Vec2 u_lens = scene_->camera().has_lens() ? sampler.get_2d() : Vec2(0.5f);
    return scene_->camera().generate_ray(Vec2(float(px) + 0.5f, float(py) + 0.5f) + offset, u_lens, time);
  }
  uint32_t pixel_number(int px, int py) const {
    return uint32_t(py) * uint32_t(scene_->settings().width) + uint32_t(px);
  }

  // ---- Records -------------------------------------------------------------------------------

  /// Places the records of this pass, from coarse to fine. A pixel's sample of this pass gets a record where the
  /// records of coarser steps and of its own tile do not cover it. Tiles of one step do not see each other's records,
  /// so the number of threads does not matter.
  template <class DirectLight>
  void make_records(const DirectLight& direct_light, const Film& film, const std::atomic<bool>& stop,
                    tbb::combinable<Counters>& counters) {
    records_.clear();
    if (media_) return;  // nothing is cached
    const LightSet& lights = scene_->lights();
    if ((lights.empty() && !scene_->emission_without_lights()) || scene_->settings().bounces.total < 1) return;
    const int columns = (film.width() + kTile - 1) / kTile, rows = (film.height() + kTile - 1) / kTile;
    const uint32_t shift = hash_combine(seed_ ^ 0x72656373U, pass_);
    for (int stride = kCoarsestStride; stride >= kFinestStride && !stop.load(std::memory_order_relaxed); stride /= 2) {
      std::vector<std::vector<IrradianceRecord>> made(size_t(columns) * size_t(rows));
      tbb::parallel_for(
          tbb::blocked_range<int>(0, columns * rows, 1),
          [&](const tbb::blocked_range<int>& range) {
            Counters& counter = counters.local();
            for (int tile = range.begin(); tile < range.end(); ++tile) {
              const int x0 = kTile * (tile % columns), y0 = kTile * (tile / columns);
              for (int y = y0; y < std::min(y0 + kTile, film.height()); ++y) {
                for (int x = x0; x < std::min(x0 + kTile, film.width()); ++x) {
                  if (stop.load(std::memory_order_relaxed)) return;
                  if (stride == stride_of(film.x0() + x + int(shift & 0xff), film.y0() + y + int(shift >> 8 & 0xff)))
                    make_record(direct_light, film.x0() + x, film.y0() + y, made[size_t(tile)], counter);
                }
              }
            }
          },
          tbb::simple_partitioner());
      for (const std::vector<IrradianceRecord>& of_tile : made) {
        records_.add(of_tile);
        records_made_ += of_tile.size();
      }
      records_.limit_by_neighbours();
    }
  }

  /// The coarsest stride whose grid contains these coordinates.
  static int stride_of(int x, int y) {
    return std::min(kCoarsestStride, 1 << std::countr_zero(uint32_t(x | y | kCoarsestStride)));
  }

  template <class DirectLight>
  void make_record(const DirectLight& direct_light, int px, int py, std::vector<IrradianceRecord>& made,
                   Counters& counter) const {
    Sampler sampler(Sampler::Kind::Sobol, seed_);
    const Ray ray = start_sample(sampler, px, py, pass_, time_of_pass(*scene_, seed_, pass_));
    ShadingPoint place;
    SurfaceShading shading;
    MediaStack stack;
    float length = 0.0f;
    if (sees_nothing(ray) || !find_place(ray, sampler, place, shading, length, stack, counter)) return;
    const Vec3 p = place.position, n = shading.bsdf.n;
    float covered = records_.coverage(p, n);
    for (const IrradianceRecord& other : made) covered += other.weight(p, n);
    if (covered >= kEnough) return;

    // One path for each stratum. Lamps and emission that its first ray hits are direct light, which is counted
    // elsewhere.
    const Frame frame(n);
    const int strata = grid_.strata();
    std::vector<Color> radiance(size_t(strata), Color(0.0f));
    std::vector<float> inverse_distance(size_t(strata), 0.0f);
    const uint32_t unit = hash_combine(pixel_number(px, py), 0x69727261U);
    for (int i = 0; i < strata; ++i) {
      sampler.start(unit, pass_ * uint32_t(strata) + uint32_t(i));
      const Vec3 wi = frame.to_world(grid_.direction(i, sampler.get_2d()));
      if (!(glm::dot(wi, shading.bsdf.ng) > 0.0f)) continue;
      ++counter.paths;
      Start start{scene_->spawn_ray(place, wi), px, py, Color(0.0f)};
      start.stack = stack;
      start.media_seed = hash_combine(unit, pass_ * uint32_t(strata) + uint32_t(i));
      start.from = place;
      count_bounce({wi, Color(1.0f), 1.0f, kReflection | kDiffuse, false}, place, start.from);
      start.inverse_distance = &inverse_distance[size_t(i)];
      float alpha;
      radiance[size_t(i)] = trace(direct_light, start, sampler, nullptr, alpha, counter);
    }
    IrradianceRecord record = grid_.record(p, frame, radiance, inverse_distance);
    if (!is_finite(record.irradiance)) return;
    const float pixel = pixel_size_ + pixel_angle_ * length;
    record.radius = glm::clamp(IrradianceRecords::kRadiusShare * record.radius, kMinRadius * pixel, kMaxRadius * pixel);
    made.push_back(record);
  }

  Start start_at_camera(const Ray& ray, int px, int py, uint32_t index) const {
    Start start{ray, px, py};
    start.stack = EyeMedia::around_camera(media_.get(), ray);
    start.media_seed = hash_combine(pixel_number(px, py), index);
    return start;
  }

  /// Follows a sample to the first surface that would use the cache. `length`: distance along the path. `stack`: media
  /// in front of the surface.
  bool find_place(Ray ray, Sampler& sampler, ShadingPoint& point, SurfaceShading& shading, float& length,
                  MediaStack& stack, Counters& counter) const {
    const BounceLimits& limits = scene_->settings().bounces;
    EyeWalk walk(*scene_, ray, counter.rays);
    EyeMedia media(*scene_, media_.get(), EyeMedia::around_camera(media_.get(), ray), 0, counter.rays);
    for (uint32_t vertex = 0; vertex < kMaxVertices; ++vertex) {
      walk.trace();
      if (!walk.found() || !walk.arrive()) return false;
      length += walk.hit.t;
      if (scene_->material(walk.hit).only_encloses()) {
        media.leave(walk, walk.ray.direction);
        walk.pass_uncounted();
        continue;
      }
      walk.shade();
      if (bounces_diffusely(walk.point, limits) && !on_strand_or_point(walk.point) &&
          !walk.shading.bsdf.has_subsurface() && CachedPart(walk.shading.bsdf, walk.point.wo)) {
        point = walk.point;
        shading = walk.shading;
        if (media.active()) stack = media.state().stack;
        return true;
      }
      const auto sample = sample_direction(walk.shading.bsdf, walk.point, sampler,
                                           kFirstDimensions + kVertexDimensions * vertex);
      if (!sample) return false;
      if (sample->flags & kTransparent) {
        media.leave(walk, walk.ray.direction);
        if (!walk.pass_through()) return false;
        continue;
      }
      count_bounce(*sample, walk.point, walk.point);
      if (past_limits(walk.point, limits)) return false;
      media.leave(walk, sample->wi);
      walk.leave_along(sample->wi);
    }
    return false;
  }

  std::optional<BsdfSample> sample_direction(const Bsdf& bsdf, const ShadingPoint& point, Sampler& sampler,
                                             uint32_t base) const {
    if (bsdf.empty()) return std::nullopt;
    sampler.set_dimension(base + kLobe);
    const Vec3 u = sampler.get_3d();
    auto sample = bsdf.sample(point.wo, u.z, Vec2(u));
    if (sample && !(sample->pdf_solid_angle > 0.0f)) sample.reset();
    return sample;
  }

  // ---- Paths ---------------------------------------------------------------------------------

  static bool pass_through(EyeWalk& walk, EyeMedia& media, const BsdfSample& sample, Color& to_lights, Color& beta) {
    const Color through = sample.f_cos / sample.pdf_solid_angle;
    to_lights *= through;
    beta *= through;
    media.leave(walk, walk.ray.direction);
    return walk.pass_through();
  }

  /// Adds the cached light of the lobes for which the cache stands, and returns the throughput of the other lobes;
  /// nothing if the cache has no record here. It is inlined so that the compiler fuses sums and products as in one loop.
  [[gnu::always_inline]] std::optional<Color> read_cache(const EyeWalk& walk, Sampler& sampler, uint32_t dimension,
                                                         const std::optional<BsdfSample>& sample, Counters& counter,
                                                         Color beta, Color& radiance) const {
    const ShadingPoint& point = walk.point;
    const Bsdf& bsdf = walk.shading.bsdf;
    const CachedPart cached(bsdf, point.wo);
    Color irradiance;
    counter.lookups += bool(cached);
    if (!cached || !records_.find(point.position, bsdf.n, irradiance)) return {};
    ++counter.found;
    sampler.set_dimension(dimension);
    radiance += beta * cached.albedo(point.wo, sampler.get_2d()) * kInvPi * irradiance;
    return sample ? beta * cached.others(point.wo, *sample) : beta;
  }

  /// Goes below a surface, or stays. False if the path is lost.
  bool below_surface(EyeWalk& walk, Sampler& sampler, uint32_t dimension, Color& beta, Counters& counter) const {
    sampler.set_dimension(dimension);
    const float u = sampler.get_1d();
    return walk_below_or_stay(*scene_, walk.hit.instance, {u, hash_combine(uint32_t(u * 0x1p32f), dimension)},
                              walk.point, walk.shading, beta, counter.rays);
  }

  /// The throughputs along the sampled direction. False at the end of the path. `after`: throughput to scattered light.
  [[gnu::always_inline]] bool go_on(const BsdfSample& sample, EyeWalk& walk, const DirectVertex& here, Color after,
                                    Throughputs light, Numbers numbers) const {
    ShadingPoint& point = walk.point;
    light.to_lights = light.beta * sample.f_cos / sample.pdf_solid_angle;
    light.beta = after / sample.pdf_solid_angle;
    if (!(max_component(light.to_lights) > 0.0f)) return false;
    count_bounce(sample, point, point);
    light.at_bounce_limit = past_limits(point, scene_->settings().bounces);
    // Beyond this vertex only lights would count, and light sampling has counted them already.
    if ((light.at_bounce_limit || is_black(light.beta)) && here.complete && !sample.specular &&
        !scene_->emission_without_lights())
      return false;
    return point.ray_depth <= 2 || survives(std::min(1.0f, std::sqrt(max_component(light.to_lights))), numbers.sampler,
                                            numbers.first + kRoulette, light.to_lights, light.beta);
  }

  /// Media along the present ray. Beta and to_lights get what remains of them. Traced: the walk has a new ray.
  EyeMedia::Step pass_media(EyeMedia& media, EyeWalk& walk, Sampler& sampler, uint32_t dimension, Throughputs light,
                            float& alpha) const {
    Color through(1.0f);
    EyeMedia::Light found;
    const EyeMedia::Step step = media.pass(walk, {sampler, dimension, !light.at_bounce_limit}, through, found, &alpha);
    light.radiance += light.beta * found.sum();
    light.beta *= through;
    light.to_lights *= through;
    if (media.chose_direction()) light.to_lights = light.beta;
    light.at_bounce_limit |= past_limits(walk.point, scene_->settings().bounces) || media.at_limit();
    return step;
  }

  /// Radiance along a path. It has two throughputs. `to_lights` applies to lights that its ray hits and includes all
  /// lobes. `beta` applies to light that surfaces scatter and excludes the lobes whose part comes from the cache.
  template <class DirectLight>
  Color trace(const DirectLight& direct_light, const Start& start, Sampler& sampler, SampleAux* aux, float& alpha,
              Counters& counter) const {
    const Scene& scene = *scene_;
    const RenderSettings& settings = scene.settings();
    EyeWalk walk(scene, start.ray, counter.rays, start.from);
    EyeMedia media(scene, media_.get(), start.stack, start.media_seed, counter.rays);
    ShadingPoint& point = walk.point;
    const SurfaceShading& shading = walk.shading;
    Color radiance(0.0f), beta(1.0f), to_lights = start.to_lights;
    DirectVertex previous;
    bool at_bounce_limit = past_limits(point, settings.bounces);  // only the emission of the next surface still counts
    alpha = 0.0f;
    for (uint32_t vertex = 0;; ++vertex) {
      walk.trace();
      const auto weight_of_hit = [&](uint32_t light, Vec3 position, Vec3 normal) {
        if (media.chose_direction()) return media.weight_of_hit(walk, light, position, normal);
        return direct_light.weight_of_hit(scene, previous, light, walk.ray.direction, position, normal);
      };
      const auto add_met = [&](const LightMet& met) {
        radiance += to_lights * met.radiance * media.to_lamp(walk, met) *
                    weight_of_hit(met.light, met.position, met.normal);
      };
      if (!is_black(to_lights)) walk.meet_lamps(add_met);
      if (media.active()) [[unlikely]] {
        if (vertex == 0 && start.inverse_distance && walk.found()) *start.inverse_distance = 1.0f / walk.hit.t;
        const EyeMedia::Step step = pass_media(media, walk, sampler,
                                               kFirstDimensions + kVertexDimensions * vertex + kDirectLight,
                                               {radiance, beta, to_lights, at_bounce_limit}, alpha);
        if (step == EyeMedia::Step::End) break;
        if (step == EyeMedia::Step::Traced) continue;
      }
      if (!walk.found()) {
        if (!is_black(to_lights)) walk.meet_distant(add_met);
        alpha += record_nothing(scene, walk, beta, aux);
        break;
      }
      if (vertex == 0 && start.inverse_distance) *start.inverse_distance = 1.0f / walk.hit.t;
      if (!walk.arrive()) break;
      walk.shade();
      const Bsdf& bsdf = shading.bsdf;
      if (!is_black(shading.emission) && !is_black(to_lights))
        radiance += to_lights * shading.emission * walk.emission_weight(weight_of_hit);
      SampleAux* const vertex_aux = record_vertex(*scene_, point, bsdf, to_lights, aux);
      const Color transparency = bsdf.transparency();
      if (point.ray_depth == 0) alpha += walk.alpha_of_surface(beta, transparency);
      if (bsdf.empty()) break;
      const bool passes_only = at_bounce_limit || is_black(beta);
      if (passes_only && is_black(transparency)) break;

      const uint32_t base = kFirstDimensions + kVertexDimensions * vertex;
      const bool below = !passes_only && bsdf.has_subsurface() && !on_strand_or_point(point);
      if (below && !below_surface(walk, sampler, base + kSubsurface, beta, counter)) break;
      DirectVertex here;
      if (bsdf.has_non_delta() && !passes_only && scene.lights().can_choose()) {
        const DirectLightContext context{scene,         point,        bsdf, uint32_t(scene.material_index(walk.hit)),
                                         start.pixel_x, start.pixel_y};
        radiance += beta * estimate_direct_through(media, walk.hit, direct_light, context,
                                                   {sampler, base + kDirectLight, here, vertex_aux, counter.rays});
      }
      const auto sample = sample_direction(bsdf, point, sampler, base);
      Color after = sample ? beta * sample->f_cos : beta;  // throughput to light of the lobes that are not cached
      if (!start.inverse_distance && !media.active() && !passes_only && !below && !on_strand_or_point(point) &&
          bounces_diffusely(point, settings.bounces))
        after = read_cache(walk, sampler, base + kLookup, sample, counter, beta, radiance).value_or(after);
      if (!sample) break;
      if (sample->flags & kTransparent) {
        previous.past_ray_kinds |= scene.depends_on_ray_kind(walk.hit);
        if (!pass_through(walk, media, *sample, to_lights, beta)) break;
        continue;
      }
      if (passes_only) break;
      if (!go_on(*sample, walk, here, after, {radiance, beta, to_lights, at_bounce_limit}, {sampler, base})) break;
      previous = vertex_of(here, point, bsdf, *sample);
      media.leave(walk, sample->wi);
      media.scattered_at_surface();
      walk.leave_along(sample->wi);
    }
    return radiance;
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const PathMedia> media_;  ///< of the scene, if it has any
  uint32_t seed_ = 0, pass_ = 0;
  PixelFilter filter_;
  HemisphereGrid grid_{1};
  IrradianceRecords records_;
  std::unique_ptr<DirectEstimator> mixture_;  // null: the default method
  float pixel_size_ = 0.0f, pixel_angle_ = 0.0f;
  uint64_t records_made_ = 0, lookups_ = 0, found_ = 0;
  IntegratorStatistics statistics_;
};

}  // namespace

std::unique_ptr<Integrator> make_irradiance_cache() { return std::make_unique<IrradianceCache>(); }

}  // namespace ajar
