#include "integrators/metropolis.h"

#include <numeric>

#include <tbb/blocked_range2d.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "math/statistics.h"
#include "transport/bidirectional.h"
#include "transport/chain.h"
#include "transport/direct_paths.h"
#include "transport/mutations/bidirectional_mutation.h"
#include "transport/mutations/caustic_perturbation.h"
#include "transport/mutations/lens_perturbation.h"

namespace ajar {

namespace {

constexpr int kChains = 96;
/// Bidirectional samples among which chains start: one for eight pixels, within these bounds.
constexpr uint32_t kFewestSeeds = 1u << 12, kMostSeeds = 1u << 16;
constexpr uint32_t kSeedBatch = 256;
constexpr uint64_t kStepsPerSeed = 24;         ///< steps of chains for each further sample of the brightness
constexpr int kDirectShare = 4;                ///< steps a pixel for each direct sample
constexpr int kTile = 16;
/// Units of random numbers: pixels, seeds and chains must not share any.
constexpr uint32_t kSeedStream = 0x5eed0000u, kChainStream = 0xc4a10000u;

class Metropolis final : public Integrator {
 public:
  Honesty honesty() const override { return Honesty::Consistent; }

  void prepare(std::shared_ptr<const Scene> scene, uint32_t seed) override {
    scene_ = std::move(scene);
    seed_ = seed;
    space_.reset();
    mutations_.clear();
    chains_.clear();
    brightness_ = {};
    seeds_done_ = 0;
    steps_done_ = steps_wanted_ = 0;
    direct_done_ = samples_done_ = 0;
    statistics_ = {};
  }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    film.enable_splats();
    samples_done_ += uint32_t(samples_per_pixel);
    if (!space_) begin(film, stop);
    const uint32_t direct = (samples_done_ + kDirectShare - 1) / kDirectShare - direct_done_;
    if (direct > 0) sample_direct(film, int(direct), stop);
    if (stop.load(std::memory_order_relaxed)) return;
    if (!chains_.empty()) {
      run_chains(film, uint64_t(film.width()) * uint64_t(film.height()) * uint64_t(samples_per_pixel), stop);
      film.end_splats(brightness_.mean() / double(std::max<uint64_t>(1, steps_done_)));
    }
    report();
  }

  IntegratorStatistics statistics() const override { return statistics_; }

 private:
  struct NumberedChain {
    Chain chain;
    Sampler sampler;
    uint64_t steps = 0;
  };

  /// Estimate of the whole film's luminance without direct light, from one bidirectional sample.
  template <class Visit>
  double visit_seed(BidirectionalWalks& walks, uint32_t index, Visit&& visit) const {
    Sampler sampler(Sampler::Kind::Independent, hash_combine(seed_, kSeedStream));
    sampler.start(index, 0);
    double sum = 0.0;
    for (const FoundPath& path : walks.sample(space_->film_at(sampler.get_2d()), sampler)) {
      if (walks.is_direct(path)) continue;
      const double area = path.t > 1 ? space_->film_area() : 1.0;
      const double y = double(luminance(path.contribution)) * double(space_->filter_sum(path.film)) * area;
      if (!(y > 0.0) || !std::isfinite(y)) continue;
      sum += y;
      if (!visit(path, y)) break;
    }
    return sum;
  }

  std::vector<double> sample_seeds(uint32_t count, const std::atomic<bool>& stop) {
    std::vector<double> values(count, 0.0);
    tbb::enumerable_thread_specific<BidirectionalWalks> walks([&] { return BidirectionalWalks(*scene_, space_->film_area()); });
    const uint32_t first = seeds_done_;
    tbb::parallel_for(
        tbb::blocked_range<uint32_t>(0, count, kSeedBatch),
        [&](const tbb::blocked_range<uint32_t>& range) {
          if (stop.load(std::memory_order_relaxed)) return;
          BidirectionalWalks& w = walks.local();
          for (uint32_t i = range.begin(); i != range.end(); ++i) values[i] = visit_seed(w, first + i, [](const FoundPath&, double) { return true; });
        },
        tbb::simple_partitioner());
    for (const BidirectionalWalks& w : walks) statistics_.rays += w.rays();
    if (stop.load(std::memory_order_relaxed)) return {};
    seeds_done_ += count;
    for (double value : values) brightness_.add(value);
    return values;
  }

