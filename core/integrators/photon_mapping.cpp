#include "integrators/photon_mapping.h"

#include "integrators/gather_passes.h"
#include "integrators/learned.h"
#include "transport/hints/followed_hints.h"
#include "transport/paths/path.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

namespace {

constexpr uint32_t kSitesOnly = ~0u;  // pass number of the emission that only places sites for the first pass

class PhotonMapping final : public Integrator {
 public:
  Bias bias() const override { return Bias::Consistent; }
  GoalSupport goal_support() const override { return {.follows = true, .by_passes = true, .learns = true}; }

  using Integrator::prepare;
  void prepare(std::shared_ptr<const Scene> scene, const RenderPlan& plan, uint32_t seed) override {
    scene_ = std::move(scene);
    media_ = plan.media ? std::make_unique<const PathMedia>(*scene_) : nullptr;
    seed_ = seed;
    photon_rays_ = 0;
    plan_ = plan.photons;
    passes_.prepare(*scene_, media_.get(), seed);
    followed_.clear();
    hints_ = plan.hints;
    space_.reset();
  }

  std::vector<LearnedPart> begin_with(const Learned& learned) override { return passes_.begin_with(learned); }
  void hand_on(Learned& learned) override { passes_.hand_on(learned); }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    // Every sample of a pixel is a separate pass, so that the image does not depend on the division of a render into
    // iterations.
    if (!space_ && (plan_.global || plan_.caustic)) begin(film, stop);
    for (int i = 0; i < samples_per_pixel && !stop.load(std::memory_order_relaxed); ++i) {
      make_maps(stop);
      if (!stop.load(std::memory_order_relaxed)) passes_.render(film, stop);
    }
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics s;
    s.rays = photon_rays_;
    add_statistics_of(followed_, s);
    add_statistics_of(media_.get(), s);
    s.hints = followed_.statistics();
    s.extra["photon_rays"] = double(photon_rays_);
    passes_.add_statistics(s);
    return s;
  }

  PhotonPoints photons(uint64_t max_count) const override { return passes_.photons(max_count); }

 private:
  void begin(const Film& film, const std::atomic<bool>& stop) {
    space_ = std::make_unique<PathSpace>(*scene_, film, media_.get());
    followed_.begin(hints_, *space_, seed_, stop);
  }

  void make_maps(const std::atomic<bool>& stop) {
    if (!plan_.global && !plan_.caustic) return;
    PhotonEmission emission;
    emission.plan = plan_;
    emission.seed = seed_;
    emission.guide = followed_.guide();
    emission.count = passes_.photon_count();
    emission.site_stride = passes_.site_stride(emission.count);
    if (passes_.pass() == 0) {
      emission.pass = kSitesOnly;
      emission.time = passes_.time();
      passes_.add_sites(trace(emission, stop).sites);
    }
    emission.pass = passes_.pass();
    emission.time = passes_.time();
    PhotonBatch batch = trace(emission, stop);
    if (stop.load(std::memory_order_relaxed)) return;
    passes_.choose_radii(batch.global, batch.caustic);
    passes_.build_maps(std::move(batch.global), std::move(batch.caustic));
    passes_.add_sites(std::move(batch.sites));
  }

  PhotonBatch trace(const PhotonEmission& emission, const std::atomic<bool>& stop) {
    PhotonBatch batch = trace_photons(*scene_, media_.get(), emission, stop);
    photon_rays_ += batch.rays;
    return batch;
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const PathMedia> media_;  ///< of the scene, if it has any
  uint32_t seed_ = 0;
  PhotonPlan plan_;
  std::shared_ptr<const AttachedHints> hints_;
  FollowedHints followed_;
  std::unique_ptr<PathSpace> space_;  ///< of the paths from which the shares of hints are learned
  GatherPasses passes_;
  uint64_t photon_rays_ = 0;
};

}  // namespace

std::unique_ptr<Integrator> make_photon_mapping() { return std::make_unique<PhotonMapping>(); }

}  // namespace ajar
