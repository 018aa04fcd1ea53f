#include "integrators/photon_mapping.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <tbb/blocked_range2d.h>
#include <tbb/combinable.h>
#include <tbb/parallel_for.h>

#include "film/filter.h"
#include "transport/photon_gather.h"
#include "transport/photon_tracer.h"

namespace ajar {

namespace {

constexpr int kTile = 16;
constexpr uint32_t kSitesOnly = ~0u;   // number of the emission that only places sites for the first pass

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class PhotonMapping final : public Integrator {
 public:
  Honesty honesty() const override { return Honesty::Consistent; }

  void prepare(std::shared_ptr<const Scene> scene, uint32_t seed) override {
    *this = PhotonMapping();
    scene_ = std::move(scene);
    seed_ = seed;
    const RenderSettings& settings = scene_->settings();
    filter_ = PixelFilter(settings.filter, settings.filter_width);
    plan_ = plan_photons(*scene_);
    gather_.rays = std::max(1, settings.gather_rays);
  }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    // Every sample of a pixel is a pass of its own, so that the picture does not depend on how a render is cut into iterations.
    for (int i = 0; i < samples_per_pixel && !stop.load(std::memory_order_relaxed); ++i) {
      auto start = std::chrono::steady_clock::now();
      make_maps(stop);
      map_seconds_ += seconds_since(start);
      if (stop.load(std::memory_order_relaxed)) return;
      start = std::chrono::steady_clock::now();
      render(film, stop);
      gather_seconds_ += seconds_since(start);
      ++pass_;
    }
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics s = statistics_;
    s.extra["passes"] = double(pass_);
    s.extra["photons"] = double(maps_.global.size());
    s.extra["caustic_photons"] = double(maps_.caustic.size());
    s.extra["irradiance_sites"] = double(maps_.sites.size());
    s.extra["photon_bytes"] = double(maps_.global.memory_bytes() + maps_.caustic.memory_bytes() + maps_.sites.memory_bytes());
    s.extra["photon_radius"] = double(maps_.global_radius);
    s.extra["caustic_radius"] = double(maps_.caustic_radius);
    s.extra["map_seconds"] = map_seconds_;
    s.extra["gather_seconds"] = gather_seconds_;
    s.extra["gather_rays_from_sites"] = gathered_ > 0 ? double(from_sites_) / double(gathered_) : 0.0;
    return s;
  }

 private:
  void make_maps(const std::atomic<bool>& stop) {
    if (!plan_.global && !plan_.caustic) return;
    // Of the full frame: a region of it uses the same maps.
    const uint32_t pixels = uint32_t(scene_->settings().width) * uint32_t(scene_->settings().height);
    PhotonEmission emission;
    emission.plan = plan_;
    emission.seed = seed_;
    emission.pass = pass_;
    const int wanted = scene_->settings().photons;
    emission.count = wanted > 0 ? uint32_t(wanted) : std::clamp(pixels / 2, 20000u, 500000u);
    // Sites pay only where several gather rays use each.
    const double lookups = double(pixels) * gather_.rays / 8.0;
    emission.site_stride = uint32_t(std::clamp(4.0 * double(emission.count) / lookups, 4.0, 1e9));
    if (pass_ == 0) {
      PhotonEmission pilot = emission;
      pilot.pass = kSitesOnly;
      PhotonBatch batch = trace_photons(*scene_, pilot, stop);
      statistics_.rays += batch.rays;
      sites_ = std::move(batch.sites);
    }
    PhotonBatch batch = trace_photons(*scene_, emission, stop);
    if (stop.load(std::memory_order_relaxed)) return;
    statistics_.rays += batch.rays;
    maps_.global.build(std::move(batch.global));
    maps_.caustic.build(std::move(batch.caustic));
    if (pass_ == 0) choose_radii();
    maps_.has_global = !maps_.global.empty();
    maps_.has_caustic = !maps_.caustic.empty();
    const float shrink = float(std::sqrt(radius2_factor(pass_)));
    maps_.global_radius = first_global_radius_ * shrink;
    maps_.caustic_radius = first_caustic_radius_ * shrink;
    maps_.sites.build(sites_, maps_.global, {gather_.neighbours, maps_.global_radius});
    sites_ = std::move(batch.sites);
  }

