// Optimizing control variates over the samples of a mixture [Fan 2006, chapter 6].
//
// With y = f / p (a colour) and z_j = p_j / p of each sample, p = sum_j alpha_j p_j, any coefficients give
//   I(beta) = mean(y) - sum_j beta_j (mean(z_j) - 1)                                   [eq. 6.7]
// which is unbiased if beta does not depend on these samples. beta is the least-squares fit of y on the z_j and an
// intercept; since sum_j alpha_j z_j = 1 the last component is left out (its beta is 0). The best beta is that of
// optimal multiple importance sampling [Kondapaneni et al. 2019]. Departures from the thesis: beta never comes from the
// samples it corrects (except in `ocv_paper`), the intercept is not penalised, and the ridge is relative to the scale
// of the problem.
#pragma once

#include <span>

#include "math/types.h"

namespace ajar {

constexpr int kMaxControls = 8;  ///< components of a mixture with control variates

struct ControlSample {
  Color y;
  float z[kMaxControls];
};

/// Coefficients per component and colour channel; the default is the plain mixture estimator.
struct ControlCoefficients {
  Color beta[kMaxControls] = {};
  int count = 0;  ///< 0: none
};

/// Sums from which coefficients follow; of any number of samples, in any order, in parts.
class NormalEquations {
 public:
  explicit NormalEquations(int components = 0) : m_(components) {}
  int components() const { return m_; }
  double samples() const { return n_; }
  void add(const ControlSample& sample);
  void merge(const NormalEquations& other);
  /// Coefficients with a ridge of `relative_ridge` times the mean diagonal element of the centred matrix. None (count
  /// 0) when there are fewer than `min_samples`, when the system is degenerate, or when the luminance of y would not be
  /// expected to vary less.
  ControlCoefficients fit(double relative_ridge, int min_samples) const;

 private:
  static constexpr int kColumns = kMaxControls - 1;
  int m_;
  double n_ = 0.0;
  double z_[kColumns] = {}, zz_[kColumns * (kColumns + 1) / 2] = {};
  double y_[3] = {}, yy_[3] = {}, zy_[3][kColumns] = {};
};

/// Eq. 6.7. Unbiased when `coefficients` are independent of `samples`.
Color control_estimate(std::span<const ControlSample> samples, const ControlCoefficients& coefficients);

/// Cross-fitting: each fold is corrected by what the other says. The folds are drawn independently with the same
/// shares. Unbiased.
Color ocv_cross_fitted(std::span<const ControlSample> a, std::span<const ControlSample> b, int components);

/// As published, for comparison: beta_0 + sum beta_j (eq. 6.10) with lambda on all coefficients (eq. 6.11), fitted on
/// the samples it is the estimate of. *Biased*, twice.
Color ocv_paper(std::span<const ControlSample> samples, int components, double lambda = 1.0);

/// Ridge that proved best on the test scenes for a fit on few samples, and for one on many.
constexpr double kRidgeFew = 0.1, kRidgeMany = 1e-3;

}  // namespace ajar
