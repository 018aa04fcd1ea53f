// Media along walks from the eye that look up caches or photon maps at surfaces (photon_gather.h, irradiance_cache.cpp).
//
// Media are path traced here: light is sampled where the walk scatters, weighted by the power heuristic against the phase
// function, and the walk goes on by the phase function [Veach 1997, section 9.2; Fong et al. 2017]. Caches and maps store
// nothing in media. A scene without media costs one test per ray.
#pragma once

#include <optional>
#include <type_traits>

#include "transport/direct/media_light.h"
#include "transport/media/path_media.h"
#include "transport/paths/eye_walk.h"

namespace ajar {

class EyeMedia {
 public:
  enum class Step : uint8_t { Surface, Traced, End };  ///< Traced: the walk has a new ray
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
  };

  /// `media`: null for none. `stack`: of the first ray; `seed`: of the random numbers.
  EyeMedia(const Scene& scene, const PathMedia* media, const MediaStack& stack, uint64_t seed, uint64_t& rays)
      : scene_(scene), rays_(rays) {
    if (media) state_.emplace(State{media->media(), media->local_counters(), Pcg32(seed, 0x65796d64U), stack});
  }
  /// The volumes of a ray of the camera.
  static MediaStack around_camera(const PathMedia* media, const Ray& ray) {
    return media ? media->around(ray.origin + ray.t_min * ray.direction, ray.time) : MediaStack();
  }

  bool active() const { return state_.has_value(); }
  State& state() { return *state_; }
  /// From now on, `pass` adds what media emit and not what they scatter.
  void count_only_emission() { only_emission_ = true; }
  /// Transmittance to a lamp that the present ray meets.
  Color to_lamp(const EyeWalk& walk, const LightMet& met);
  /// What happens between the walk's last vertex and its next surface, after EyeWalk::trace. `beta`: throughput. Adds to
  /// `light` what media emit and scatter. `may_scatter`: no bounce limit is reached. Direct light uses the dimensions
  /// from `dimension` on.
  Step pass(EyeWalk& walk, Sampler& sampler, uint32_t dimension, bool may_scatter, Color& beta, Light& light,
            float* alpha = nullptr);
  /// The walk leaves the surface at walk.point along `direction`, which passes to the other side or not.
  void leave(const EyeWalk& walk, Vec3 direction);
  /// Whether a phase function chose the present direction, and the weight of a light that it hits.
  bool chose_direction() const { return chose_; }
  float weight_of_hit(const EyeWalk& walk, uint32_t light, Vec3 position, Vec3 normal) const {
    return weight_of_hit_in_medium(scene_, {place_, place_, pdf_, receiver_set_, walk.ray.time}, light,
                                   walk.ray.direction, position, normal);
  }
  /// A surface has chosen the direction.
  void scattered_at_surface() { chose_ = false; }
  /// A volume bounce limit is reached.
  bool at_limit() const { return depth_ > scene_.settings().bounces.volume; }

 private:
  const Scene& scene_;
  uint64_t& rays_;
  std::optional<State> state_;
  int depth_ = 0, bounds_ = 0;
  bool chose_ = false, only_emission_ = false;
  float pdf_ = 0.0f;
  uint32_t receiver_set_ = kEveryLight;
  Vec3 place_{0.0f};
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
      return light + estimate_direct<true>(context, call.sampler, call.dimension, call.rays);
  }
  return light;
}

}  // namespace ajar
