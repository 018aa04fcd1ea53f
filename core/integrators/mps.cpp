#include "integrators/mps.h"

#include <cmath>

#include "integrators/gather_passes.h"
#include "integrators/learned.h"
#include "transport/chains/chain_ensemble.h"
#include "transport/chains/mutations/standard_mutations.h"
#include "transport/hints/followed_hints.h"
#include "transport/photons/path_photons.h"

namespace ajar {

namespace {

constexpr uint32_t kSeeds = 4096;  ///< bidirectional samples from which chains can start
/// Successive states of a chain are correlated. This number of them counts as one independent photon in the choice of
/// radii and in the weights of the two kinds of photons.
constexpr uint32_t kStatesAlike = 20;

/// The times of the chain states whose photons a pass uses: an interval around the time of the pass that becomes shorter
/// from pass to pass. If nothing moves, it contains all states.
class TimeWindow {
 public:
  TimeWindow(const Scene& scene, float time, uint32_t pass) : time_(time) {
    if (!scene.moves()) return;
    half_width_ = 0.5f * float(radius2_factor(pass));
    constexpr int kSteps = 1024;
    int inside = 0;
    for (int i = 0; i < kSteps; ++i) inside += contains(scene.camera().time_of((float(i) + 0.5f) / float(kSteps)));
    share_ = double(std::max(inside, 1)) / kSteps;
  }
  bool contains(float time) const { return std::abs(time - time_) <= half_width_; }
  /// Probability that a path has a time in the window.
  double share() const { return share_; }

 private:
  float time_, half_width_ = 1.0f;
  double share_ = 1.0;
};

/// Photons that a chain has stored in this pass, with flux before scaling.
struct Deposit {
  struct Entry {
    Photon photon;
    Vec3 shading_normal;
    bool lambert;
  };
  std::vector<Entry> entries[2];  // global, caustic
  uint64_t refused = 0;

  void add(const PathPhoton& found, float weight) {
    std::vector<Entry>& list = entries[found.place == ArrivalMap::kSeen ? 1 : 0];
    // For repeated states, and for paths that differ elsewhere only, the flux is added to the photon that was stored
    // one or two states before.
    for (size_t back = 1; back <= 4 && back <= list.size(); ++back) {
      Photon& known = list[list.size() - back].photon;
      if (known.point.position != found.photon.point.position ||
          known.packed_direction != found.photon.packed_direction)
        continue;
      known.flux_over_cosine += found.photon.flux_over_cosine * weight;
      return;
    }
    const Bsdf& bsdf = found.vertex->shading.bsdf;
    list.push_back({found.photon, bsdf.n, found.place == ArrivalMap::kGathered && is_plain_lambert(bsdf)});
    list.back().photon.flux_over_cosine *= weight;
  }
};

class Mps final : public Integrator {
 public:
  /// Goals are not supported: the flux of photons follows from the density of lookups, which must be equal for all
  /// pixels.
  /// Where objects move, the importance of a place is averaged over the shutter interval, but photons of one time use it.
  Bias bias() const override { return scene_ && scene_->moves() ? Bias::Biased : Bias::Consistent; }

  using Integrator::prepare;
  void prepare(std::shared_ptr<const Scene> scene, const RenderPlan& plan, uint32_t seed) override {
    scene_ = std::move(scene);
    media_ = plan.media ? std::make_unique<const PathMedia>(*scene_) : nullptr;
    seed_ = seed;
    space_.reset();
    mutations_.clear();
    ensemble_ = {};
    arrivals_ = {};
    plan_ = plan.photons;
    hints_ = plan.hints;
    photon_rays_ = refused_photons_ = 0;
    passes_.prepare(*scene_, media_.get(), seed, &arrivals_);
  }

  std::vector<LearnedPart> begin_with(const Learned& learned) override { return passes_.begin_with(learned); }
  void hand_on(Learned& learned) override { passes_.hand_on(learned); }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    if (!space_) begin(film, stop);
    for (int i = 0; i < samples_per_pixel && !stop.load(std::memory_order_relaxed); ++i) {
      if (!scene_->lights().empty() && !scene_->instances().empty()) make_maps(film, stop);
      if (!stop.load(std::memory_order_relaxed)) passes_.render(film, stop);
    }
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics s;
    s.rays = ensemble_.rays() + photon_rays_;
    add_statistics_of(followed_, s);
    add_statistics_of(media_.get(), s);
    passes_.add_statistics(s);
    ensemble_.add_statistics(s.extra);
    // Shares of the light of chains, because direct light is not known here.
    s.hints = ensemble_.hint_statistics(followed_.reports(), 0.0);
    s.extra["refused_photons"] = double(refused_photons_);
    s.extra["arrival_bytes"] = double(arrivals_.memory_bytes());
    return s;
  }

  PhotonPoints photons(uint64_t max_count) const override { return passes_.photons(max_count); }

 private:
  void begin(const Film& film, const std::atomic<bool>& stop) {
    space_ = std::make_unique<PathSpace>(*scene_, film, media_.get());
    // Gathering goes below surfaces. Chains reflect light diffusely there, and leave no photons nearer to the light.
    space_->has_subsurface = false;
    followed_.begin(hints_, *space_, seed_, stop);
    mutations_ = standard_mutations(*space_, followed_.hints(), followed_.mutation_use());
    ensemble_ = {};
    if (!followed_.hints().empty()) ensemble_.watch(followed_.hints());
  }

