// Light by paths with walks below surfaces, or by surfaces that depend on the kind of the ray (PathClasses::EyeOnly in
// bidirectional.h), which chains and populations leave out. Walks from the eye find it, connected to walks from lights
// behind the last such place. Direct paths by surfaces that depend on the kind of the ray are not included: they are
// part of direct_paths.h. In pixels where an earlier sample saw such a surface or one that light can enter, a sample is
// the mean of several walks along its camera ray. Their number follows from the rays that earlier samples needed, so that
// they take a given share of the work. It does not change the mean: no sample decides on its own number of walks, since
// volumes and transparent surfaces make it random what a walk sees first.
#pragma once

#include <vector>

#include "transport/bidirectional/bidirectional.h"
#include "transport/paths/light_passes.h"
#include "transport/paths/path.h"

namespace ajar {

class EyeOnlyLight {
 public:
  void prepare(const Scene& scene, uint32_t seed);
  /// Whether there is such light.
  bool active() const { return active_; }

  /// Rays of all walks. Samples in pixels that see such a surface, their walks, and the rays of these.
  struct Work {
    uint64_t rays = 0, samples = 0, walks = 0, rays_of_walks = 0;
  };
  /// The state of one thread.
  class Walker {
   public:
    /// `passes`: to which the light is added.
    Walker(EyeOnlyLight& owner, const PathSpace& space, const LightPasses& passes);
    /// An estimate at a point of the film. `time`: of the photons that are looked up; empty: each sample draws its own.
    /// `pixel` and `index` number the sample; those of a pixel come in their order. `passes`: null, or it receives the
    /// light of a single walk.
    Color sample(Vec2 film, std::optional<float> time, Sampler& sampler, uint32_t pixel, uint32_t index,
                 LightPasses* passes);
    uint64_t rays() const { return walks_.rays(); }

   private:
    friend class EyeOnlyLight;
    Color found(Vec2 film, Sampler& sampler, LightPasses* passes);

    EyeOnlyLight& owner_;
    const Scene& scene_;
    BidirectionalWalks walks_;
    Sampler further_;
    Work work_;
  };
  void count(const Walker& walker);
  /// Called between samples, when all `pixels` have `samples`. `other_rays`: of the samples without these walks.
  void learn(uint32_t samples, double pixels, uint64_t other_rays);
  uint64_t rays() const { return work_.rays; }

 private:
  uint32_t seed_ = 0;
  bool active_ = false;
  uint32_t walks_ = 1;  ///< of a sample that sees such a surface
  /// The samples before, and their further walks in each pixel.
  uint32_t samples_ = 0, further_ = 0;
  Work work_;
  std::vector<uint8_t> seen_;  ///< for each pixel of the frame: whether a sample saw such a surface first
};

}  // namespace ajar
