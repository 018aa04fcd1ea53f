// Resampled importance sampling of the light's part of multiple importance sampling [Talbot, Cline and Egbert 2005; Fan
// 2006, section 3.4.2.6]. Of M candidates x_i with densities p_i, one is kept with a probability proportional to g(x_i)
// / p_i. The target g is the contribution without visibility. Only the kept candidate gets a shadow ray. The estimate
// is f(x) / g(x) * (1 / M) sum_i g(x_i) / p_i. Unbiased. For comparison: it is better than one light sample if shadow
// rays are expensive and most lights are weak. It does not consider occlusion.
#pragma once

#include "transport/direct/direct_estimator.h"

namespace ajar {

class Ris final : public DirectEstimator {
 public:
  Ris(const Scene& scene, const DirectRequest& request) : DirectEstimator(scene, request) {}

 private:
  Color one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex, SampleAux* aux,
                   uint64_t& rays) const override;
  Color many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                     uint64_t& rays) const override;
};

}  // namespace ajar
