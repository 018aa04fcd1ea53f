// PMC-HI as published: a mixture that adapts within each estimate [Fan 2006, section 5.4]. Unlike the thesis, it has
// floors, shrinkage, and the densities of all components for every sample.
//
// 1. Equal shares alpha_k for the lobes and the groups of lights, none for the cone.
// 2. n_t samples of K_t = sum_k alpha_k p_k; weights w_i = f(x_i) / K_t(x_i).
// 3. The cone: its axis is sum_i w_i wi / |...|, its half-angle the weighted deviation from the axis. Its density is
//   uniform inside, 1 / (2 pi (1 - cos)) per solid angle.
// 4. alpha_k in proportion to sum_i w_i rho_k(x_i) (eq. 5.8), shrunk towards equal shares. The cone starts with 1/5.
// 5. Repeat from step 2. The estimate is the mean over all iterations. Each iteration is unbiased given the earlier
//   ones.
//
// Unbiased. For comparison with pmc_hi.h, which has a memory. Use 16 or more direct samples. With one sample per
// vertex, this is multiple importance sampling.
#pragma once

#include "transport/direct/direct_estimator.h"

namespace ajar {

class PmcHiPaper final : public DirectEstimator {
 public:
  PmcHiPaper(const Scene& scene, const DirectRequest& request);

 private:
  Color many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                     uint64_t& rays) const override;

  bool lobes_apart_;
};

}  // namespace ajar
