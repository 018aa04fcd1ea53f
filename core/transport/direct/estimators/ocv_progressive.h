// Optimizing control variates with coefficients from earlier iterations [Fan 2006, chapter 6, eq. 6.7]. The normal
// equations are summed by block of pixels and material. Every estimate is corrected by the beta of the earlier
// iterations. Unbiased. It needs few samples per estimate and converges to optimal multiple importance sampling
// [Kondapaneni et al. 2019]. Columns and limits are those of ocv.h. It learns during the render.
#pragma once

#include <optional>

#include "transport/direct/direct_estimator.h"
#include "transport/direct/estimators/control_columns.h"

namespace ajar {

class OcvProgressive final : public DirectEstimator {
 public:
  OcvProgressive(const Scene& scene, const DirectRequest& request);
  void learn() override;
  bool learns() const override { return true; }

 private:
  Color many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                     uint64_t& rays) const override;

  static constexpr int kBlock = 8, kSlots = 4;
  struct Slot {
    NormalEquations past;
    ControlCoefficients coefficients;
  };
  Slot& slot(const DirectLightContext& c) const;

  bool lobes_apart_;
  std::optional<ControlColumns> columns_;    ///< none if no light can be chosen
  int x0_ = 0, y0_ = 0, block_columns_ = 0;  ///< of the rendered region, whose tiles consist of whole blocks
  /// From earlier iterations. Within an iteration, only the thread of the block accesses them.
  mutable std::vector<Slot> slots_;
};

}  // namespace ajar
