#include "integrators/erpt.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "transport/bidirectional/direct_pass.h"
#include "transport/bidirectional/path_seeds.h"
#include "transport/chains/chain.h"
#include "transport/chains/mutations/bidirectional_mutation.h"
#include "transport/chains/mutations/caustic_perturbation.h"
#include "transport/chains/mutations/lens_perturbation.h"
#include "transport/hints/followed_hints.h"
#include "transport/paths/film_luminance.h"

namespace ajar {

namespace {

constexpr int kChainSteps = 100;     ///< of every chain
constexpr int kStepsPerSample = 25;  ///< on average: a quarter of the samples start a chain
constexpr int kMaxChains = 64;       ///< of one sample; above this number, each chain deposits more
/// Chain steps per pixel before the importance of the film is learned. It is learned again whenever the number has
/// doubled.
constexpr int kFirstSteps = 1;
/// Samples for the quantum: one for eight pixels, within these bounds. More are drawn while they find nothing.
constexpr uint32_t kMinPilot = 1u << 8, kMaxPilot = 1u << 14, kPilotLimit = 1u << 17;
constexpr uint32_t kBatch = 64;
/// Streams of random numbers: pixels, pilot, samples and chains must not share any.
constexpr uint32_t kPilotStream = 0x9a1e7000u, kSampleStream = 0x5eed0001u, kChainStream = 0xc4a10001u;

class EnergyRedistribution final : public Integrator {
 public:
  Bias bias() const override { return bias_with(direct_, Bias::Unbiased); }

  using Integrator::prepare;
  void prepare(std::shared_ptr<const Scene> scene, const RenderPlan& plan, uint32_t seed) override {
    workers_.reset();
    space_.reset();
    luminance_.reset();
    scene_ = std::move(scene);
    media_ = plan.media ? std::make_unique<const PathMedia>(*scene_) : nullptr;
    seed_ = seed;
    direct_.prepare(*scene_, media_.get(), plan.merging, seed);
    followed_.clear();
    hints_ = plan.hints;
    samples_done_ = steps_wanted_ = 0;
  }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    film.enable_splats();
    passes_ = LightPasses(*scene_, film);
    if (!space_) begin(film, stop);
    direct_.add(film, *space_, samples_per_pixel, stop);
    steps_wanted_ += uint64_t(film.width()) * uint64_t(film.height()) * uint64_t(samples_per_pixel);
    redistribute(film, uint32_t((steps_wanted_ + kStepsPerSample - 1) / kStepsPerSample), stop);
    if (samples_done_ > 0) film.end_splats(first_quantum_ / double(samples_done_));
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics s;
    s.rays = direct_.rays();
    add_statistics_of(followed_, s);
    add_statistics_of(media_.get(), s);
    s.hints = followed_.statistics();
    add_statistics_of(direct_, s);
    Tally sum;
    if (!workers_) return s;
    for (const Worker& worker : *workers_) {
      sum.steps += worker.tally.steps;
      sum.chains += worker.tally.chains;
      sum.max_energy = std::max(sum.max_energy, worker.tally.max_energy);
      s.rays += worker.seeds.rays() + worker.chain.rays();
      s.extra["failed_starts"] += double(worker.seeds.failed());
      s.extra["refused_paths"] += double(worker.seeds.refused());
    }
    s.paths = samples_done_ + sum.steps;
    s.extra["mutations"] = double(sum.steps);
    s.extra["chains"] = double(sum.chains);
    s.extra["quantum"] = quantum_;
    s.extra["max_energy_of_a_sample"] = sum.max_energy;
    for (size_t m = 0; m < mutations_.size(); ++m) {
      const std::string name = mutations_[m].mutation->name();
      for (const Worker& worker : *workers_) {
        s.extra["proposed_" + name] += double(worker.chain.counts()[m].proposed);
        s.extra["accepted_" + name] += double(worker.chain.counts()[m].accepted);
      }
    }
    return s;
  }

 private:
  struct Tally {
    uint64_t steps = 0, chains = 0;
    double max_energy = 0.0;
  };
  struct Worker {
    PathSeeds seeds;
    Chain chain;
    Path start;
    Tally tally;
  };
  using Workers = tbb::enumerable_thread_specific<Worker>;

  void begin(const Film& film, const std::atomic<bool>& stop) {
    space_ = std::make_unique<PathSpace>(*scene_, film, media_.get());
    space_->without_unconnectable = direct_.merging().active();
    followed_.begin(hints_, *space_, seed_, stop);
    direct_.merging().follow(space_->guide);
    mutations_.clear();
    mutations_.push_back({std::make_unique<LensPerturbation>(*space_), 0.6f});
    mutations_.push_back({std::make_unique<CausticPerturbation>(*space_), 0.4f});
    workers_ = std::make_unique<Workers>([this] { return Worker{PathSeeds(*space_), Chain(mutations_), {}, {}}; });
    luminance_ = std::make_unique<FilmLuminance>(space_->film_min, space_->film_max,
                                                 shown_exposure(scene_->settings()));
    next_learning_ = (uint64_t(film.width()) * uint64_t(film.height()) * kFirstSteps + kStepsPerSample - 1) /
                     kStepsPerSample;
    find_quantum(uint32_t(std::clamp<int64_t>(int64_t(film.width()) * film.height() / 8, kMinPilot, kMaxPilot)), stop);
  }

