#include "integrators/bdpt.h"

#include <cmath>

#include <tbb/enumerable_thread_specific.h>

#include "film/filter.h"
#include "film/tile_loop.h"
#include "transport/bidirectional/bidirectional.h"
#include "transport/hints/followed_hints.h"
#include "transport/paths/path.h"

namespace ajar {

namespace {

constexpr uint32_t kSplatDimension = 3000;

class Bdpt final : public Integrator {
 public:
  Bias bias() const override { return merging_.active() ? Bias::Consistent : Bias::Unbiased; }
  /// Samples of a pass share its photons.
  GoalSupport goal_support() const override {
    return {.follows = true, .by_passes = merging_.active(), .learns = merging_.active()};
  }

  using Integrator::prepare;
  void prepare(std::shared_ptr<const Scene> scene, const RenderPlan& plan, uint32_t seed) override {
    scene_ = std::move(scene);
    media_ = plan.media ? std::make_unique<const PathMedia>(*scene_) : nullptr;
    seed_ = seed;
    samples_done_ = 0;
    statistics_ = {};
    merging_.prepare(*scene_, media_.get(), plan.merging, seed);
    followed_.clear();
    hints_ = plan.hints;
    space_.reset();
    filter_ = PixelFilter(scene_->settings().filter, scene_->settings().filter_width);
  }

  bool begin_at(uint32_t first) override {
    if (merging_.active() || (hints_ && !hints_->hints.empty())) return false;
    samples_done_ = first;
    return true;
  }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    film.enable_splats();
    if (!space_) begin(film, stop);
    const double light_walks = double(film.width()) * double(film.height());
    tbb::enumerable_thread_specific<BidirectionalWalks> walks([&] {
      BidirectionalWalks w(*scene_, light_walks);
      w.sampled = SampledLights::Both;
      w.leaves_unconnectable = merging_.active();
      w.media = media_.get();
      w.merging = merging_.active() ? &merging_ : nullptr;
      w.guide = space_->guide;
      w.passes = LightPasses(*scene_, film, true);
      return w;
    });
    const auto add_samples = [&](int more) {
      samples_done_ += uint32_t(more);
      for_each_sample(
          film, samples_done_, stop,
          [&] {
            return Tile{Sampler(Sampler::Kind::Sobol, seed_), walks.local()};
          },
          [&](Tile& tile, int px, int py, uint32_t index) { add_sample(film, px, py, index, light_walks, tile); });
    };
    if (!merging_.active()) add_samples(samples_per_pixel);
    // One photon pass for each sample of a pixel, so that images do not depend on the division of a render into
    // iterations.
    for (int i = 0; merging_.active() && i < samples_per_pixel && merging_.begin_pass(samples_done_, stop); ++i)
      add_samples(1);
    for (const BidirectionalWalks& w : walks) {
      statistics_.rays += w.rays();
      statistics_.extra["refused_paths"] += double(w.refused());
    }
    // Each sample also has a walk from a light.
    const double samples = film.sample_counts().mean;
    statistics_.paths = 2 * uint64_t(std::llround(samples * light_walks));
    film.end_splats(samples > 0.0 ? 1.0 / samples : 0.0);
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics s = statistics_;
    add_statistics_of(followed_, s);
    add_statistics_of(media_.get(), s);
    s.hints = followed_.statistics();
    add_statistics_of(merging_, s);
    return s;
  }

 private:
  struct Tile {
    Sampler sampler;
    BidirectionalWalks& walks;
  };

  void begin(const Film& film, const std::atomic<bool>& stop) {
    space_ = std::make_unique<PathSpace>(*scene_, film, media_.get());
    space_->without_unconnectable = merging_.active();
    followed_.begin(hints_, *space_, seed_, stop);
    merging_.follow(space_->guide);
  }

  void add_sample(Film& film, int px, int py, uint32_t index, double light_walks, Tile& tile) const {
    auto& [sampler, walks] = tile;
    const int full_width = scene_->settings().width, full_height = scene_->settings().height;
    sampler.start(uint32_t(py) * uint32_t(full_width) + uint32_t(px), index);
    const Vec2 offset = filter_.sample(sampler.get_2d());
    SampleRecord record;
    SampleAux* const aux = record.begin(film, px, py);
    Color radiance(0.0f);
    const bool separates = walks.passes.any();
    uint32_t splats = 0;
    const uint64_t rays_before = walks.rays();
    // The two halves get equally many splats, whatever the sample counts are.
    const bool odd = (index + uint32_t(px + py)) & 1;
    if (merging_.active()) walks.pass_time = merging_.time();
    for (const FoundPath& path : walks.sample(Vec2(float(px) + 0.5f, float(py) + 0.5f) + offset, sampler, aux)) {
      if (path.t > 1 || path.s == 0) {
        radiance += path.contribution;
        if (separates) walks.passes.add(walks.passes_of(path), path.contribution);
        continue;
      }
      sampler.set_dimension(kSplatDimension + 2 * splats++);
      const Vec2 u = sampler.get_2d();
      const auto column = filter_.place(path.film.x, 0, full_width, u.x),
                 row = filter_.place(path.film.y, 0, full_height, u.y);
      film.add_splat(column.pixel, row.pixel,
                     path.contribution * float(double(column.weight * row.weight) / light_walks), odd,
                     separates ? walks.passes_of(path) : PathPasses());
    }
    const bool added = film.add_sample(px, py, radiance + walks.merged() + walks.glow(), walks.alpha(), aux);
    film.add_rays(px, py, walks.rays() - rays_before);
    if (!added || !separates) return;
    film.add_parts(px, py, walks.passes.parts());
    if (film.wants_direct()) film.add_direct(px, py, walks.passes.parts().direct_paths);
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const PathMedia> media_;  ///< of the scene, if it has any
  uint32_t seed_ = 0, samples_done_ = 0;
  VertexMerging merging_;
  std::shared_ptr<const AttachedHints> hints_;
  FollowedHints followed_;
  std::unique_ptr<PathSpace> space_;  ///< of the paths from which the shares of hints are learned
  PixelFilter filter_;
  IntegratorStatistics statistics_;
};

}  // namespace

std::unique_ptr<Integrator> make_bdpt() { return std::make_unique<Bdpt>(); }

}  // namespace ajar