  /// The radii of the first pass: the median reach of the neighbours sought, over where the picture will look the maps up. Photons
  /// crowd where light is, which need not be where it is looked for.
  void choose_radii() {
    const RenderSettings& settings = scene_->settings();
    const float most = 0.05f * scene_->radius();
    first_global_radius_ = first_caustic_radius_ = settings.photon_radius;
    if (settings.photon_radius > 0.0f) return;
    constexpr int kProbes = 24;   // per axis of the film
    std::vector<float> global, caustic;
    PhotonGatherer gatherer(*scene_, maps_, gather_, hash_combine(seed_, 0x70726f62U));
    for (int i = 0; i < kProbes * kProbes; ++i) {
      gatherer.start(uint32_t(i), 0);
      const Vec2 on_film((float(i % kProbes) + 0.5f) / kProbes * float(settings.width), (float(i / kProbes) + 0.5f) / kProbes * float(settings.height));
      SurfacePoint seen, gathered;
      if (!gatherer.probe(scene_->camera().generate_ray(on_film, Vec2(0.5f), 0.0f), seen, gathered)) continue;
      global.push_back(maps_.global.reach(gathered, gather_.neighbours, most));
      const float reach = maps_.caustic.reach(seen, gather_.neighbours, most);
      if (reach < most) caustic.push_back(reach);
    }
    first_global_radius_ = median(global, most);
    first_caustic_radius_ = std::min(first_global_radius_, median(caustic, most));
  }

  static float median(std::vector<float>& values, float otherwise) {
    if (values.empty()) return otherwise;
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
  }

  void render(Film& film, const std::atomic<bool>& stop) {
    const int width = film.width(), height = film.height();
    tbb::combinable<IntegratorStatistics> counters;
    tbb::combinable<std::pair<uint64_t, uint64_t>> gathers;
    tbb::parallel_for(
        tbb::blocked_range2d<int>(0, (height + kTile - 1) / kTile, 1, 0, (width + kTile - 1) / kTile, 1),
        [&](const tbb::blocked_range2d<int>& tiles) {
          PhotonGatherer gatherer(*scene_, maps_, gather_, seed_);
          for (int ty = tiles.rows().begin(); ty < tiles.rows().end(); ++ty)
            for (int tx = tiles.cols().begin(); tx < tiles.cols().end(); ++tx) render_tile(film, gatherer, tx * kTile, ty * kTile, stop);
          counters.local().rays += gatherer.rays();
          gathers.local().first += gatherer.gathered();
          gathers.local().second += gatherer.from_sites();
        },
        tbb::simple_partitioner());
    counters.combine_each([&](const IntegratorStatistics& s) { statistics_.rays += s.rays; });
    gathers.combine_each([&](const auto& g) { gathered_ += g.first, from_sites_ += g.second; });
    statistics_.paths += uint64_t(width) * uint64_t(height);
  }

  void render_tile(Film& film, PhotonGatherer& gatherer, int tile_x, int tile_y, const std::atomic<bool>& stop) {
    const int full_width = scene_->settings().width;
    for (int y = tile_y; y < std::min(tile_y + kTile, film.height()); ++y) {
      for (int x = tile_x; x < std::min(tile_x + kTile, film.width()); ++x) {
        if (stop.load(std::memory_order_relaxed)) return;
        const int px = film.x0() + x, py = film.y0() + y;
        Sampler& sampler = gatherer.start(uint32_t(py) * uint32_t(full_width) + uint32_t(px), pass_);
        const Vec2 offset = filter_.sample(sampler.get_2d());
        const Vec2 on_film(float(px) + 0.5f + offset.x, float(py) + 0.5f + offset.y);
        const Vec2 u_lens = scene_->camera().has_lens() ? sampler.get_2d() : Vec2(0.5f);
        const Ray ray = scene_->camera().generate_ray(on_film, u_lens, 0.0f);
        SampleAux aux;
        float alpha = 1.0f;
        const Color radiance = gatherer.trace(ray, film.wants_aux() ? &aux : nullptr, alpha);
        film.add_sample(px, py, radiance, alpha, &aux);
      }
    }
  }

  std::shared_ptr<const Scene> scene_;
  uint32_t seed_ = 0, pass_ = 0;
  PixelFilter filter_;
  PhotonPlan plan_;
  GatherSettings gather_;
  PhotonMaps maps_;
  std::vector<IrradianceSite> sites_;    // left by the pass before, so that they do not depend on the photons of this one
  float first_global_radius_ = 0.0f, first_caustic_radius_ = 0.0f;
  double map_seconds_ = 0.0, gather_seconds_ = 0.0;
  uint64_t gathered_ = 0, from_sites_ = 0;
  IntegratorStatistics statistics_;
};

}  // namespace

std::unique_ptr<Integrator> make_photon_mapping() { return std::make_unique<PhotonMapping>(); }

}  // namespace ajar
