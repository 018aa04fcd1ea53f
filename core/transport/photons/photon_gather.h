// Radiance from photon maps as the eye sees it: specular chains followed, direct light sampled, caustics read from the
// caustic map, the rest gathered. Used by every integrator that fills maps, whatever filled them. Gather rays follow a
// guide that learns from those of earlier passes (guided_bsdf.h) [after Jensen 1995, "Importance driven path tracing
// using the photon map"].
//
// Paths by the events of LobeSplit (D rough, S sharp, from light to eye), each counted once:
//   L S* E            emission met, and light sampled at sharp lobes, along the chain from the eye
//   L D S* E          light sampled at the first rough vertex, weighted against gather rays that meet the light
//   L S+ D S* E       caustic map
//   L (D|S)* D S* D S* E   gather rays through sharp chains to the next rough vertex, and the global map there
#pragma once

#include "sampling/sampler.h"
#include "transport/direct/direct_light.h"
#include "transport/direct/lobe_split.h"
#include "transport/guiding/guided_bsdf.h"
#include "transport/paths/eye_walk.h"
#include "transport/photons/arrival_map.h"
#include "transport/photons/photon_map.h"

namespace ajar {

struct PhotonMaps {
  PhotonMap global, caustic;
  IrradianceMap sites;
  float global_radius = 0.0f, caustic_radius = 0.0f;
  bool has_global = false, has_caustic = false;
};

struct GatherSettings {
  int rays = 8;                ///< gathered at the first rough surface of a sample
  int neighbours = 60;         ///< in density estimates
  int gather_neighbours = 10;  ///< in estimates at the ends of gather rays that no irradiance site answers
};

/// One thread's work. Radiance along camera rays; counts what it traces.
class PhotonGatherer {
 public:
  PhotonGatherer(const Scene& scene, const PhotonMaps& maps, const GatherSettings& settings, uint32_t seed)
      : scene_(scene),
        maps_(maps),
        settings_(settings),
        sampler_(Sampler::Kind::Sobol, seed),
        gather_sampler_(Sampler::Kind::Sobol, hash_combine(seed, 0x67617468U)) {}

  /// Sample `index` of pixel number `pixel`; `camera` has been called with this sampler's first dimensions.
  Sampler& start(uint32_t pixel, uint32_t index) {
    pixel_ = pixel;
    index_ = index;
    sampler_.start(pixel, index);
    return sampler_;
  }
  /// `seen`: of it, light seen directly or by way of delta lobes alone, which the returned radiance leaves out.
  Color trace(Ray ray, SampleAux* aux, float& alpha, Color& seen);
  /// From now on, note where maps are looked up. `only`: and sample no direct light.
  void log_arrivals(ArrivalLog* log, bool only) {
    log_ = log;
    log_only_ = only;
  }
  /// From now on, draw the first gather rays by what `tree` knows, too, and write what one in `stride` found into
  /// `samples`; either may be null.
  void guide(const GuideTree* tree, std::vector<GuideSample>* samples, uint32_t stride) {
    guide_ = tree;
    guide_samples_ = samples;
    guide_stride_ = stride;
  }
  /// Where a camera ray and one gather ray from there would look up the maps. False when they lead nowhere.
  bool probe(const Ray& ray, SurfacePoint& seen, SurfacePoint& gathered);

  /// Whether the last ray traced came to delta lobes first.
  bool polished() const { return polished_; }
  uint64_t rays() const { return rays_; }
  uint64_t gathered() const { return gathered_; }
  uint64_t from_sites() const { return from_sites_; }

 private:
  Color direct_light(const ShadingPoint& point, const Bsdf& bsdf, Sampler& sampler, uint32_t dimension);
  /// Light scattered towards the eye by the rough lobes of a surface: direct, caustic and gathered. `throughput`: to
  /// the eye.
  Color reflected(const ShadingPoint& point, const Bsdf& rough, Color throughput, int rays, int depth, Sampler& sampler,
                  uint32_t dimension);
  /// Light along a gather ray: emission of what it meets first, and what maps tell about the rough surface it comes to.
  /// `pdf_bsdf`: of the sample's direction, by which it is weighed against light sampling. `distance`: to what it meets
  /// first.
  Color incoming(const ShadingPoint& from, const BsdfSample& sample, float pdf_bsdf, Color throughput, int depth,
                 Sampler& sampler, uint32_t dimension, float& distance);
  /// Follow `ray` and sharp lobes to a rough surface.
  bool find_rough(Ray ray, ShadingPoint& point, SurfaceShading& shading);
  void log_arrival(int place, const ShadingPoint& point, Color throughput);
  Color from_map(const ShadingPoint& point, const Bsdf& rough);

  const Scene& scene_;
  const PhotonMaps& maps_;
  const GatherSettings& settings_;
  MisDirectLight direct_;
  Sampler sampler_, gather_sampler_;
  uint32_t pixel_ = 0, index_ = 0;
  ArrivalLog* log_ = nullptr;
  bool log_only_ = false, polished_ = false;
  const GuideTree* guide_ = nullptr;
  std::vector<GuideSample>* guide_samples_ = nullptr;
  uint32_t guide_stride_ = 1;
  uint64_t rays_ = 0, gathered_ = 0, from_sites_ = 0;
};

}  // namespace ajar
