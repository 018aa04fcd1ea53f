// The remaining time of a render, predicted from the time of its latest samples.
//
// The time per sample is that of the second half of the samples so far, so that the choice of a technique, the first
// iterations and learning do not count. The error is expected to fall as n^-kErrorExponent with the number of samples:
// independent samples have the exponent 1, stratified ones a larger one. A fit of the exponent to each render predicts
// its end less well than this constant (docs/benchmarks/remaining_time.md).
#pragma once

#include <cstddef>
#include <vector>

namespace ajar {

class RemainingTime {
 public:
  static constexpr double kErrorExponent = 1.12;
  static constexpr double kMinSamples = 16.0;  ///< minimum number of samples after which an error can end a render

  /// Starts a new render: `seconds` have passed before its first sample.
  void begin(double seconds);
  /// Records the end of an iteration: `samples` of this render in total, after `seconds`.
  void add(double seconds, double samples);
  /// Negative before the end of the first iteration.
  double seconds_per_sample() const;
  /// Seconds until there are `samples` in total; negative: unknown.
  double until_samples(double samples) const;
  /// Seconds until the error, which is now `error`, is `target`; negative: unknown.
  double until_error(double error, double target) const;

 private:
  struct Moment {
    double seconds, samples;
  };
  std::vector<Moment> moments_;  // the first has at most half of the samples of the last
};

}  // namespace ajar
