#include "integrators/metropolis.h"

#include "transport/bidirectional/direct_pass.h"
#include "transport/chains/chain_ensemble.h"
#include "transport/chains/mutations/standard_mutations.h"
#include "transport/chains/pilot_importance.h"
#include "transport/hints/followed_hints.h"

namespace ajar {

namespace {

/// Bidirectional samples from which chains start: one for eight pixels, within these bounds.
constexpr uint32_t kMinSeeds = 1u << 12, kMaxSeeds = 1u << 16;

class Metropolis final : public Integrator {
 public:
  Bias bias() const override { return bias_with(direct_, Bias::Consistent); }

  using Integrator::prepare;
  void prepare(std::shared_ptr<const Scene> scene, const RenderPlan& plan, uint32_t seed) override {
    scene_ = std::move(scene);
    media_ = plan.media ? std::make_unique<const PathMedia>(*scene_) : nullptr;
    seed_ = seed;
    direct_.prepare(*scene_, media_.get(), plan.merging, seed);
    space_.reset();
    mutations_.clear();
    chains_ = {};
    pilot_ = {};
    followed_.clear();
    hints_ = plan.hints;
  }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    film.enable_splats();
    passes_ = LightPasses(*scene_, film);
    if (!space_) begin(film, stop);
    if (!space_) return;
    direct_.add(film, *space_, samples_per_pixel, stop);
    if (stop.load(std::memory_order_relaxed)) return;
    if (!chains_.empty()) {
      run_chains(film, uint64_t(film.width()) * uint64_t(film.height()) * uint64_t(samples_per_pixel), stop);
      film.end_splats(chains_.brightness() / double(std::max<uint64_t>(1, chains_.steps())));
    }
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics s;
    s.rays = pilot_.rays + direct_.rays() + chains_.rays();
    add_statistics_of(direct_, s);
    add_statistics_of(followed_, s);
    add_statistics_of(media_.get(), s);
    s.paths = chains_.steps() + chains_.seeds();
    chains_.add_statistics(s.extra);
    s.hints = chains_.hint_statistics(followed_.reports(), pilot_.direct_light);
    return s;
  }

 private:
  void begin(const Film& film, const std::atomic<bool>& stop) {
    space_ = std::make_unique<PathSpace>(*scene_, film, media_.get());
    space_->without_unconnectable = direct_.merging().active();
    followed_.begin(hints_, *space_, seed_, stop);
    direct_.merging().follow(space_->guide);
    mutations_ = standard_mutations(*space_, followed_.hints(), followed_.mutation_use());
    const auto seeds = uint32_t(std::clamp<int64_t>(int64_t(film.width()) * film.height() / 8, kMinSeeds, kMaxSeeds));
    chains_ = {};
    if (!followed_.hints().empty()) chains_.watch(followed_.hints());
    pilot_ = look_ahead(*space_, seed_, seeds / 4, stop);
    space_->importance = pilot_.importance;
    if (!chains_.begin(*space_, mutations_, seed_, seeds, stop)) space_.reset();
  }

  void run_chains(Film& film, uint64_t steps, const std::atomic<bool>& stop) {
    chains_.run(steps, stop, [&](size_t chain, const Path& path, double weight, Sampler& sampler) {
      const PathSpace::Place place = space_->place(path.film, sampler.get_2d());
      film.add_splat(place.x, place.y, path.splat(weight * double(place.weight)), chain & 1, passes_.of(*scene_, path));
    });
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
  ChainEnsemble chains_;
  Pilot pilot_;
};

}  // namespace

std::unique_ptr<Integrator> make_metropolis() { return std::make_unique<Metropolis>(); }

}  // namespace ajar
