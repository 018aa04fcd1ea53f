// Small lights out of focus, found from the lights. The camera spreads such a light over many pixels, and few rays from
// these pixels hit it: rare samples with large values. Here, a point on a light and a point on the lens are joined, and
// the light is splatted to the film point of the ray between them. Only rays that nothing interrupts count (paths L E).
//
// Path tracing combines these light samples with its camera rays by multiple importance sampling [Veach 1997, section
// 9.2]. Where all rays of a pixel hit a light, camera rays have no variance, whatever the densities of the two are.
// Therefore three probes decide first: rays through film points near that of the sample, and through other points of the
// lens. If two of them find light at least half as strong, camera rays have the whole weight; else, the power heuristic
// decides. Both kinds of samples draw their probes in the same way and independently of the sample, so that the
// expectations of the two weights of a ray add up to 1, and the estimate is unbiased.
//
// A trial before the render finds the branches of the light tree that hold such lights. The other lights stay with camera
// rays, without probes. Not for orthographic cameras and panoramas, and not for light past transparent surfaces and
// boundaries of media.
#pragma once

#include <optional>
#include <vector>

#include "film/filter.h"
#include "sampling/sampler.h"
#include "scene/scene.h"
#include "transport/paths/ray_events.h"

namespace ajar {

class LensLight {
 public:
  /// Why the scene cannot have such samples; empty: it can.
  static const char* reason_against(const Scene& scene);
  /// Runs the trial. The scene must outlive it and must allow such samples. All renders of a scene have the same outcome,
  /// so that their films have the same tables.
  explicit LensLight(const Scene& scene);
  /// False if the trial has found no such light.
  bool active() const { return !branches_.empty(); }
  /// The number of light samples for each sample of a pixel: the probability that a sample draws one.
  float share() const { return share_; }
  uint64_t trial_rays() const { return trial_rays_; }

  struct Splat {
    Vec2 film;
    Color light;  ///< the sum over all splats, over the samples per pixel, is the image; without media on the way
    Ray ray;      ///< from the camera
    LightMet met;
    const ObjectDescription* object;  ///< whose surface emits; null: a lamp
  };
  /// One light sample, for a sampler that was started for it. Counts its rays.
  std::optional<Splat> sample(Sampler& sampler, uint64_t& rays) const;

  /// The weight of a camera ray through this film point, which has met a light with nothing in between.
  /// Draws its probes from the dimensions of `sampler` from kProbeDimension on.
  float weight_of_hit(Vec2 film, const Ray& ray, const LightMet& met, Sampler& sampler, uint64_t& rays) const;
  static constexpr uint32_t kProbeDimension = 24576;

 private:
  struct Branch {
    uint32_t id;
    float pmf = 1.0f, cumulative = 1.0f;
  };
  /// A camera ray to a light that was sampled from the lens, with what it has met.
  struct Found {
    Ray ray;
    Vec2 film;
    LightMet met;
    const ObjectDescription* object;
  };
  std::optional<Found> find(uint32_t branch, Sampler& sampler, uint64_t& rays) const;
  /// Calls visit(met, object) for each light that the ray meets before anything else.
  template <class Visit>
  void meet_along(const Ray& ray, uint64_t& rays, Visit&& visit) const;
  /// Whether two of three probes around this film point find light of at least half the luminance.
  bool probes_find(Vec2 film, float time, Color radiance, Sampler& sampler, uint64_t& rays) const;
  /// The density with which light samples of a branch find the light of this ray, over that of camera rays.
  float density_ratio(const Branch& branch, const Ray& ray, const LightMet& met) const;
  /// Null: camera rays alone find the light.
  const Branch* branch_of(uint32_t light) const;
  /// The weight of a light sample against camera rays, if probes do not find the light. `ratio`: density_ratio.
  static float weight_of_sample(float ratio) { return ratio * ratio / (1.0f + ratio * ratio); }

  const Scene* scene_;
  PixelFilter filter_;
  float pixels_, margin_, share_ = 1.0f;
  uint64_t trial_rays_ = 0;
  std::vector<uint32_t> ids_;     ///< of all branches, in order
  std::vector<int> in_use_;       ///< for each of them: its index in branches_; -1: not used
  std::vector<Branch> branches_;  ///< those that are used
};

}  // namespace ajar
