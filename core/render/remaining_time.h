// How long a render still takes, from how long its latest samples took.
//
// The pace is that of the second half of the samples so far, so that choosing a technique, first iterations and
// learning do not slow it. The error is expected to fall as n^-kErrorExponent with the number of samples: independent
// samples have the exponent 1, stratified ones a larger one. A fit of the exponent to each render predicts its end less
// well than this constant (docs/benchmarks/remaining_time.md).
#pragma once

#include <cstddef>
#include <vector>

namespace ajar {

class RemainingTime {
 public:
  static constexpr double kErrorExponent = 1.12;
  static constexpr double kMinSamples = 16.0;  ///< for an error to end a render

  /// A new render: `seconds` have passed before its first sample.
  void begin(double seconds);
  /// An iteration has ended: `samples` of this render in all, after `seconds`.
  void add(double seconds, double samples);
  /// Negative before the first iteration.
  double seconds_per_sample() const;
  /// Until there are `samples` in all; negative: not known.
  double until_samples(double samples) const;
  /// Until the error, which is now `error`, is `target`; negative: not known.
  double until_error(double error, double target) const;

 private:
  struct Moment {
    double seconds, samples;
  };
  std::vector<Moment> moments_;  // the first has at most half of the last one's samples
};

}  // namespace ajar
