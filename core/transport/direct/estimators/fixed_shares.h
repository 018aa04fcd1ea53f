// Multiple importance sampling with fixed shares: half of the samples for the BSDF and half for lights, by the power or
// the balance heuristic [Veach 1997, section 9.2]. Or all samples for one of them. Unbiased. Multiple importance
// sampling with one sample per vertex is the default and has its own copy of the path tracer's loop (MisDirectLight).
// The other methods are baselines for comparison: surfaces alone do not find small lights, lights alone are noisy in
// mirrors. All of them sample lights that only sampling can find (delta lights).
#pragma once

#include "transport/direct/direct_estimator.h"

namespace ajar {

class FixedShares final : public DirectEstimator {
 public:
  /// `method`: Mis, MisBalance, Bsdf or Light.
  FixedShares(const Scene& scene, DirectMethod method, const DirectRequest& request);
  float weight_of_hit(const Scene& scene, const DirectVertex& v, uint32_t light, Vec3 wi, Vec3 position,
                      Vec3 normal) const override;

 private:
  Color one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex, SampleAux* aux,
                   uint64_t& rays) const override;
  Color many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                     uint64_t& rays) const override;

  DirectMethod method_;
};

}  // namespace ajar
