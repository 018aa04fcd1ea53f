// PMC-HI with memory: a mixture whose shares are learned by position and used for the whole image [Fan 2006, section
// 5.4; section 5.6.3 states the memory as an open problem].
//
// The choice of a light has shares over branches of the light tree (light_cut_cache.h), for one sample per vertex and
// for several. With several samples per estimate, the shares of the lobes and of any light are learned too
// (share_cache.h):
//   alpha_k <- prior and floor, + sqrt(sum_i alpha_k rho_k(x_i) y_i^2),  rho_k = alpha_k p_k / K
//       (eq. 5.8 with second moments)
//
// A pilot learns everything. Its samples are in no image, so that no sample is chosen by its own value, and all samples
// of an image use the same shares. Unbiased. Prefer it if the best lights differ from place to place (occlusion, many
// lights). It does not support media.
#pragma once

#include "transport/direct/direct_estimator.h"
#include "transport/direct/share_cache.h"

namespace ajar {

/// The learned data with which another frame can start.
struct LearnedLights {
  std::shared_ptr<const LightCutCache> cuts;
  ShareCache many;
  uint64_t lights;  ///< fingerprint of the lights
};

class PmcHi final : public DirectEstimator {
 public:
  PmcHi(const Scene& scene, const DirectRequest& request);
  void learn() override;
  bool wants_pilot() const override { return cuts_ && cuts_->learning(); }
  std::shared_ptr<const LearnedLights> past() const override;
  std::string begin_with(const LearnedLights& past) override;

 private:
  Color one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex, SampleAux* aux,
                   uint64_t& rays) const override;
  Color many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                     uint64_t& rays) const override;
  LightMixture::Kernel learned_kernel(const LobeComponents& lobes, uint32_t cell) const;
  uint64_t cell_key(const DirectLightContext& c) const;
  void record_light_shares(const DirectLightContext& c, uint32_t cell, float share, SampleAux* aux) const;

  bool lobes_apart_;
  std::shared_ptr<LightCutCache> cuts_;  ///< choice of lights; null if there is no choice
  float angle_ = 0.0f, reach_ = 0.0f;    ///< size of the cells as an angle; mean distance of visible points
  /// For the debug passes: the only two lights, or the ids of the branches at which the halves of the light tree begin
  /// and end.
  std::vector<uint32_t> shown_lights_, shown_branches_;
  ShareCache many_;  ///< shares of lobes and lights for estimates with several samples
};

}  // namespace ajar