  /// The mean energy of a sample over its number of steps. Any positive number gives a correct image, so a pilot
  /// without light only costs time.
  void find_quantum(uint32_t pilot, const std::atomic<bool>& stop) {
    quantum_ = 0.0;
    std::vector<double> energies;
    while (!(quantum_ > 0.0) && energies.size() < kPilotLimit && !stop.load(std::memory_order_relaxed)) {
      const uint32_t first = uint32_t(energies.size()), count = first > 0 ? first : pilot;
      energies.resize(first + count);
      tbb::parallel_for(
          tbb::blocked_range<uint32_t>(first, first + count, kBatch),
          [&](const tbb::blocked_range<uint32_t>& range) {
            PathSeeds& seeds = workers_->local().seeds;
            Sampler sampler(Sampler::Kind::Sobol, hash_combine(seed_, kPilotStream));
            for (uint32_t i = range.begin(); i != range.end(); ++i) {
              sampler.start(0, i);
              energies[i] = seeds.sample(sampler);
            }
          },
          tbb::simple_partitioner());
      double sum = 0.0;
      for (double energy : energies) sum += energy;
      quantum_ = sum / (double(energies.size()) * kStepsPerSample);
    }
    if (!(quantum_ > 0.0) || !std::isfinite(quantum_)) quantum_ = 1.0;
    first_quantum_ = quantum_;
  }

  /// Later samples depend on earlier ones, which do not change: given the earlier samples, the expectation of each
  /// sample is the image.
  void learn() {
    next_learning_ *= 2;
    const double films = double(samples_done_) / first_quantum_;
    space_->importance = luminance_->importance(films);
    const double quantum = luminance_->flux(space_->importance) / (films * kStepsPerSample);
    if (quantum > 0.0 && std::isfinite(quantum)) quantum_ = quantum;
  }

  void redistribute(Film& film, uint32_t samples_wanted, const std::atomic<bool>& stop) {
    while (samples_done_ < samples_wanted && !stop.load(std::memory_order_relaxed)) {
      if (samples_done_ >= next_learning_) learn();
      redistribute_alike(film, uint32_t(std::min<uint64_t>(samples_wanted, next_learning_)), stop);
    }
  }

  void redistribute_alike(Film& film, uint32_t samples_wanted, const std::atomic<bool>& stop) {
    std::atomic<uint32_t> finished{0};
    tbb::parallel_for(
        tbb::blocked_range<uint32_t>(samples_done_, samples_wanted, kBatch),
        [&](const tbb::blocked_range<uint32_t>& range) {
          Worker& worker = workers_->local();
          Sampler sampler(Sampler::Kind::Sobol, hash_combine(seed_, kSampleStream));
          for (uint32_t i = range.begin(); i != range.end(); ++i) {
            if (stop.load(std::memory_order_relaxed)) return;
            sampler.start(0, i);
            const double energy = worker.seeds.sample(sampler);
            luminance_->add_sample(worker.seeds.film(), worker.seeds.left_out());
            spread(film, worker, energy, i);
            finished.fetch_add(1, std::memory_order_relaxed);
          }
        },
        tbb::simple_partitioner());
    samples_done_ += finished;
  }

  /// Runs chains from sample i, whose paths have this sum of energies. The unit of deposits is the first quantum.
  void spread(Film& film, Worker& worker, double energy, uint32_t i) {
    Sampler sampler(Sampler::Kind::Independent, hash_combine(seed_, kChainStream));
    sampler.start(i, 0);
    const double wanted = energy / (quantum_ * kChainSteps);
    const int chains = int(std::min(std::floor(wanted + double(sampler.get_1d())), double(kMaxChains)));
    const double deposit = (chains == kMaxChains && wanted > kMaxChains ? wanted / kMaxChains : 1.0) * quantum_ /
                           first_quantum_;
    const double offset = double(sampler.get_1d());
    worker.tally.max_energy = std::max(worker.tally.max_energy, energy);
    for (int c = 0; c < chains; ++c) {
      if (!worker.seeds.take((double(c) + offset) / chains, worker.start)) continue;
      worker.chain.start(worker.start);
      ++worker.tally.chains;
      for (int step = 0; step < kChainSteps; ++step) {
        worker.chain.step(sampler, [&](const Path& path, double weight) {
          const PathSpace::Place place = space_->place(path.film, sampler.get_2d());
          film.add_splat(place.x, place.y, path.splat(deposit * weight * double(place.weight)), i & 1,
                         passes_.of(*scene_, path));
          luminance_->add_flux(path.film, deposit * weight * path.energy() / path.target);
        });
      }
      worker.tally.steps += kChainSteps;
    }
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const PathMedia> media_;  ///< of the scene, if it has any
  uint32_t seed_ = 0;
  DirectPass direct_;
  LightPasses passes_;
  std::shared_ptr<const AttachedHints> hints_;
  FollowedHints followed_;
  std::unique_ptr<PathSpace> space_;
  std::vector<MutationShare> mutations_;
  std::unique_ptr<Workers> workers_;
  std::unique_ptr<FilmLuminance> luminance_;    ///< of all samples so far; the unit of flux is the first quantum
  uint64_t next_learning_ = 0;                  ///< number of samples at the next update
  double quantum_ = 1.0, first_quantum_ = 1.0;  ///< energy that a step deposits, in luminance times importance
  uint32_t samples_done_ = 0;
  uint64_t steps_wanted_ = 0;
};

}  // namespace

std::unique_ptr<Integrator> make_erpt() { return std::make_unique<EnergyRedistribution>(); }

}  // namespace ajar
