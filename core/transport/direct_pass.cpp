#include "transport/direct_pass.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include "transport/direct_paths.h"

namespace ajar {

namespace {

uint64_t add_samples(Film& film, const PathSpace& space, uint32_t seed, uint32_t first, int samples, const VertexMerging* merging, const std::atomic<bool>& stop) {
  constexpr int kTile = 16;
  std::atomic<uint64_t> rays{0};
  tbb::parallel_for(
      tbb::blocked_range2d<int>(0, (film.height() + kTile - 1) / kTile, 1, 0, (film.width() + kTile - 1) / kTile, 1),
      [&](const tbb::blocked_range2d<int>& tiles) {
        uint64_t counted = 0;
        Sampler sampler(Sampler::Kind::Sobol, seed);
        for (int y = tiles.rows().begin() * kTile; y < std::min(tiles.rows().end() * kTile, film.height()); ++y) {
          for (int x = tiles.cols().begin() * kTile; x < std::min(tiles.cols().end() * kTile, film.width()); ++x) {
            if (stop.load(std::memory_order_relaxed)) return;
            const int px = film.x0() + x, py = film.y0() + y;
            for (int s = 0; s < samples; ++s) {
              sampler.start(uint32_t(py) * uint32_t(space.scene.settings().width) + uint32_t(px), first + uint32_t(s));
              SampleAux aux;
              float alpha;
              const Vec2 at = Vec2(float(px) + 0.5f, float(py) + 0.5f) + space.filter.sample(sampler.get_2d());
              const Color radiance = trace_direct_paths(space.scene, at, sampler, film.wants_aux() ? &aux : nullptr, alpha, counted, merging);
              film.add_sample(px, py, radiance, alpha, &aux);
            }
          }
        }
        rays += counted;
      },
      tbb::simple_partitioner());
  return rays;
}

}  // namespace

uint64_t add_direct_samples(Film& film, const PathSpace& space, uint32_t seed, uint32_t first, int samples, VertexMerging& merging,
                            const std::atomic<bool>& stop) {
  if (!merging.active()) return add_samples(film, space, seed, first, samples, nullptr, stop);
  uint64_t rays = 0;
  for (uint32_t i = first; i < first + uint32_t(samples); ++i) {
    if (!merging.begin_pass(i, stop)) break;
    rays += add_samples(film, space, seed, i, 1, &merging, stop);
  }
  return rays;
}

}  // namespace ajar