  /// The photons that the states of the chains of a pass leave, for each chain.
  std::vector<Deposit> run_chains(const TimeWindow& window, const std::atomic<bool>& stop) {
    const uint32_t steps = passes_.photon_count();
    std::vector<Deposit> deposits(ensemble_.size());
    const double scale = ensemble_.brightness() / (double(steps) * window.share());
    ensemble_.run(steps, stop, [&](size_t chain, const Path& path, double weight, Sampler&) {
      if (!window.contains(path.time())) return;
      PathPhoton found[2 * kMaxPathVertices];
      const int count = photons_of(*space_, path, passes_.shortest_logged(), found, deposits[chain].refused);
      for (int k = 0; k < count; ++k) deposits[chain].add(found[k], float(scale * weight));
    });
    return deposits;
  }

  /// Chooses the radii by plain photons and by photons of chains, which are then thrown away, because they do not know the
  /// shortest gather rays. Then logs lookups.
  void begin_passes(const Film& film, const PhotonBatch& plain, const TimeWindow& window,
                    const std::atomic<bool>& stop) {
    if (!ensemble_.begin(*space_, mutations_, seed_, kSeeds, stop)) return;
    std::vector<Photon> independent[2] = {plain.global, plain.caustic};
    const std::vector<Deposit> deposits = run_chains(window, stop);
    for (int kind = 0; kind < 2; ++kind) {
      size_t number = 0;
      for (const Deposit& deposit : deposits)
        for (const Deposit::Entry& entry : deposit.entries[kind])
          if (number++ % kStatesAlike == 0) independent[kind].push_back(entry.photon);
    }
    passes_.choose_radii(independent[0], independent[1]);
    passes_.log_lookups(film, stop);
  }

  /// Builds the maps from photons of chains and plain photons. Each is weighted by the share of its kind in the density
  /// of both at its position (balance heuristic).
  void make_maps(const Film& film, const std::atomic<bool>& stop) {
    PhotonEmission emission;
    emission.plan = plan_;
    emission.seed = seed_;
    emission.pass = passes_.pass();
    emission.time = passes_.time();
    emission.count = passes_.photon_count();
    emission.site_stride = 0;
    PhotonBatch plain = trace_photons(*scene_, media_.get(), emission, stop);
    photon_rays_ += plain.rays;
    const TimeWindow window(*scene_, emission.time, emission.pass);
    if (emission.pass == 0)
      begin_passes(film, plain, window, stop);
    else
      passes_.choose_radii({}, {});
    const std::vector<Deposit> deposits = run_chains(window, stop);
    if (stop.load(std::memory_order_relaxed)) return;

    for (const Deposit& deposit : deposits) refused_photons_ += deposit.refused;
    std::vector<Photon> photons[2];
    std::vector<const Deposit::Entry*> entries[2];
    for (int kind = 0; kind < 2; ++kind) {
      for (const Deposit& deposit : deposits)
        for (const Deposit::Entry& entry : deposit.entries[kind]) {
          entries[kind].push_back(&entry);
          photons[kind].push_back(entry.photon);
        }
      const std::vector<Photon>& more = kind == 1 ? plain.caustic : plain.global;
      photons[kind].insert(photons[kind].end(), more.begin(), more.end());
    }
    // Photons per watt: `per_lookup` times W for chains, and `plain_density` for plain photons.
    const double watts = double(luminance(Color(Vec3(plain.emitted[0], plain.emitted[1], plain.emitted[2]))));
    const double plain_density = watts > 0.0 ? double(emission.count) / watts : 0.0;
    const double per_lookup = ensemble_.brightness() > 0.0
                                  ? double(emission.count) * window.share() / kStatesAlike / ensemble_.brightness()
                                  : 0.0;
    std::vector<IrradianceSite> sites;
    const uint32_t stride = passes_.site_stride(uint32_t(entries[0].size()));
    for (size_t i = 0; i < entries[0].size(); i += stride)
      if (entries[0][i]->lambert) sites.push_back({entries[0][i]->photon.point, entries[0][i]->shading_normal});
    const auto weigh = [&](ArrivalMap::Place place, PhotonMap& map, float radius) {
      map.weigh([&](const PhotonMap::Weighable& photon) {
        if (photon.is_plain_alone()) return 1.0;
        const ArrivalMap::Factors factors = arrivals_.factors(place, photon, radius, per_lookup, plain_density);
        return photon.has(Photon::kOfChain) ? factors.of_chain : factors.plain;
      });
    };
    passes_.build_maps(std::move(photons[0]), std::move(photons[1]), weigh);
    passes_.add_sites(std::move(sites));
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const PathMedia> media_;  ///< of the scene, if it has any
  uint32_t seed_ = 0;
  std::shared_ptr<const AttachedHints> hints_;
  FollowedHints followed_;
  std::unique_ptr<PathSpace> space_;
  std::vector<MutationShare> mutations_;
  ChainEnsemble ensemble_;
  ArrivalMap arrivals_;
  PhotonPlan plan_;
  GatherPasses passes_;
  uint64_t photon_rays_ = 0, refused_photons_ = 0;
};

}  // namespace

std::unique_ptr<Integrator> make_mps() { return std::make_unique<Mps>(); }

}  // namespace ajar
