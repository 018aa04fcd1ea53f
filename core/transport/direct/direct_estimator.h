// Estimators of direct light other than the default: the light at one vertex of a path, from one light sample or from
// several samples of the mixture.
//
// One sample per vertex (`direct_samples` 1, and always beyond the first surfaces): a light sample at the vertex and
// the path's own BSDF sample at the next one, weighted against each other [Veach 1997, section 9.2]. Several samples: N
// samples of the mixture with deterministic shares, which includes the lobes (light_mixture.h). The path's BSDF sample
// then contributes no more direct light. Each estimator is one file of the folder estimators.
#pragma once

#include <memory>
#include <string>

#include "transport/direct/direct_light.h"
#include "transport/direct/light_mixture.h"

namespace ajar {

struct LearnedLights;  // pmc_hi.h

/// The options of an estimator.
struct DirectRequest {
  int samples = 1;  ///< per estimate, after at most `deepest` bounces; elsewhere one sample
  int deepest = 0;
  /// Lobes that differ are separate components, if the estimator supports it. False is for comparison.
  bool lobes_apart = true;
};

/// Minimum number of samples for estimators that learn within one estimate.
constexpr int kMinEstimateSamples = 8;
inline DirectRequest with_enough_samples(DirectRequest request) {
  request.samples = std::max(request.samples, kMinEstimateSamples);
  return request;
}
/// The groups of the lights; no groups if no light can be chosen.
inline LightGroups groups_to_choose(const Scene& scene) {
  return scene.lights().can_choose() ? LightGroups(scene.lights(), LightMixture::kMaxGroups, scene.center())
                                     : LightGroups();
}

class DirectEstimator {
 public:
  virtual ~DirectEstimator() = default;
  DirectEstimator(const DirectEstimator&) = delete;

  /// The light that arrives at the vertex and is scattered towards wo. `vertex` stores the data for `weight_of_hit`.
  /// `rays` counts shadow rays.
  Color estimate(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex, SampleAux* aux,
                 uint64_t& rays) const {
    if (samples_ > 1 && c.point.ray_depth <= deepest_) return many_samples(c, sampler, vertex, aux, rays);
    return one_sample(c, sampler, first, vertex, aux, rays);
  }
  /// The weight of light that the path's BSDF sample from the vertex has hit.
  virtual float weight_of_hit(const Scene& scene, const DirectVertex& v, uint32_t light, Vec3 wi, Vec3 position,
                              Vec3 normal) const;

  /// Updates the learned data from all samples so far.
  virtual void learn() {}
  /// Whether the estimator learns during the render, whenever `learn` is called.
  virtual bool learns() const { return false; }
  /// Whether it learns before the render, from pilot samples. `learn` ends each iteration of them.
  virtual bool wants_pilot() const { return false; }
  /// The data with which another frame can start. Null if nothing is learned that depends on position. The estimator
  /// must not be used while the result exists.
  virtual std::shared_ptr<const LearnedLights> past() const { return nullptr; }
  /// Starts with the learned data of another frame, before the first sample. Returns empty if they are used, otherwise
  /// the reason against it, as a clause.
  virtual std::string begin_with(const LearnedLights&) { return "there are no lights to choose among"; }

 protected:
  DirectEstimator(const Scene& scene, const DirectRequest& request, LightGroups groups = {})
      : scene_(scene),
        mixture_(scene, std::move(groups)),
        samples_(std::max(1, request.samples)),
        deepest_(request.deepest) {}

  /// The heuristic by which a light sample is weighted against the path's BSDF sample.
  enum class Heuristic : uint8_t { Power, Balance, LightsOnly };
  virtual Color one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex,
                           SampleAux* aux, uint64_t& rays) const;
  virtual Color many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                             uint64_t& rays) const = 0;

  /// Chooses a light by the shares of a cell. Returns its contribution. `chosen` has pmf 0 if there is no light. Lights
  /// for which `wanted(flags)` is false are skipped.
  template <class Wanted>
  Color sample_light(const DirectLightContext& c, Sampler& sampler, uint32_t first, uint32_t cell,
                     LightCutCache::Choice& chosen, uint64_t& rays, Wanted&& wanted) const {
    const LightSet& lights = scene_.lights();
    sampler.set_dimension(first + 1);
    const Vec2 u = sampler.get_2d();
    float u_choice = u.x;
    const bool few = lights.size() < kFewLights;
    if (!few) {
      sampler.set_dimension(first);
      u_choice = sampler.get_1d();
    }
    chosen = mixture_.choose_light(cell, c, u_choice);
    const LightSet::Choice& choice = chosen.choice;
    if (!(choice.pmf > 0.0f)) return Color(0.0f);
    const LightFlags light = lights.flags(choice.light);
    if (!wanted(light)) return Color(0.0f);
    const auto sample = lights.sample_li(choice.light, c.point.position, few ? Vec2(choice.u_remapped, u.y) : u,
                                         c.point.time);
    if (!sample || is_black(sample->radiance)) return Color(0.0f);
    return weight_sample(c, choice, light, *sample, rays);
  }
  Color weight_sample(const DirectLightContext& c, const LightSet::Choice& chosen, LightFlags light,
                      const LightSample& sample, uint64_t& rays) const;
  /// The mean of all samples of a mixture with fixed shares, each weighted by f / K or by the power heuristic.
  Color mean_of_draws(const DirectLightContext& c, const LightMixture::Kernel& k, Sampler& sampler, bool power,
                      uint64_t& rays) const;

  const Scene& scene_;
  LightMixture mixture_;
  int samples_, deepest_;
  Heuristic heuristic_ = Heuristic::Power;
};

}  // namespace ajar
