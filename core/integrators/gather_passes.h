// The common part of integrators that fill photon maps: one pass for each sample of every pixel, maps whose radii
// shrink from pass to pass, and the film rendered from them.
#pragma once

#include <functional>

#include "film/filter.h"
#include "integrators/integrator.h"
#include "transport/bidirectional/further_samples.h"
#include "transport/photons/photon_gather.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

class GatherPasses {
 public:
  /// `arrivals`: receives the lookups of all passes if not null.
  void prepare(const Scene& scene, const PathMedia* media, uint32_t seed, ArrivalMap* arrivals = nullptr);
  uint32_t pass() const { return pass_; }
  /// As the functions of Integrator: for the guide of gather rays.
  std::vector<LearnedPart> begin_with(const Learned& learned);
  void hand_on(Learned& learned);
  /// The number in the settings, or photons_of_a_pass if it is 0.
  uint32_t photon_count() const;
  /// Number of stored photons per irradiance site, chosen so that several gather rays use each site.
  uint32_t site_stride(uint32_t photons) const;
  /// Sites are used by the *next* pass, because they must not depend on the photons of its maps.
  void add_sites(std::vector<IrradianceSite> sites) { sites_ = std::move(sites); }
  /// Sets the radii of this pass. Those of the first pass follow from the positions of photons, without their flux.
  void choose_radii(const std::vector<Photon>& global, const std::vector<Photon>& caustic);
  /// `weigh`: called for each map and its radius before it is used, or empty.
  using Weigh = std::function<void(ArrivalMap::Place, PhotonMap&, float radius)>;
  void build_maps(std::vector<Photon> global, std::vector<Photon> caustic, const Weigh& weigh = {});
  /// Called before the first pass, with its radii: logs where passes will look up the maps.
  void log_lookups(const Film& film, const std::atomic<bool>& stop);
  /// Renders one sample of the average pixel, by the film's goals if any are set, and ends the pass.
  void render(Film& film, const std::atomic<bool>& stop);

  /// Time of the photons and of the samples of this pass.
  float time() const { return time_of_pass(*scene_, seed_, pass_); }
  /// The shortest gather rays whose lookups are logged. The same in all passes.
  float shortest_logged() const { return gather_.shortest_logged; }
  void add_statistics(IntegratorStatistics& statistics) const;
  /// At most `max_count` photons of the last pass; only those of chains if there are chains.
  PhotonPoints photons(uint64_t max_count) const;

 private:
  void choose_first_radii();
  void learn(float past_share);
  template <class Visit>
  void for_each_pixel(const Film& film, uint32_t seed, uint32_t sample, bool only_arrivals,
                      const std::atomic<bool>& stop, Visit&& visit);

  const Scene* scene_ = nullptr;
  const PathMedia* media_ = nullptr;
  uint32_t seed_ = 0, pass_ = 0, first_training_ = 1;
  PixelFilter filter_;
  GatherSettings gather_;
  PhotonMaps maps_;
  std::vector<IrradianceSite> sites_;
  float first_global_radius_ = 0.0f, first_caustic_radius_ = 0.0f;
  ArrivalMap* arrivals_ = nullptr;
  FurtherSamples further_;
  RareLight beyond_;  ///< light beyond the shadow terminator, of gather rays
  GuideTree guide_{GuideTree::kWidthPriorOfGatherRays};
  std::vector<std::vector<GuideSample>> guide_samples_;  ///< for each tile, since the last training step of the guide
  uint64_t rays_ = 0, seen_rays_ = 0, lookup_pilot_rays_ = 0, paths_ = 0, gathered_ = 0, from_sites_ = 0;
};

}  // namespace ajar
