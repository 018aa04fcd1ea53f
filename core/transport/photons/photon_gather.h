// Radiance from photon maps along camera rays. Sharp chains are followed, direct light is sampled, caustics come from
// the caustic map, and all other light is gathered. All integrators that fill photon maps use it. Gather rays follow a
// guide that learns from the gather rays of earlier passes (guided_bsdf.h) [after Jensen 1995, "Importance driven path
// tracing using the photon map"].
//
// Paths by the events of LobeSplit (D rough, S sharp, from light to eye). Each path is counted once:
//   L S* E                 emission that is hit, and light sampled at sharp lobes, along the chain from the eye
//   L D S* E               light sampled at the first rough vertex, combined by MIS with gather rays that hit the light
//   L S+ D S* E            caustic map
//   L (D|S)* D S* D S* E   gather rays through sharp chains to the next rough vertex, and the global map there
// Where a volume scatters a camera ray, light is sampled and gather rays start, as at a rough surface.
// Volumes that glow and surfaces that are not among the lights (hair, points) send no photons, light beyond the shadow
// terminator (shadow_terminator.h) brings none, and photons end at eye-only surfaces (ray_kind_surfaces.h). Walks find
// this light: along the chains and gather rays above, and beyond by paths that go on from the ends of gather rays: one
// for each first surface in the mean, fewer if there is only light beyond the terminator (rare_light.h). Past surfaces
// that depend on the kind of the ray, photons bring what shadow rays see, after its first scattering; lookups sample the
// direct light, and rays that hit a light past them count.
#pragma once

#include "sampling/sampler.h"
#include "transport/direct/direct_light.h"
#include "transport/direct/eye_media.h"
#include "transport/direct/lobe_split.h"
#include "transport/guiding/guided_bsdf.h"
#include "transport/paths/eye_walk.h"
#include "transport/paths/light_passes.h"
#include "transport/paths/rare_light.h"
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
  static constexpr int kEnough = 2;
  int rays = 8;         ///< gather rays at the first rough surface of a sample
  int neighbours = 60;  ///< photons in an estimate of caustics, at most
  /// Photons in such an estimate that is wider than a pixel. 1: there is none; 0: all within the radius.
  int enough = kEnough;
  PixelRadius pixel;
  bool light_without_photons = false;  ///< a volume or a surface emits that sends no photons
  /// The probability of looking for light beyond the shadow terminator, which brings no photons either; 0: there is none
  float beyond_terminator = 0.0f;
  int gather_neighbours = 10;  ///< photons in an estimate at the end of a gather ray, where no irradiance site is near
  float shortest_logged = 0.0f;  ///< length of the shortest gather rays whose lookups are recorded

  PhotonMap::Lookup caustic_lookup(float radius, const BounceCounts& bounces = {}) const {
    return {neighbours, radius, enough, pixel, bounces};
  }
};

/// Dimensions of the direction of a gather ray. A fixed number for each vertex of its chain follows.
constexpr uint32_t kGatherDimensions = 4;
/// First dimension of media, with EyeMedia::kDimensions for each ray.
constexpr uint32_t kMediaDimensions = 12288;

/// The numbers that choose the direction of a gather ray, from four dimensions.
struct GatherNumbers {
  float lobe, guide = 0.0f;
  Vec2 direction;
  GatherNumbers(Sampler& sampler, uint32_t first, bool guided) {
    sampler.set_dimension(first);
    const Vec3 u = sampler.get_3d();
    lobe = u.z;
    direction = Vec2(u);
    if (!guided) return;
    sampler.set_dimension(first + 3);
    guide = sampler.get_1d();
  }
};

/// The work of one thread: radiance along camera rays, and counts of what is traced.
class PhotonGatherer {
 public:
  /// `media`: of the scene; null if it has none.
  PhotonGatherer(const Scene& scene, const PathMedia* media, const PhotonMaps& maps, const GatherSettings& settings,
                 uint32_t seed)
      : scene_(scene),
        media_(media),
        maps_(maps),
        settings_(settings),
        sampler_(Sampler::Kind::Sobol, seed),
        gather_sampler_(Sampler::Kind::Sobol, hash_combine(seed, 0x67617468U)),
        beyond_(shown_exposure(scene.settings())) {}

