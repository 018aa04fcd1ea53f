// PMC-HI with memory: a mixture whose shares are learned per place and kept for the picture [Fan 2006, section 5.4, and
// 5.6.3, which names the memory as open].
//
// Which light to choose: shares over branches of the light tree (light_cut_cache.h), used by one sample a vertex and by
// many. With several samples an estimate, the shares of the lobes and of any light, too (share_cache.h):
//   alpha_k <- prior and floor, + sqrt(sum_i alpha_k rho_k(x_i) y_i^2),  rho_k = alpha_k p_k / K    (eq. 5.8 with
//   second moments)
// All is learned by a pilot whose samples are in no picture, so that no sample chooses by what it found, and all
// samples of a picture choose by the same shares. Unbiased. Prefer it where lights differ in use from place to place
// (occlusion, many lights). It knows no media.
#pragma once

#include "transport/direct/direct_estimator.h"
#include "transport/direct/share_cache.h"

namespace ajar {

/// What another frame may go on from.
struct LearnedLights {
  std::shared_ptr<const LightCutCache> cuts;
  ShareCache many;
  uint64_t lights;  ///< their fingerprint
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
  std::shared_ptr<LightCutCache> cuts_;  ///< which lights to choose; null where there is nothing to choose among
  float angle_ = 0.0f, reach_ = 0.0f;    ///< of its cells, and how far what the camera sees is, on average
  /// What debug passes show the shares of: the only two lights, else ids of branches where each half of the light tree
  /// begins and where it ends.
  std::vector<uint32_t> shown_lights_, shown_branches_;
  ShareCache many_;  ///< shares of lobes and lights among many samples of an estimate
};

}  // namespace ajar
