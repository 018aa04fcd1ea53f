// Light beyond the shadow terminator after a bounce (shadow_terminator.h), which chains and populations leave out: walks
// from the eye sample lights at the smooth meshes that they meet. Not every sample walks (rare_light.h).
#pragma once

#include "transport/bidirectional/bidirectional.h"
#include "transport/paths/light_passes.h"
#include "transport/paths/path.h"
#include "transport/paths/rare_light.h"

namespace ajar {

class LightBeyond {
 public:
  void prepare(const Scene& scene, uint32_t seed);
  /// Whether such light is possible.
  bool active() const { return active_; }

  /// The state of one thread.
  class Walker {
   public:
    /// `passes`: to which the light is added.
    Walker(const LightBeyond& owner, const PathSpace& space, const LightPasses& passes);
    /// An estimate at a point of the film. `time`: of the photons that are looked up; empty: each sample draws its own.
    /// `pixel` and `index` number the sample. `other`: its other light. `passes`: null, or it receives the light.
    Color sample(Vec2 film, std::optional<float> time, Sampler& sampler, uint32_t pixel, uint32_t index, Color other,
                 LightPasses* passes);

   private:
    friend class LightBeyond;
    const LightBeyond& owner_;
    const Scene& scene_;
    BidirectionalWalks walks_;
    RareLight found_;
  };
  void count(const Walker& walker);
  /// Called between samples, when all pixels have `samples`. `other_rays`: of the samples without these walks.
  void learn(uint32_t samples, uint64_t other_rays);
  uint64_t rays() const { return rays_; }

 private:
  uint32_t seed_ = 0;
  bool active_ = false;
  float probability_ = RareLight::kFirst;
  uint64_t rays_ = 0;
  RareLight found_;
};

}  // namespace ajar
