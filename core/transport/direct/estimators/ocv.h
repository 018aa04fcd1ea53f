// Optimizing control variates: the linear combination of the samples of a mixture with minimum variance [Fan 2006,
// chapter 6].
//
//   I(beta) = 1/N sum_i [y_i - sum_j beta_j z_ij] + sum_j beta_j,   y = f / K, z_j = p_j / K    (eq. 6.7)
//
// beta is the least-squares fit of y on the z_j. There are three forms:
// - Ocv: two folds of the samples, each corrected by the beta of the other (cross-fitting). Unbiased.
// - OcvPaper: beta_0 + sum beta_j with a ridge, fitted to the samples that it corrects (eqs. 6.10 and 6.11). Biased:
//   the image is too dark. For comparison.
// - Correlated: one control variate for all lights together [Szecsi, Sbert and Szirmay-Kalos 2004; Fan 2006, section
//   3.4.2], cross-fitted. Unbiased. For comparison.
//
// Use 16 or more direct samples. With one sample per vertex, this is multiple importance sampling. With many lights
// (control_columns.h), it is the plain mean of the mixture.
#pragma once

#include <optional>

#include "transport/direct/direct_estimator.h"
#include "transport/direct/estimators/control_columns.h"

namespace ajar {

class Ocv final : public DirectEstimator {
 public:
  /// `method`: Ocv, OcvPaper or Correlated.
  Ocv(const Scene& scene, DirectMethod method, const DirectRequest& request);

 private:
  Color many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                     uint64_t& rays) const override;

  DirectMethod method_;
  bool lobes_apart_;
  std::optional<ControlColumns> columns_;  ///< none if no light can be chosen
};

}  // namespace ajar
