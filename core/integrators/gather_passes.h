// What integrators that fill photon maps do alike: a pass for each sample of every pixel, its maps built with radii
// that shrink from pass to pass, and the film rendered from them.
#pragma once

#include "film/filter.h"
#include "integrators/integrator.h"
#include "transport/bidirectional/further_samples.h"
#include "transport/photons/photon_gather.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

class GatherPasses {
 public:
  /// `arrivals`: where lookups of all passes are to be noted.
  void prepare(const Scene& scene, uint32_t seed, ArrivalMap* arrivals = nullptr);
  uint32_t pass() const { return pass_; }
  /// As an integrator's: the guide of gather rays.
  std::vector<LearnedPart> begin_with(const Learned& learned);
  void hand_on(Learned& learned);
  /// What the settings ask for, else photons_of_a_pass.
  uint32_t photon_count() const;
  /// Stored photons for each irradiance site, so that sites pay: several gather rays use each.
  uint32_t site_stride(uint32_t photons) const;
  /// Sites are used by the *next* pass, whose photons they do not know.
  void add_sites(std::vector<IrradianceSite> sites) { sites_ = std::move(sites); }
  /// Radii of this pass; those of the first are chosen by where photons lie, whatever their power.
  void choose_radii(const std::vector<Photon>& global, const std::vector<Photon>& caustic);
  void build_maps(std::vector<Photon> global, std::vector<Photon> caustic);
  /// Before the first pass: note where passes will look maps up.
  void scout(const Film& film, const std::atomic<bool>& stop);
  /// One sample of the average pixel, by the film's goals if any are set; ends the pass.
  void render(Film& film, const std::atomic<bool>& stop);

  float global_radius() const { return maps_.global_radius; }
  float caustic_radius() const { return maps_.caustic_radius; }
  void add_statistics(IntegratorStatistics& statistics) const;
  /// Of the last pass, at most so many; those of chains alone where there are chains.
  PhotonPoints photons(uint64_t most) const;

 private:
  void choose_first_radii();
  void learn(float past_share);
  template <class Visit>
  void for_each_pixel(const Film& film, uint32_t seed, uint32_t sample, bool only_arrivals,
                      const std::atomic<bool>& stop, Visit&& visit);

  const Scene* scene_ = nullptr;
  uint32_t seed_ = 0, pass_ = 0, first_training_ = 1;
  PixelFilter filter_;
  GatherSettings gather_;
  PhotonMaps maps_;
  std::vector<IrradianceSite> sites_;
  float first_global_radius_ = 0.0f, first_caustic_radius_ = 0.0f;
  ArrivalMap* arrivals_ = nullptr;
  FurtherSamples further_;
  GuideTree guide_;
  std::vector<std::vector<GuideSample>> guide_samples_;  ///< of the tiles, since the guide has learned last
  uint64_t rays_ = 0, seen_rays_ = 0, lookup_pilot_rays_ = 0, paths_ = 0, gathered_ = 0, from_sites_ = 0;
};

}  // namespace ajar
