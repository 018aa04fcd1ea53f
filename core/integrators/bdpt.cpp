#include "integrators/bdpt.h"

#include <tbb/blocked_range2d.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "film/filter.h"
#include "transport/bidirectional.h"

namespace ajar {

namespace {

constexpr int kTile = 16;
constexpr uint32_t kSplatDimension = 3000;

class Bdpt final : public Integrator {
 public:
  Honesty honesty() const override { return Honesty::Unbiased; }

  void prepare(std::shared_ptr<const Scene> scene, uint32_t seed) override {
    scene_ = std::move(scene);
    seed_ = seed;
    samples_done_ = 0;
    statistics_ = {};
    filter_ = PixelFilter(scene_->settings().filter, scene_->settings().filter_width);
  }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    film.enable_splats();
    const double light_walks = double(film.width()) * double(film.height());
    tbb::enumerable_thread_specific<BidirectionalWalks> walks([&] { return BidirectionalWalks(*scene_, light_walks); });
    tbb::parallel_for(
        tbb::blocked_range2d<int>(0, (film.height() + kTile - 1) / kTile, 1, 0, (film.width() + kTile - 1) / kTile, 1),
        [&](const tbb::blocked_range2d<int>& tiles) {
          for (int ty = tiles.rows().begin(); ty < tiles.rows().end(); ++ty)
            for (int tx = tiles.cols().begin(); tx < tiles.cols().end(); ++tx)
              render_tile(film, tx * kTile, ty * kTile, samples_per_pixel, light_walks, stop, walks.local());
        },
        tbb::simple_partitioner());
    for (const BidirectionalWalks& w : walks) statistics_.rays += w.rays();
    samples_done_ += uint32_t(samples_per_pixel);
    statistics_.paths += 2 * uint64_t(light_walks) * uint64_t(samples_per_pixel);
    film.end_splats(1.0 / double(samples_done_));
  }

  IntegratorStatistics statistics() const override { return statistics_; }

 private:
  void render_tile(Film& film, int tile_x, int tile_y, int samples_per_pixel, double light_walks, const std::atomic<bool>& stop,
                   BidirectionalWalks& walks) {
    Sampler sampler(Sampler::Kind::Sobol, seed_);
    const int full_width = scene_->settings().width, full_height = scene_->settings().height;
    for (int y = tile_y; y < std::min(tile_y + kTile, film.height()); ++y) {
      for (int x = tile_x; x < std::min(tile_x + kTile, film.width()); ++x) {
        const int px = film.x0() + x, py = film.y0() + y;
        for (int s = 0; s < samples_per_pixel; ++s) {
          if (stop.load(std::memory_order_relaxed)) return;
          const uint32_t index = samples_done_ + uint32_t(s);
          sampler.start(uint32_t(py) * uint32_t(full_width) + uint32_t(px), index);
          const Vec2 offset = filter_.sample(sampler.get_2d());
          SampleAux aux;
          Color radiance(0.0f);
          uint32_t splats = 0;
          for (const FoundPath& path : walks.sample(Vec2(float(px) + 0.5f, float(py) + 0.5f) + offset, sampler, film.wants_aux() ? &aux : nullptr)) {
            if (path.t > 1 || path.s == 0) {
              radiance += path.contribution;
              continue;
            }
            sampler.set_dimension(kSplatDimension + 2 * splats++);
            const Vec2 u = sampler.get_2d();
            const auto column = filter_.place(path.film.x, 0, full_width, u.x), row = filter_.place(path.film.y, 0, full_height, u.y);
            film.add_splat(column.pixel, row.pixel, path.contribution * float(double(column.weight * row.weight) / light_walks), index & 1);
          }
          film.add_sample(px, py, radiance, walks.alpha(), &aux);
        }
      }
    }
  }

  std::shared_ptr<const Scene> scene_;
  uint32_t seed_ = 0, samples_done_ = 0;
  PixelFilter filter_;
  IntegratorStatistics statistics_;
};

}  // namespace

std::unique_ptr<Integrator> make_bdpt() { return std::make_unique<Bdpt>(); }

}  // namespace ajar
