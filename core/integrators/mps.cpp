#include "integrators/mps.h"

#include <cmath>

#include "integrators/gather_passes.h"
#include "integrators/learned.h"
#include "transport/chain_ensemble.h"
#include "transport/mutations/standard_mutations.h"
#include "transport/path_photons.h"

namespace ajar {

namespace {

constexpr uint32_t kStarts = 4;               ///< of all chains, a pass
constexpr uint32_t kStepsPerSeed = 4;         ///< for each bidirectional sample that chains may start from

/// Photons a chain has left in this pass; power still to be scaled.
struct Deposit {
  struct Entry {
    Photon photon;
    Vec3 eye_normal;
    Vec3 shading_normal;
    bool lambert;
  };
  std::vector<Entry> entries[2];   // global, caustic

  void add(const PathPhoton& found, float weight) {
    std::vector<Entry>& list = entries[found.place == ArrivalMap::kSeen ? 1 : 0];
    // Repeated states and paths that differ elsewhere only: power goes to the photon that is there already, a state or two ago.
    for (size_t back = 1; back <= 4 && back <= list.size(); ++back) {
      Photon& known = list[list.size() - back].photon;
      if (known.point.position != found.photon.point.position || known.packed_direction != found.photon.packed_direction) continue;
      known.flux_over_cosine += found.photon.flux_over_cosine * weight;
      return;
    }
    const Bsdf& bsdf = found.vertex->shading.bsdf;
    list.push_back({found.photon, found.eye_normal, bsdf.n, found.place == ArrivalMap::kGathered && is_plain_lambert(bsdf)});
    list.back().photon.flux_over_cosine *= weight;
  }
};

class Mps final : public Integrator {
 public:
  /// No goals: powers of photons follow from where lookups lie, which must be those of all pixels alike.
  Honesty honesty() const override { return Honesty::Consistent; }

  void prepare(std::shared_ptr<const Scene> scene, uint32_t seed) override {
    scene_ = std::move(scene);
    seed_ = seed;
    space_.reset();
    mutations_.clear();
    ensemble_ = {};
    arrivals_ = {};
    passes_.prepare(*scene_, seed, &arrivals_);
  }

  std::vector<LearnedPart> begin_with(const Learned& learned) override { return passes_.begin_with(learned); }
  void hand_on(Learned& learned) override { passes_.hand_on(learned); }

  void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) override {
    if (!space_) begin(film);
    for (int i = 0; i < samples_per_pixel && !stop.load(std::memory_order_relaxed); ++i) {
      if (!scene_->lights().empty() && !scene_->instances().empty()) make_maps(film, stop);
      if (!stop.load(std::memory_order_relaxed)) passes_.render(film, stop);
    }
  }

  IntegratorStatistics statistics() const override {
    IntegratorStatistics s;
    s.rays = ensemble_.rays();
    passes_.add_statistics(s);
    ensemble_.add_statistics(s.extra);
    s.hints = ensemble_.hint_statistics(hint_reports_, 0.0);  // shares of what the chains carry: direct light is not known here
    s.extra["arrival_bytes"] = double(arrivals_.memory_bytes());
    return s;
  }

  PhotonPoints photons(uint64_t most) const override { return passes_.photons(most); }

 private:
  void begin(const Film& film) {
    space_ = std::make_unique<PathSpace>(*scene_, film.x0(), film.y0(), film.x0() + film.width(), film.y0() + film.height(), true);
    hint_reports_.clear();
    hints_ = Hints::attach(*scene_, hint_reports_);
    mutations_ = standard_mutations(*space_, hints_);
    ensemble_ = {};
    if (!hints_.empty()) ensemble_.watch(hints_);
  }

  uint32_t seeds() const { return std::max(256u, passes_.photon_count() / (kStarts * kStepsPerSeed)); }

  void make_maps(const Film& film, const std::atomic<bool>& stop) {
    const uint32_t pass = passes_.pass(), steps = passes_.photon_count() / kStarts * kStarts;
    if (pass == 0) passes_.scout(film, stop);
    // Chains start over several times a pass.
    std::vector<Deposit> deposits;
    for (uint32_t i = 0; i < kStarts; ++i) {
      if (!(pass == 0 && i == 0 ? ensemble_.begin(*space_, mutations_, seed_, seeds(), stop) : ensemble_.restart(seeds(), stop))) return;
      const size_t first = deposits.size();
      deposits.resize(first + ensemble_.size());
      const double scale = ensemble_.start_brightness() / double(steps);
      ensemble_.run(steps / kStarts, stop, [&](size_t chain, const Path& path, double weight, Sampler&) {
        PathPhoton found[2 * kMaxPathVertices];
        const int count = photons_of(*space_, path, found);
        for (int k = 0; k < count; ++k) deposits[first + chain].add(found[k], float(scale * weight));
      });
      if (stop.load(std::memory_order_relaxed)) return;
    }
    std::vector<Photon> photons[2];
    std::vector<const Deposit::Entry*> entries[2];
    for (int kind = 0; kind < 2; ++kind) {
      for (const Deposit& deposit : deposits)
        for (const Deposit::Entry& entry : deposit.entries[kind]) {
          entries[kind].push_back(&entry);
          photons[kind].push_back(entry.photon);
        }
    }
    passes_.choose_radii(photons[0], photons[1]);
    for (int kind = 0; kind < 2; ++kind) {
      const auto place = kind == 1 ? ArrivalMap::kSeen : ArrivalMap::kGathered;
      const float radius = kind == 1 ? passes_.caustic_radius() : passes_.global_radius();
      tbb::parallel_for(tbb::blocked_range<size_t>(0, photons[kind].size(), 512), [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i != range.end(); ++i) {
          const Deposit::Entry& entry = *entries[kind][i];
          photons[kind][i].flux_over_cosine *= float(arrivals_.inverse_density(place, entry.photon.point.position, entry.eye_normal, radius));
        }
      });
    }
    std::vector<IrradianceSite> sites;
    const uint32_t stride = passes_.site_stride(uint32_t(entries[0].size()));
    for (size_t i = 0; i < entries[0].size(); i += stride)
      if (entries[0][i]->lambert) sites.push_back({entries[0][i]->photon.point, entries[0][i]->shading_normal});
    for (std::vector<Photon>& list : photons) std::erase_if(list, [](const Photon& photon) { return is_black(photon.flux_over_cosine); });
    passes_.build_maps(std::move(photons[0]), std::move(photons[1]));
    passes_.add_sites(std::move(sites));
  }

  std::shared_ptr<const Scene> scene_;
  uint32_t seed_ = 0;
  std::unique_ptr<PathSpace> space_;
  Hints hints_;
  std::vector<HintReport> hint_reports_;
  std::vector<MutationShare> mutations_;
  ChainEnsemble ensemble_;
  ArrivalMap arrivals_;
  GatherPasses passes_;
};

}  // namespace

std::unique_ptr<Integrator> make_mps() { return std::make_unique<Mps>(); }

}  // namespace ajar
