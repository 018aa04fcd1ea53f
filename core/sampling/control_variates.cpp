#include "sampling/control_variates.h"

#include <cmath>

namespace ajar {

namespace {

constexpr double kLuminance[3] = {0.2126729, 0.7151522, 0.0721750};

/// Index of element (i, j) of a symmetric matrix of which the lower triangle is stored.
constexpr int packed(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

/// In-place Cholesky factorisation of a packed symmetric matrix. Returns false if a pivot is not above `smallest`: the
/// matrix is not positive definite to working precision.
bool factor(double* a, int n, double smallest) {
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) {
      double sum = a[packed(i, j)];
      for (int k = 0; k < j; ++k) sum -= a[packed(i, k)] * a[packed(j, k)];
      if (i == j) {
        if (!(sum > smallest)) return false;
        a[packed(j, j)] = std::sqrt(sum);
      } else {
        a[packed(i, j)] = sum / a[packed(j, j)];
      }
    }
  }
  return true;
}

/// Solves L L^T x = right with the packed factor L.
void solve(const double* l, int n, const double* right, double* x) {
  for (int i = 0; i < n; ++i) {
    double sum = right[i];
    for (int k = 0; k < i; ++k) sum -= l[packed(i, k)] * x[k];
    x[i] = sum / l[packed(i, i)];
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) x[i] -= l[packed(k, i)] * x[k];
    x[i] /= l[packed(i, i)];
  }
}

}  // namespace

void NormalEquations::add(const ControlSample& s) {
  const int columns = m_ - 1;
  n_ += 1.0;
  for (int i = 0; i < columns; ++i) {
    z_[i] += double(s.z[i]);
    for (int j = 0; j <= i; ++j) zz_[packed(i, j)] += double(s.z[i]) * double(s.z[j]);
  }
  for (int c = 0; c < 3; ++c) {
    const double y = double(s.y[c]);
    if (y == 0.0) continue;
    y_[c] += y;
    yy_[c] += y * y;
    for (int i = 0; i < columns; ++i) zy_[c][i] += double(s.z[i]) * y;
  }
}

void NormalEquations::merge(const NormalEquations& other) {
  n_ += other.n_;
  for (int i = 0; i < kColumns; ++i) z_[i] += other.z_[i];
  for (int i = 0; i < kColumns * (kColumns + 1) / 2; ++i) zz_[i] += other.zz_[i];
  for (int c = 0; c < 3; ++c) {
    y_[c] += other.y_[c];
    yy_[c] += other.yy_[c];
    for (int i = 0; i < kColumns; ++i) zy_[c][i] += other.zy_[c][i];
  }
}

ControlCoefficients NormalEquations::fit(double relative_ridge, int min_samples) const {
  ControlCoefficients none;
  const int columns = m_ - 1;
  if (columns < 1 || n_ < double(min_samples)) return none;

  // Centring removes the intercept from the system, and so from the penalty. Columns that never varied are not counted:
  // nothing is known about them, and their coefficients become 0.
  double centred[kColumns * (kColumns + 1) / 2], matrix[kColumns * (kColumns + 1) / 2], trace = 0.0;
  int varying = 0;
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j <= i; ++j) centred[packed(i, j)] = zz_[packed(i, j)] - z_[i] * z_[j] / n_;
    trace += centred[packed(i, i)];
    varying += centred[packed(i, i)] > 0.0;
  }
  if (!(trace > 1e-12 * n_) || !std::isfinite(trace)) return none;
  const double ridge = relative_ridge * trace / varying;
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j <= i; ++j) matrix[packed(i, j)] = centred[packed(i, j)] + (i == j ? ridge : 0.0);
  }
  if (!factor(matrix, columns, 1e-12 * trace)) return none;

  // One factorisation serves the three channels. The residual sums of squares show whether the fit reduces the
  // variance.
  ControlCoefficients fitted;
  fitted.count = m_;
  double before = 0.0, after = 0.0;
  for (int c = 0; c < 3; ++c) {
    double right[kColumns], beta[kColumns];
    for (int i = 0; i < columns; ++i) right[i] = zy_[c][i] - z_[i] * y_[c] / n_;
    solve(matrix, columns, right, beta);
    double residual = yy_[c] - y_[c] * y_[c] / n_;
    before += kLuminance[c] * residual;
    for (int i = 0; i < columns; ++i) {
      residual -= 2.0 * beta[i] * right[i];
      for (int j = 0; j < columns; ++j) residual += beta[i] * beta[j] * centred[packed(i, j)];
      fitted.beta[i][c] = float(beta[i]);
      if (!std::isfinite(fitted.beta[i][c])) return none;
    }
    after += kLuminance[c] * residual;
  }
  // The fit of every coefficient uses a degree of freedom, and the error of the coefficient adds to the error of the
  // estimate. The test counts both, as Akaike's final prediction error does.
  const double k = double(varying);
  if (n_ - 1.0 - k < 1.0 || !(after * (n_ + k) / (n_ - 1.0 - k) < before * n_ / (n_ - 1.0))) return none;
  return fitted;
}

Color control_estimate(std::span<const ControlSample> samples, const ControlCoefficients& coefficients) {
  if (samples.empty()) return Color(0.0f);
  Color sum(0.0f);
  for (const ControlSample& s : samples) sum += s.y;
  // Eq. 6.7.
  Color estimate = sum / float(samples.size());
  for (int j = 0; j < coefficients.count; ++j) {
    float z = 0.0f;
    for (const ControlSample& s : samples) z += s.z[j];
    estimate -= coefficients.beta[j] * (z / float(samples.size()) - 1.0f);
  }
  return estimate;
}

Color ocv_cross_fitted(std::span<const ControlSample> a, std::span<const ControlSample> b, int components) {
  NormalEquations of_a(components), of_b(components);
  for (const ControlSample& s : a) of_a.add(s);
  for (const ControlSample& s : b) of_b.add(s);
  const Color estimate_a = control_estimate(a, of_b.fit(kRidgeFew, 2 * components));
  const Color estimate_b = control_estimate(b, of_a.fit(kRidgeFew, 2 * components));
  const float weight_a = float(a.size()) / float(a.size() + b.size());
  return weight_a * estimate_a + (1.0f - weight_a) * estimate_b;
}

Color ocv_paper(std::span<const ControlSample> samples, int components, double lambda) {
  // Columns: 1, z_1 .. z_{m-1}.
  const int n = components;
  double matrix[kMaxControls * (kMaxControls + 1) / 2] = {}, right[3][kMaxControls] = {};
  for (const ControlSample& s : samples) {
    double row[kMaxControls];
    row[0] = 1.0;
    for (int i = 1; i < n; ++i) row[i] = double(s.z[i - 1]);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= i; ++j) matrix[packed(i, j)] += row[i] * row[j];
      for (int c = 0; c < 3; ++c) right[c][i] += row[i] * double(s.y[c]);
    }
  }
  // Eq. 6.11: lambda on all coefficients.
  for (int i = 0; i < n; ++i) matrix[packed(i, i)] += lambda;
  if (!factor(matrix, n, 0.0)) return control_estimate(samples, {});
  Color estimate(0.0f);
  for (int c = 0; c < 3; ++c) {
    double beta[kMaxControls];
    solve(matrix, n, right[c], beta);
    // Eq. 6.10: the sum of all coefficients.
    double sum = 0.0;
    for (int i = 0; i < n; ++i) sum += beta[i];
    estimate[c] = float(sum);
  }
  return estimate;
}

}  // namespace ajar
