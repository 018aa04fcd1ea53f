// When a render ends, how many samples its next iteration has, and when its error is estimated.
//
// A render ends after a number of samples, after a time, or at an error, whichever is first. If an error ends it, the
// error is estimated after fixed numbers of samples, so that the image does not depend on the clock.
#pragma once

#include <algorithm>

#include "description/settings.h"
#include "film/image_plan.h"
#include "integrators/integrator.h"
#include "render/clock.h"
#include "render/remaining_time.h"

namespace ajar {

class StoppingPolicy {
 public:
  StoppingPolicy() = default;
  /// `samples_before`: samples of the checkpoint from which this render continues.
  StoppingPolicy(const RenderSettings& settings, double samples_before)
      : settings_(settings), samples_before_(samples_before) {}

  /// Whether the render may end. `samples` are those of this render; `relmse` is estimated, negative if unknown.
  bool enough(double seconds, double samples, double relmse) const;
  /// Samples per pixel of the next iteration: first single ones for a quick image, then as many as take about a third
  /// of a second.
  int next_samples(double seconds, uint64_t done, const ImagePlan* image_plan, const GoalSupport& support) const;
  /// Whether to estimate the error again: because it can end the render, because the render ends now, or because the
  /// estimate takes a small share of the time since the last one.
  bool error_due(double seconds, uint64_t done) const;
  /// Records that the error was estimated, beginning at `start`.
  void error_looked_at(Clock::time_point start);
  /// Fraction of the render that is done, by samples or time, in [0, 1].
  float fraction(double seconds, uint64_t done) const;
  /// Seconds until the first of the ends; negative: unknown.
  double remaining_seconds(double seconds, double relmse) const;

  /// Lowers the number of samples that ends the render, if there is one.
  void limit_samples(int samples) { settings_.samples = std::min(settings_.samples, samples); }

  RemainingTime remaining_time;

 private:
  RenderSettings settings_;
  double samples_before_ = 0.0;
  Clock::time_point last_error_look_;
  double error_look_seconds_ = 0.0;  // duration of the last estimate
};

}  // namespace ajar