  /// Starts sample `index` of pixel number `pixel`. The first dimensions of the returned sampler belong to the camera.
  Sampler& start(uint32_t pixel, uint32_t index) {
    pixel_ = pixel;
    index_ = index;
    logs_ = log_ != nullptr;
    first_ = {};
    direct_paths_ = Color(0.0f);
    if (passes_) passes_->begin();
    sampler_.start(pixel, index);
    return sampler_;
  }
  /// `seen`: light that is seen directly or through delta lobes only. The returned radiance does not contain it.
  Color trace(Ray ray, SampleAux* aux, float& alpha, Color& seen);
  /// From now on, separate the light of each sample by the passes of a film; null: do not.
  void separate(LightPasses* passes) { passes_ = passes; }
  const LightPasses* passes() const { return passes_; }
  /// From now on, record where maps are looked up. `only`: also sample no direct light.
  void log_arrivals(ArrivalLog* log, bool only) {
    log_ = log;
    log_only_ = only;
  }
  /// In units of the global radius. A shorter gather ray ends near a corner, where the blur of the density estimate would
  /// show light from the other side of the corner. Light is gathered once more there.
  static constexpr float kNear = 1.0f;
  /// From now on, also draw the first gather rays by `tree`, and append the result of one in `stride` of them to
  /// `samples`. Both pointers may be null.
  void guide(const GuideTree* tree, std::vector<GuideSample>* samples, uint32_t stride) {
    guide_ = tree;
    guide_samples_ = samples;
    guide_stride_ = stride;
  }
  /// The points at which a camera ray, and one gather ray from there, would look up the maps. Returns false when a ray
  /// reaches no rough surface.
  bool probe(const Ray& ray, SurfacePoint& seen, SurfacePoint& gathered);

  /// Whether the first bounces of the last camera ray were at delta lobes.
  bool polished() const { return polished_; }
  /// Light of the last camera ray by paths LS*E and L(D)S*E, with sharp lobes S, without what trace calls `seen`.
  Color direct_paths() const { return direct_paths_; }
  uint64_t rays() const { return rays_; }
  uint64_t gathered() const { return gathered_; }
  uint64_t from_sites() const { return from_sites_; }
  /// Light beyond the shadow terminator: the samples are gather rays.
  const RareLight& beyond() const { return beyond_; }

