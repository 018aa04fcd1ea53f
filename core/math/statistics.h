// Running statistics that stay accurate over millions of samples.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace ajar {

/// Neumaier's compensated sum: the error does not grow with the number of terms.
class CompensatedSum {
 public:
  void add(double x) {
    const double t = sum_ + x;
    compensation_ += std::abs(sum_) >= std::abs(x) ? (sum_ - t) + x : (x - t) + sum_;
    sum_ = t;
  }
  double value() const { return sum_ + compensation_; }

 private:
  double sum_ = 0.0, compensation_ = 0.0;
};

/// Mean and unbiased variance by Welford's recurrence.
class RunningMoments {
 public:
  void add(double x) {
    ++count_;
    const double delta = x - mean_;
    mean_ += delta / double(count_);
    m2_ += delta * (x - mean_);
  }
  uint64_t count() const { return count_; }
  double mean() const { return mean_; }
  /// Variance of one sample; 0 for fewer than two samples.
  double variance() const { return count_ > 1 ? m2_ / double(count_ - 1) : 0.0; }
  double variance_of_mean() const { return count_ > 1 ? variance() / double(count_) : 0.0; }

 private:
  uint64_t count_ = 0;
  double mean_ = 0.0, m2_ = 0.0;
};

/// The upper median, or `otherwise` if `values` is empty. Reorders `values`.
inline float median(std::vector<float>& values, float otherwise) {
  if (values.empty()) return otherwise;
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// The median of positive values with the weights 1 / value, or `otherwise` if `values` is empty. Sorts `values`.
inline float median_by_inverse(std::vector<float>& values, float otherwise) {
  std::sort(values.begin(), values.end());
  double total = 0.0, sum = 0.0;
  for (const float value : values) total += 1.0 / double(value);
  for (const float value : values)
    if ((sum += 1.0 / double(value)) >= 0.5 * total) return value;
  return otherwise;
}

}  // namespace ajar
