// A method for direct light other than the default: how one vertex of a path is lit, by one sample of a light or by
// several of the mixture.
//
// One sample a vertex (`direct_samples` 1, and always after the first surfaces): a light sample now, and the path's own
// BSDF sample later, weighted against each other [Veach 1997, section 9.2]. More samples: N of the mixture with
// deterministic shares, lobes included (light_mixture.h); the path's BSDF sample then finds no more light. Each
// estimator is one file of the folder estimators.
#pragma once

#include <memory>
#include <string>

#include "transport/direct/direct_light.h"
#include "transport/direct/direct_methods.h"
#include "transport/direct/light_mixture.h"

namespace ajar {

struct LearnedLights;  // pmc_hi.h

/// What is asked of a method.
struct DirectRequest {
  int samples = 1;  ///< of an estimate at what the eye sees, and after up to `deepest` bounces; one elsewhere
  int deepest = 0;
  /// lobes that differ are components of their own, where the method knows them; false is for comparison
  bool lobes_apart = true;
};

/// Methods that learn within one estimate need as many samples as this.
constexpr int kMinEstimateSamples = 8;
inline DirectRequest with_enough_samples(DirectRequest request) {
  request.samples = std::max(request.samples, kMinEstimateSamples);
  return request;
}
/// The lights in groups, where any can be chosen.
inline LightGroups groups_to_choose(const Scene& scene) {
  return scene.lights().can_choose() ? LightGroups(scene.lights(), LightMixture::kMaxGroups, scene.center())
                                     : LightGroups();
}

class DirectEstimator {
 public:
  virtual ~DirectEstimator() = default;
  DirectEstimator(const DirectEstimator&) = delete;

  /// Light that arrives at the vertex and is scattered towards wo. `vertex` remembers what `weight_of_hit` must know;
  /// `rays` counts shadow rays.
  Color estimate(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex, SampleAux* aux,
                 uint64_t& rays) const {
    if (samples_ > 1 && c.point.ray_depth <= deepest_) return many_samples(c, sampler, vertex, aux, rays);
    return one_sample(c, sampler, first, vertex, aux, rays);
  }
  /// Of light that the path's BSDF sample from the vertex happened to hit.
  virtual float weight_of_hit(const Scene& scene, const DirectVertex& v, uint32_t light, Vec3 wi, Vec3 position,
                              Vec3 normal) const;

  /// Everything rendered so far becomes the past.
  virtual void learn() {}
  /// During the render, whenever `learn` is called.
  virtual bool learns() const { return false; }
  /// Before it, from samples of its own; `learn` ends each iteration of them.
  virtual bool wants_pilot() const { return false; }
  /// What another frame may go on from; null where nothing is learned that belongs to places of the scene. Not to be
  /// used while it lasts.
  virtual std::shared_ptr<const LearnedLights> past() const { return nullptr; }
  /// Before the first sample. Returns why not, as a clause; empty when it is used.
  virtual std::string begin_with(const LearnedLights&) { return "there are no lights to choose among"; }

 protected:
  DirectEstimator(const Scene& scene, const DirectRequest& request, LightGroups groups = {})
      : scene_(scene),
        mixture_(scene, std::move(groups)),
        samples_(std::max(1, request.samples)),
        deepest_(request.deepest) {}

  /// How a light sample is weighted against the path's BSDF sample.
  enum class Heuristic : uint8_t { Power, Balance, LightsOnly };
  virtual Color one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex,
                           SampleAux* aux, uint64_t& rays) const;
  virtual Color many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                             uint64_t& rays) const = 0;

  /// Chooses a light by the shares of a cell, and what it brings; `chosen` has pmf 0 when there is none.
  /// `wanted(flags)` refuses lights.
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
  /// Of a hit with the density that light sampling has for it.
  float light_pdf_of_hit(const Scene& scene, const DirectVertex& v, uint32_t light, Vec3 wi, Vec3 position,
                         Vec3 normal) const;
  /// All samples of a mixture whose shares are fixed, each weighted by f / K or by the power heuristic.
  Color mean_of_draws(const DirectLightContext& c, const LightMixture::Kernel& k, Sampler& sampler, bool power,
                      uint64_t& rays) const;

  const Scene& scene_;
  LightMixture mixture_;
  int samples_, deepest_;
  Heuristic heuristic_ = Heuristic::Power;
};

}  // namespace ajar
