// Media along walks from the eye that look up caches or photon maps at surfaces (photon_gather.h, irradiance_cache.cpp).
//
// Media are path traced here: light is sampled where the walk scatters, weighted by the power heuristic against the phase
// function, and the walk goes on by the phase function [Veach 1997, section 9.2; Fong et al. 2017]. Caches and maps store
// nothing in media. A scene without media costs one test per ray.
#pragma once

#include <optional>
#include <type_traits>

#include "transport/direct/media_light.h"
#include "transport/guiding/guided_phase.h"
#include "transport/media/path_media.h"
#include "transport/paths/eye_walk.h"

namespace ajar {

class EyeMedia {
 public:
  /// Traced: the walk has a new ray. Scattered: `scatter` chooses it.
  enum class Step : uint8_t { Surface, Traced, Scattered, End };
  /// Light that media emit along a ray, and light of lamps that they scatter into it once.
  struct Light {
    Color emitted{0.0f}, scattered{0.0f};
    Color sum() const { return emitted + scattered; }
  };
  /// What media_light.h needs.
  struct State {
    const Media& media;
    MediaCounters& counters;
    Pcg32 rng;
    MediaStack stack;
    MediaEvent event = {};  ///< the last one
  };

  /// `media`: null for none. `stack`: of the first ray; `seed`: of the random numbers; `bounces`: how often volumes have
  /// scattered the walk before.
  EyeMedia(const Scene& scene, const PathMedia* media, const MediaStack& stack, uint64_t seed, uint64_t& rays,
           int bounces = 0)
      : scene_(scene), rays_(rays), depth_(bounces) {
    if (media) state_.emplace(State{media->media(), media->local_counters(), Pcg32(seed, 0x65796d64U), stack});
  }
  /// The volumes of a ray of the camera.
  static MediaStack around_camera(const PathMedia* media, const Ray& ray) {
    return media ? media->around(ray.origin + ray.t_min * ray.direction, ray.time) : MediaStack();
  }

  bool active() const { return state_.has_value(); }
  State& state() { return *state_; }
  /// What `pass` adds besides what media emit: all light that they scatter, or the part ByRayKind, or none.
  enum class Scattered : uint8_t { All, ByRayKind, None };
  void count(Scattered part) { scattered_ = part; }
  /// Transmittance to a lamp that the present ray meets.
  Color to_lamp(const EyeWalk& walk, const LightMet& met);
  /// Input of `pass`. `may_scatter`: no bounce limit is reached. The dimensions from `dimension` on are for direct light.
  /// `thorough`: where no medium varies, direct light is estimated whether or not the walk scatters, and the distance is
  /// stratified by two dimensions before those of direct light.
  struct Along {
    Sampler& sampler;
    uint32_t dimension;
    bool may_scatter, thorough = false;
  };
  static constexpr uint32_t kDimensions = 2 + kMediumLightDimensions;
  /// What happens between the walk's last vertex and its next surface, after EyeWalk::trace. `beta`: throughput. Adds to
  /// `light` what media emit and scatter.
  Step pass(EyeWalk& walk, const Along& along, Color& beta, Light& light, float* alpha = nullptr) {
    const Step step = meet(walk, along, beta, light, alpha);
    if (step != Step::Scattered) return step;
    return scatter(walk, beta) ? Step::Traced : Step::End;
  }
  /// The same, but the direction in which the walk goes on where a medium scatters it is left to `scatter`.
  Step meet(EyeWalk& walk, const Along& along, Color& beta, Light& light, float* alpha = nullptr);
  /// The walk goes on from where it was scattered. False if it ends: by roulette, or the direction of the guide has no
  /// light.
  bool scatter(EyeWalk& walk, Color& beta);
  /// From now on, the directions of `scatter` are also chosen by a guide; null: none.
  void guide(const GuideTree* tree) { guide_ = tree; }
  /// Where the walk was scattered.
  Vec3 place() const { return place_; }
  /// Whether the limits allow that surfaces or media scatter light which the walk meets after it goes on from there.
  bool may_scatter_again(const EyeWalk& walk) const {
    const BounceLimits& limits = scene_.settings().bounces;
    return walk.point.ray_depth < limits.total && depth_ < limits.volume;
  }
  /// Samples a direction there. `scatter` does the same with numbers of its own.
  PhaseSample sample_direction(const EyeWalk& walk, const PhaseNumbers& numbers) const {
    return sample_phase_guided(phase(), walk.ray.direction, guide_, place_, 1.0f - plain_, numbers);
  }
  /// The walk goes on in the direction of `sample`.
  void leave_along(EyeWalk& walk, const PhaseSample& sample);
  /// For a copy: other random numbers.
  void reseed(uint64_t seed) { state_->rng = Pcg32(seed, 0x65796d64U); }
  /// The walk leaves the surface at walk.point along `direction`, which passes to the other side or not.
  void leave(const EyeWalk& walk, Vec3 direction);
  /// Whether a phase function chose the present direction, and the weight of a light that it hits.
  bool chose_direction() const { return chose_; }
  float weight_of_hit(const EyeWalk& walk, uint32_t light, Vec3 position, Vec3 normal) const {
    return weight_of_hit_in_medium(scene_, {place_, chosen_for_, pdf_, receiver_set_, walk.ray.time}, light,
                                   walk.ray.direction, position, normal);
  }
  /// A surface has chosen the direction.
  void scattered_at_surface() { chose_ = false; }
  /// The length of the rays that ended where volumes scattered the walk, or at their bounds.
  float way() const { return way_; }
  /// How often volumes have scattered the walk.
  int bounces() const { return depth_; }
  /// A volume bounce limit is reached.
  bool at_limit() const { return depth_ > scene_.settings().bounces.volume; }

