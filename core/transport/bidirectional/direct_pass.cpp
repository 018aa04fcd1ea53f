#include "transport/bidirectional/direct_pass.h"

#include <algorithm>
#include <bit>

#include <tbb/blocked_range2d.h>
#include <tbb/combinable.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "transport/bidirectional/bidirectional.h"
#include "transport/bidirectional/direct_paths.h"

namespace ajar {

namespace {
constexpr int kTile = 16;
/// Most of the light and of its noise comes from chains, so further samples add at most 15% of the rays.
constexpr FurtherSamples::Limits kFurther{1, 0.15};
}  // namespace

void DirectPass::prepare(const Scene& scene, const PathMedia* media, bool merges, uint32_t seed) {
  seed_ = seed;
  wanted_ = done_ = 0;
  rays_ = further_rays_ = 0;
  merging_.prepare(scene, media, merges, seed);
  eye_only_.prepare(scene, seed);
  beyond_.prepare(scene, seed);
}

void DirectPass::add(Film& film, const PathSpace& space, int steps, const std::atomic<bool>& stop) {
  if (done_ == 0) further_.prepare(space.scene, film, space.filter, seed_, kFurther);
  wanted_ += uint32_t(steps);
  const uint32_t end = (wanted_ + kShare - 1) / kShare;
  while (done_ < end) {
    // All samples up to the next update use the same k, unless each sample has its own photons.
    const uint32_t next = merging_.active() ? done_ + 1 : std::min(end, std::bit_ceil(done_ + 1));
    if (merging_.active() && !merging_.begin_pass(done_, stop)) break;
    add_samples(film, space, done_, next, stop);
    done_ = next;
    if (stop.load(std::memory_order_relaxed)) break;
    further_.learn(done_, rays_, further_rays_);
    if (eye_only_.active()) eye_only_.learn(done_, double(film.width()) * double(film.height()), rays_ + further_rays_);
    if (beyond_.active()) beyond_.learn(done_, rays_ + further_rays_);
  }
  done_ = end;
}

void DirectPass::add_samples(Film& film, const PathSpace& space, uint32_t first, uint32_t end,
                             const std::atomic<bool>& stop) {
  const VertexMerging* merging = merging_.active() ? &merging_ : nullptr;
  struct Rays {
    uint64_t own = 0, further = 0;
  };
  tbb::combinable<Rays> counted;
  // Walks of all lengths find the light that media emit.
  const bool glows = space.media && space.media->any_emission();
  tbb::enumerable_thread_specific<BidirectionalWalks> walks([&] {
    BidirectionalWalks walk(space.scene, 1.0);
    walk.media = space.media;
    walk.passes = LightPasses(space.scene, film);
    return walk;
  });
  tbb::enumerable_thread_specific<EyeOnlyLight::Walker> eye_only(
      [&] { return EyeOnlyLight::Walker(eye_only_, space, LightPasses(space.scene, film)); });
  tbb::enumerable_thread_specific<LightBeyond::Walker> beyond(
      [&] { return LightBeyond::Walker(beyond_, space, LightPasses(space.scene, film)); });
  tbb::parallel_for(
      tbb::blocked_range2d<int>(0, (film.height() + kTile - 1) / kTile, 1, 0, (film.width() + kTile - 1) / kTile, 1),
      [&](const tbb::blocked_range2d<int>& tiles) {
        Rays& rays = counted.local();
        Sampler sampler(Sampler::Kind::Sobol, seed_);
        LightPasses passes(space.scene, film);
        LightPasses* const wanted = passes.any() ? &passes : nullptr;
        for (int y = tiles.rows().begin() * kTile; y < std::min(tiles.rows().end() * kTile, film.height()); ++y) {
          for (int x = tiles.cols().begin() * kTile; x < std::min(tiles.cols().end() * kTile, film.width()); ++x) {
            if (stop.load(std::memory_order_relaxed)) return;
            const int px = film.x0() + x, py = film.y0() + y;
            for (uint32_t s = first; s < end; ++s) {
              const uint32_t pixel = uint32_t(py) * uint32_t(space.scene.settings().width) + uint32_t(px);
              sampler.start(pixel, s);
              SampleRecord record;
              SampleAux* const aux = record.begin(film, px, py);
              const Vec2 at = Vec2(float(px) + 0.5f, float(py) + 0.5f) + space.filter.sample(sampler.get_2d());
              if (wanted) passes.begin();
              DirectSample sample = trace_direct_paths(space.path_scene(), at, sampler, aux, rays.own, merging, wanted);
              if (further_.active() && !wanted)
                sample.radiance = further_.mean_with(sample.radiance, sample.polished, luminance(sample.merged), px, py,
                                                     [&](Vec2 further_at, Sampler& further) {
                                                       return trace_direct_paths(space.path_scene(), further_at,
                                                                                 further, nullptr, rays.further,
                                                                                 nullptr, nullptr)
                                                           .radiance;
                                                     });
              if (glows) {
                BidirectionalWalks& walk = walks.local();
                if (merging) walk.pass_time = merging->time();
                const uint64_t before = walk.rays();
                sampler.set_dimension(2);
                sample.radiance += walk.sample_glow(at, sampler);
                if (wanted) passes.add(walk.passes.parts());
                rays.own += walk.rays() - before;
              }
              const std::optional<float> time = merging ? std::optional(merging->time()) : std::nullopt;
              if (eye_only_.active()) sample.radiance += eye_only.local().sample(at, time, sampler, pixel, s, wanted);
              if (beyond_.active())
                sample.radiance += beyond.local().sample(at, time, sampler, pixel, s, sample.radiance + sample.merged,
                                                         wanted);
              if (film.add_sample(px, py, sample.radiance + sample.merged, sample.alpha, aux) && wanted)
                film.add_parts(px, py, passes.parts());
            }
          }
        }
      },
      tbb::simple_partitioner());
  for (const EyeOnlyLight::Walker& walker : eye_only) eye_only_.count(walker);
  for (const LightBeyond::Walker& walker : beyond) beyond_.count(walker);
  counted.combine_each([&](const Rays& rays) { rays_ += rays.own, further_rays_ += rays.further; });
}

}  // namespace ajar