 private:
  /// A sampler and its first dimension.
  struct Numbers {
    Sampler& sampler;
    uint32_t dimension;
  };
  /// The surface hit of a walk, and the media of the walk.
  struct Place {
    EyeMedia& media;
    const Hit& hit;
  };
  /// `sampled`: null, or it receives the direction of the light.
  Color direct_light(const ShadingPoint& point, const Bsdf& bsdf, const Place& place, Sampler& sampler,
                     uint32_t dimension, SampledLight* sampled = nullptr);
  /// Whether no photons are stored where the walk is, so that all lobes count as sharp: on hair and points, and on eye-only
  /// surfaces. Chains do not know the way past these: it is not logged.
  bool stores_nothing(const EyeWalk& walk);
  /// Adds light of a camera ray to its passes: after `bounces` scattering events of which the first has been noted; of
  /// media after `bounces` events, which scatter it once or emit it; scattered from `wi` at `point`.
  void add_to_passes(Color light, int bounces, bool of_environment = false);
  void add_to_passes(const EyeMedia::Light& light, int bounces);
  void add_to_passes(Color light, int bounces, const Bsdf& bsdf, const ShadingPoint& point, Vec3 wi);
  /// Direct light from lights that only some kinds of lobes see, which is in no map.
  Color partial_light(const ShadingPoint& point, const Bsdf& bsdf, const Place& place, Sampler& sampler,
                      uint32_t dimension);
  /// A part of the direct light that is in no map. `all_kinds`: false leaves out lights that only some kinds of lobes see.
  template <SampledPart kPart>
  Color sampled_light(const ShadingPoint& point, const Bsdf& bsdf, const Place& place, Pcg32& rng,
                      bool all_kinds = true) {
    const LightSet& lights = scene_.lights();
    if (log_only_ || lights.empty() || !bsdf.has_non_delta()) return Color(0.0f);
    const float u_choice = rng.next_float(), ux = rng.next_float();
    const LightSet::Choice choice = lights.choose(point.position, bsdf.receiving_normal(), u_choice,
                                                  receiver_set(point));
    const Vec2 u(ux, rng.next_float());
    if (!all_kinds && choice.pmf > 0.0f && lights.flags(choice.light).partial()) return Color(0.0f);
    return estimate_direct_through<kPart>(place.media, place.hit, {scene_, point, bsdf}, choice, u, rays_);
  }
  /// Direct light beyond the shadow terminator, which is in no map.
  Color light_beyond(const ShadingPoint& point, const Bsdf& bsdf, const Place& place, Pcg32& rng);
  /// The same, looked for with the probability of the settings. `number`: of the vertex.
  Color light_beyond(const ShadingPoint& point, const Bsdf& bsdf, const Place& place, uint32_t number);
  /// Direct light past surfaces that depend on the kind of the ray, which is in no map. `number`: of the vertex.
  Color light_past_ray_kinds(const ShadingPoint& point, const Bsdf& rough, const Place& place, uint32_t number);
  static std::optional<BsdfSample> sample_sharp(const Bsdf& sharp, Vec3 wo, Numbers numbers);
  /// At surfaces with subsurface scattering: goes below the surface, or stays. False if the walk is lost.
  bool below_surface(EyeWalk& walk, Numbers numbers, Color& beta);
  /// Media along the present camera ray: adds their light. `number`: of the ray. End: nothing more is found along it.
  EyeMedia::Step pass_media(EyeMedia& media, EyeWalk& walk, uint32_t number, bool may_scatter, Color& beta,
                            Color& radiance, float& alpha);
  /// Light that gather rays find from the place where a medium has scattered the camera ray, times `beta`.
  Color gathered_in_medium(const EyeMedia& media, const EyeWalk& walk, Color beta, uint32_t number);
  /// Light that a surface which a camera ray has reached with the throughput `beta` scatters, without that which
  /// follows its sharp lobes further.
  Color at_seen(const ShadingPoint& point, const LobeSplit& split, const Place& place, Color beta, uint32_t base);
  /// Light that the rough lobes of a surface scatter towards the eye: direct, caustic and gathered. `throughput`: from
  /// the surface to the eye.
  Color reflected(const ShadingPoint& point, const Bsdf& rough, const Place& place, Color throughput, int rays,
                  int depth, Numbers numbers);
  /// Light that the rough lobes at the end of a gather ray scatter: from the maps, or for `depth` > 0 gathered once
  /// more.
  Color at_rough(const ShadingPoint& point, const Bsdf& rough, const Place& place, int depth, Numbers numbers);
  /// Direct light of the sharp lobes where a gather ray ends: all of it, or what is in no map. All where no photons are
  /// stored, and of bent lobes, which the caustic map does not have; the ray that goes on finds all other light there.
  Color sharp_light(const ShadingPoint& point, const LobeSplit& split, const Place& place, bool all, Numbers numbers);
  /// Whether gather rays find light at rough lobes.
  bool looks_up() const {
    return maps_.has_global || settings_.light_without_photons || settings_.beyond_terminator > 0.0f;
  }
  /// Light that brings no photons, beyond the surface where a gather ray ends.
  Color light_without_photons(const ShadingPoint& from, const Bsdf& rough, const Place& place, uint32_t dimension);
  /// The same along a walk that has just left a surface (with the light sampling of `origin`), one of `rays`. `beyond`
  /// receives the light beyond the terminator.
  Color follow_without_photons(EyeWalk& walk, EyeMedia& media, DirectVertex origin, Color beta, float rays, Pcg32& rng,
                               Color& beyond);
  /// The volumes of a ray from a surface.
  MediaStack stack_towards(const ShadingPoint& from, const Place& place, Vec3 direction) const;
  struct Incoming {
    Color direct{0.0f};  ///< emission that nothing scatters on the way
    Color scattered{0.0f};
    float distance = 0.0f;  ///< to the first hit; 0 if there is none
  };
  /// Light along a gather ray: the emission of the first hit, and the estimate of the maps at the rough surface that
  /// the ray reaches. `pdf_bsdf`: density of the sample's direction, for MIS with light sampling.
  Incoming incoming(const ShadingPoint& from, const Place& place, const BsdfSample& sample, const DirectVertex& origin,
                    Color throughput, int depth, Numbers numbers);
  /// The same along a walk that has just left a surface (with the light sampling of `origin`) or a point in a medium.
  Incoming follow(EyeWalk& walk, EyeMedia& media, DirectVertex origin, Color throughput, int depth, Numbers numbers);
  /// Follows `ray` and sharp lobes to a rough surface.
  bool find_rough(Ray ray, ShadingPoint& point, SurfaceShading& shading);
  /// Records what a gather ray, one of several and the `number`-th of the pixel, has found.
  void learn_from(GuideSample sample, float distance, uint32_t number);
  /// Whether gather ray `i` of the present sample records where it looks up maps: one in `stride` does.
  bool logs_gather_ray(uint32_t i) const {
    return log_ && (pixel_ + index_ + i) % uint32_t(log_->stride[ArrivalMap::kGathered]) == 0;
  }
  void log_arrival(int place, const ShadingPoint& point, Color throughput);
  /// At the end of a gather ray from `start`.
  void log_gathered(Vec3 start, const ShadingPoint& point, Color throughput);
  Color from_map(const ShadingPoint& point, const Bsdf& rough, const BounceCounts& bounces);

  const Scene& scene_;
  const PathMedia* media_;
  const PhotonMaps& maps_;
  const GatherSettings& settings_;
  MisDirectLight direct_;
  Sampler sampler_, gather_sampler_;
  uint32_t pixel_ = 0, index_ = 0;
  ArrivalLog* log_ = nullptr;
  /// Lookups are logged. Chains know no walks below surfaces, so that lookups behind them are not (path_photons.h).
  bool logs_ = false;
  bool log_only_ = false, polished_ = false;
  bool in_media_ = false;  ///< a volume has scattered the camera ray
  LightPasses* passes_ = nullptr;
  PathPasses first_;  ///< by the first scattering of the camera ray
  Color direct_paths_{0.0f};
  const GuideTree* guide_ = nullptr;
  std::vector<GuideSample>* guide_samples_ = nullptr;
  uint32_t guide_stride_ = 1;
  uint64_t rays_ = 0, gathered_ = 0, from_sites_ = 0;
  RareLight beyond_;
};

}  // namespace ajar