  void begin(const Film& film, const std::atomic<bool>& stop) {
    space_ = std::make_unique<PathSpace>(*scene_, film.x0(), film.y0(), film.x0() + film.width(), film.y0() + film.height(), true);
    mutations_.clear();
    mutations_.push_back({std::make_unique<BidirectionalMutation>(*space_), 0.4f});
    mutations_.push_back({std::make_unique<LensPerturbation>(*space_), 0.35f});
    mutations_.push_back({std::make_unique<CausticPerturbation>(*space_), 0.25f});
    first_seeds_ = uint32_t(std::clamp<int64_t>(int64_t(film.width()) * film.height() / 8, kFewestSeeds, kMostSeeds));
    const std::vector<double> values = sample_seeds(first_seeds_, stop);
    const double total = std::accumulate(values.begin(), values.end(), 0.0);
    if (values.empty()) {
      space_.reset();
      return;
    }
    if (!(total > 0.0)) return;
    // Starts in proportion to luminance, evenly spaced along the cumulative sum.
    Sampler sampler(Sampler::Kind::Independent, hash_combine(seed_, kSeedStream));
    sampler.start(~0u, 0);
    const double offset = double(sampler.get_1d());
    BidirectionalWalks walks(*scene_, space_->film_area());
    Path path;
    double cumulative = 0.0;
    uint32_t seed = 0;
    for (int c = 0; c < kChains; ++c) {
      const double target = (double(c) + offset) / kChains * total;
      while (seed + 1 < values.size() && cumulative + values[seed] <= target) cumulative += values[seed++];
      double left = double(sampler.get_1d()) * values[seed];
      const FoundPath* chosen = nullptr;
      visit_seed(walks, seed, [&](const FoundPath& found, double y) {
        chosen = &found;
        left -= y;
        return left >= 0.0;
      });
      if (!chosen) continue;
      path.count = walks.copy_path(*chosen, path.vertices.data(), path.edges.data());
      path.film = chosen->film;
      if (!space_->complete(path, 1, path.count - 2)) {
        ++failed_starts_;
        continue;
      }
      chains_.push_back({Chain(*space_, mutations_), Sampler(Sampler::Kind::Independent, hash_combine(seed_, kChainStream))});
      chains_.back().chain.start(path);
      chains_.back().sampler.start(uint32_t(c), 0);
    }
  }

  void sample_direct(Film& film, int samples, const std::atomic<bool>& stop) {
    std::atomic<uint64_t> rays{0};
    const PixelFilter& filter = space_->filter;
    tbb::parallel_for(
        tbb::blocked_range2d<int>(0, (film.height() + kTile - 1) / kTile, 1, 0, (film.width() + kTile - 1) / kTile, 1),
        [&](const tbb::blocked_range2d<int>& tiles) {
          uint64_t counted = 0;
          Sampler sampler(Sampler::Kind::Sobol, seed_);
          for (int y = tiles.rows().begin() * kTile; y < std::min(tiles.rows().end() * kTile, film.height()); ++y) {
            for (int x = tiles.cols().begin() * kTile; x < std::min(tiles.cols().end() * kTile, film.width()); ++x) {
              const int px = film.x0() + x, py = film.y0() + y;
              for (int s = 0; s < samples; ++s) {
                if (stop.load(std::memory_order_relaxed)) return;
                sampler.start(uint32_t(py) * uint32_t(scene_->settings().width) + uint32_t(px), direct_done_ + uint32_t(s));
                SampleAux aux;
                float alpha;
                const Vec2 at = Vec2(float(px) + 0.5f, float(py) + 0.5f) + filter.sample(sampler.get_2d());
                const Color radiance = trace_direct_paths(*scene_, at, sampler, film.wants_aux() ? &aux : nullptr, alpha, counted);
                film.add_sample(px, py, radiance, alpha, &aux);
              }
            }
          }
          rays += counted;
        },
        tbb::simple_partitioner());
    statistics_.rays += rays;
    direct_done_ += uint32_t(samples);
  }

