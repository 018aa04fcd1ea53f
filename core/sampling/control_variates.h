// Optimizing control variates over the samples of a mixture [Fan 2006, chapter 6].
//
// With y = f / p (a colour) and z_j = p_j / p of each sample, p = sum_j alpha_j p_j, any beta gives the estimate
//   I(beta) = mean(y) - sum_j beta_j (mean(z_j) - 1)                                   [eq. 6.7]
// It is unbiased if beta does not depend on these samples. beta is the least-squares fit of y on the z_j and an
// intercept. Since sum_j alpha_j z_j = 1, the last component is left out (its beta is 0). The best beta is that of
// optimal multiple importance sampling [Kondapaneni et al. 2019].
//
// Departures from the thesis:
// - beta never comes from the samples that it corrects (except in `ocv_paper`).
// - The intercept is not penalised.
// - The ridge is relative to the scale of the problem.
#pragma once

#include <span>

#include "math/types.h"

namespace ajar {

constexpr int kMaxControls = 8;  ///< maximum number of components of a mixture with control variates

struct ControlSample {
  Color y;
  float z[kMaxControls];
};

/// Coefficients of each component and colour channel; the default is the plain mixture estimator.
struct ControlCoefficients {
  Color beta[kMaxControls] = {};
  int count = 0;  ///< number of components; 0: no correction
};

/// The sums that the fit needs. Samples can be added in any number and any order, and sums of parts can be merged.
class NormalEquations {
 public:
  explicit NormalEquations(int components = 0) : m_(components) {}
  int components() const { return m_; }
  double samples() const { return n_; }
  void add(const ControlSample& sample);
  void merge(const NormalEquations& other);
  /// Coefficients with a ridge of `relative_ridge` times the mean diagonal element of the centred matrix. The result
  /// has count 0 if there are fewer than `min_samples` samples, if the system is degenerate, or if the fit is not
  /// expected to reduce the variance of the luminance of y.
  ControlCoefficients fit(double relative_ridge, int min_samples) const;

 private:
  static constexpr int kColumns = kMaxControls - 1;
  int m_;
  double n_ = 0.0;
  double z_[kColumns] = {}, zz_[kColumns * (kColumns + 1) / 2] = {};
  double y_[3] = {}, yy_[3] = {}, zy_[3][kColumns] = {};
};

/// Eq. 6.7. Unbiased if `coefficients` are independent of `samples`.
Color control_estimate(std::span<const ControlSample> samples, const ControlCoefficients& coefficients);

/// Cross-fitting: each fold is corrected by the coefficients of the other. The folds are drawn independently with the
/// same shares. Unbiased.
Color ocv_cross_fitted(std::span<const ControlSample> a, std::span<const ControlSample> b, int components);

/// The published estimator, for comparison: beta_0 + sum beta_j (eq. 6.10) with lambda on all coefficients (eq. 6.11),
/// fitted on the samples that it estimates from. It is *biased* for two reasons: the fit uses its own samples, and
/// lambda shrinks the intercept.
Color ocv_paper(std::span<const ControlSample> samples, int components, double lambda = 1.0);

/// Best ridges on the test scenes for a fit on few samples and for a fit on many samples.
constexpr double kRidgeFew = 0.1, kRidgeMany = 1e-3;

}  // namespace ajar