 private:
  PhaseFunction phase() const { return PhaseFunction(state_->event.at); }

  const Scene& scene_;
  uint64_t& rays_;
  std::optional<State> state_;
  int depth_ = 0, bounds_ = 0;
  bool chose_ = false;
  Scattered scattered_ = Scattered::All;
  float pdf_ = 0.0f, way_ = 0.0f;
  float plain_ = kPlainShareOfPaths;  ///< probability that phase functions alone chose the directions, given these
  uint32_t receiver_set_ = kEveryLight;
  Vec3 place_{0.0f};
  LightStretch chosen_for_;
  const GuideTree* guide_ = nullptr;
};

/// Weight of a light that a walk hits, against sampling it at the last vertex, `origin`.
struct WalkHitWeight {
  const Scene& scene;
  const MisDirectLight& direct;
  const EyeMedia& media;
  const EyeWalk& walk;
  const DirectVertex& origin;
  float operator()(uint32_t light, Vec3 position, Vec3 normal) const {
    if (media.chose_direction()) return media.weight_of_hit(walk, light, position, normal);
    return direct.weight_of_hit(scene, origin, light, walk.ray.direction, position, normal);
  }
};

/// What an estimate of direct light needs besides its context.
struct DirectCall {
  Sampler& sampler;
  uint32_t dimension;
  DirectVertex& here;
  SampleAux* aux;
  uint64_t& rays;
};
/// The estimate of direct light at `hit` by a method, through media where there are some. Other methods than the default
/// one do not find light beyond the shadow terminator; it is added here.
template <class DirectLight>
[[gnu::always_inline]] inline Color estimate_direct_through(EyeMedia& media, const Hit& hit,
                                                            const DirectLight& direct_light,
                                                            const DirectLightContext& context, const DirectCall& call) {
  if constexpr (std::is_same_v<DirectLight, MisDirectLight>) {
    if (media.active())
      return direct_light.estimate(MediaDirectContext<EyeMedia::State>(context, media.state(), hit), call.sampler,
                                   call.dimension, call.here, call.aux, call.rays);
  }
  const Color light = direct_light.estimate(context, call.sampler, call.dimension, call.here, call.aux, call.rays);
  if constexpr (!std::is_same_v<DirectLight, MisDirectLight>) {
    if (has_soft_terminator(context.point))
      return light + estimate_direct<SampledPart::BeyondTerminator>(context, call.sampler, call.dimension, call.rays);
  }
  return light;
}
/// One sample of a chosen light at `hit` (estimate_direct), through media where there are some.
template <SampledPart kPart = SampledPart::All>
Color estimate_direct_through(EyeMedia& media, const Hit& hit, const DirectLightContext& context,
                              const LightSet::Choice& choice, Vec2 u, uint64_t& rays) {
  if (!media.active()) return estimate_direct<kPart>(context, choice, u, rays);
  return estimate_direct<kPart>(MediaDirectContext<EyeMedia::State>(context, media.state(), hit), choice, u, rays);
}

}  // namespace ajar