  void run_chains(Film& film, uint64_t steps, const std::atomic<bool>& stop) {
    steps_wanted_ += steps;
    tbb::parallel_for(
        size_t(0), chains_.size(),
        [&](size_t c) {
          NumberedChain& numbered = chains_[c];
          const uint64_t wanted = steps_wanted_ * (c + 1) / chains_.size() - steps_wanted_ * c / chains_.size();
          for (; numbered.steps < wanted; ++numbered.steps) {
            if (stop.load(std::memory_order_relaxed)) return;
            numbered.chain.step(numbered.sampler, [&](const Path& path, double weight) {
              const PathSpace::Place place = space_->place(path.film, numbered.sampler.get_2d());
              film.add_splat(place.x, place.y, path.f * float(weight * double(place.weight) / double(path.target)), c & 1);
            });
          }
        },
        tbb::simple_partitioner());
    steps_done_ = 0;
    for (const NumberedChain& numbered : chains_) steps_done_ += numbered.steps;
    // The brightness is refined from samples that start no chain.
    const uint64_t seeds = first_seeds_ + steps_done_ / kStepsPerSeed;
    if (seeds > seeds_done_) sample_seeds(uint32_t(seeds - seeds_done_), stop);
  }

  void report() {
    IntegratorStatistics s = statistics_;
    s.extra.clear();
    s.paths = steps_done_ + seeds_done_;
    s.extra["mutations"] = double(steps_done_);
    s.extra["chains"] = double(chains_.size());
    s.extra["brightness"] = brightness_.mean();
    s.extra["brightness_relative_error"] = brightness_.mean() > 0.0 ? std::sqrt(brightness_.variance_of_mean()) / brightness_.mean() : 0.0;
    s.extra["failed_starts"] = double(failed_starts_);
    uint64_t rays = 0;
    for (size_t m = 0; m < mutations_.size(); ++m) {
      Chain::Counts sum;
      for (const NumberedChain& numbered : chains_) {
        const Chain::Counts& c = numbered.chain.counts()[m];
        sum.proposed += c.proposed;
        sum.accepted += c.accepted;
        sum.empty += c.empty;
      }
      const std::string name = mutations_[m].mutation->name();
      s.extra["proposed_" + name] = double(sum.proposed);
      s.extra["accepted_" + name] = double(sum.accepted);
      s.extra["empty_" + name] = double(sum.empty);
    }
    for (const NumberedChain& numbered : chains_) rays += numbered.chain.rays();
    s.rays = statistics_.rays + rays - chain_rays_;
    chain_rays_ = rays;
    statistics_ = std::move(s);
  }

  std::shared_ptr<const Scene> scene_;
  uint32_t seed_ = 0;
  std::unique_ptr<PathSpace> space_;
  std::vector<MutationShare> mutations_;
  std::vector<NumberedChain> chains_;
  RunningMoments brightness_;
  uint32_t first_seeds_ = 0, seeds_done_ = 0, direct_done_ = 0, samples_done_ = 0;
  uint64_t steps_done_ = 0, steps_wanted_ = 0, failed_starts_ = 0, chain_rays_ = 0;
  IntegratorStatistics statistics_;
};

}  // namespace

std::unique_ptr<Integrator> make_metropolis() { return std::make_unique<Metropolis>(); }

}  // namespace ajar
