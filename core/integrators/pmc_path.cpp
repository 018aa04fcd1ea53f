#include "integrators/pmc_path.h"

#include <algorithm>

#include "integrators/learned.h"
#include "transport/bidirectional/direct_pass.h"
#include "transport/chains/path_population.h"

namespace ajar {

namespace {

/// Members of both populations together: one for sixteen pixels, within these bounds. A generation takes about one step
/// per pixel.
constexpr int64_t kMinMembers = 64, kMaxMembers = 10000, kPixelsPerMember = 16, kMaxSteps = 40;
constexpr uint32_t kStepsPerSample = 24;  ///< chain steps of members for each bidirectional sample
constexpr uint32_t kFirstSamples = 4;     ///< factor of the number of samples in the first generation
constexpr uint32_t kLearnGenerations = 4;
constexpr double kRamp = 8.0;  ///< generations until they have full weight: the first ones have few samples

class PopulationPaths final : public Integrator {
 public:
  Bias bias() const override { return bias_with(direct_, Bias::Unbiased); }

  using Integrator::prepare;
  void prepare(std::shared_ptr<const Scene> scene, const RenderPlan& plan, uint32_t seed) override {
    for (auto& population : populations_) population.reset();
    scene_ = std::move(scene);
    media_ = plan.media ? std::make_unique<const PathMedia>(*scene_) : nullptr;
    seed_ = seed;
    direct_.prepare(*scene_, media_.get(), plan.merging, seed);
    hints_ = plan.hints;
    generations_ = 0;
    total_emphasis_ = 0.0;
    steps_wanted_ = 0;
    past_.reset();
    learned_.reset();
  }

  std::vector<LearnedPart> begin_with(const Learned& learned) override {
    past_ = learned.population;
    return {{"shares of mutations, importance of the film", past_ ? "" : "the frame before has not learned enough"}};
  }
  void hand_on(Learned& learned) override { learned.population = learned_; }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    film.enable_splats();
    PathSpace space(*scene_, film, media_.get());
    space.without_unconnectable = direct_.merging().active();
    if (!populations_[0]) begin(film, space, stop);
    direct_.add(film, space, samples_per_pixel, stop);
    steps_wanted_ += uint64_t(film.width()) * uint64_t(film.height()) * uint64_t(samples_per_pixel);
    while (populations_[0]->steps() + populations_[1]->steps() < steps_wanted_ &&
           !stop.load(std::memory_order_relaxed)) {
      if (generations_ == kLearnGenerations) exchange();
      const double emphasis = std::min(1.0, double(generations_ + 1) / kRamp);
      for (auto& population : populations_)
        total_emphasis_ += 0.5 * emphasis * population->run_generation(film, emphasis, stop);
      ++generations_;
    }
    if (total_emphasis_ > 0.0)
      film.end_splats(populations_[0]->splat_unit() / (2.0 * double(size_.steps) * total_emphasis_));
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics s;
    s.rays = direct_.rays();
    add_statistics_of(followed_, s);
    add_statistics_of(media_.get(), s);
    add_statistics_of(direct_, s);
    if (!populations_[0]) return s;
    for (const auto& population : populations_) {
      population->add_statistics(s.extra);
      s.rays += population->rays();
      s.paths += population->steps() + population->samples();
    }
    HintAccount account;
    for (const auto& population : populations_) population->add_hint_account(account);
    s.hints = account.statistics(followed_.reports(), 0.5 / (double(size_.steps) * std::max(1u, generations_)),
                                 0.5 * (populations_[0]->left_out() + populations_[1]->left_out()));
    s.extra["bytes_per_member"] = s.extra["members"] > 0.0 ? s.extra["population_bytes"] / s.extra["members"] : 0.0;
    return s;
  }

 private:
  void begin(const Film& film, PathSpace& space, const std::atomic<bool>& stop) {
    followed_.begin(hints_, space, seed_, stop);
    direct_.merging().follow(space.guide);
    const int64_t pixels = int64_t(film.width()) * film.height();
    const int64_t members = std::clamp(pixels / kPixelsPerMember, kMinMembers, kMaxMembers) / 2;
    size_.members = uint32_t(members);
    size_.steps = uint32_t(std::clamp<int64_t>(pixels / (2 * members), 1, kMaxSteps));
    size_.samples = std::max(1u, size_.members * size_.steps / kStepsPerSample);
    size_.first_samples = kFirstSamples * size_.samples;
    for (uint32_t i = 0; i < 2; ++i) {
      populations_[i] = std::make_unique<PathPopulation>(space, size_, seed_, i, followed_);
      if (past_) populations_[i]->begin_with(*past_);
    }
  }

  /// Each population continues with what the other one has learned. Only once: later, the past of the other would
  /// depend on this one.
  void exchange() {
    learned_ = std::make_shared<const PathPopulation::Learned>(populations_[0]->learned());
    populations_[0]->set_learned(populations_[1]->learned());
    populations_[1]->set_learned(*learned_);
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const PathMedia> media_;  ///< of the scene, if it has any
  uint32_t seed_ = 0;
  DirectPass direct_;
  std::shared_ptr<const AttachedHints> hints_;
  FollowedHints followed_;
  PathPopulation::Size size_{};
  std::unique_ptr<PathPopulation> populations_[2];
  uint32_t generations_ = 0;
  std::shared_ptr<const PathPopulation::Learned> past_, learned_;  ///< of an earlier frame; of this frame, for the next
  double total_emphasis_ = 0.0;
  uint64_t steps_wanted_ = 0;
};

}  // namespace

std::unique_ptr<Integrator> make_pmc_path() { return std::make_unique<PopulationPaths>(); }

}  // namespace ajar
