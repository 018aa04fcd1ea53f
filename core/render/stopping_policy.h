// When a render ends, how many samples its next iteration takes, and when its error is looked at.
//
// A render ends after so many samples, after a time, or at an error, whichever comes first. With an error as its end it
// looks at it after fixed numbers of samples, so that the clock has no say in the picture.
#pragma once

#include "description/settings.h"
#include "film/image_plan.h"
#include "integrators/integrator.h"
#include "render/clock.h"
#include "render/remaining_time.h"

namespace ajar {

class StoppingPolicy {
 public:
  StoppingPolicy() = default;
  /// `samples_before`: of the render that this one goes on from.
  StoppingPolicy(const RenderSettings& settings, double samples_before)
      : settings_(settings), samples_before_(samples_before) {}

  /// Whether the render may end. `samples` of this render; `relmse` as estimated, negative when it is not known.
  bool enough(double seconds, double samples, double relmse) const;
  /// Samples a pixel for the next iteration: first single ones for a quick picture, then as many as last about a third
  /// of a second.
  int next_samples(double seconds, uint64_t done, const ImagePlan* image_plan, const GoalSupport& support) const;
  /// Whether to look at the error again: the render may stop by it, it may be the last time, or looking takes a small
  /// share of the time since.
  bool error_due(double seconds, uint64_t done) const;
  /// The error was looked at, from `start` on.
  void error_looked_at(Clock::time_point start);
  /// Share of the render that is done by samples or time, in [0, 1].
  float fraction(double seconds, uint64_t done) const;
  /// Until the first of the ends; negative: not known.
  double remaining_seconds(double seconds, double relmse) const;

  RemainingTime remaining_time;

 private:
  RenderSettings settings_;
  double samples_before_ = 0.0;
  Clock::time_point last_error_look_;
  double error_look_seconds_ = 0.0;  // what the last look took
};

}  // namespace ajar
