#include "render/stopping_policy.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace ajar {

namespace {

constexpr double kErrorShare = 0.02;  // maximum share of the time of a render for estimates of its error

}  // namespace

bool StoppingPolicy::enough(double seconds, double samples, double relmse) const {
  if (settings_.samples > 0 && samples_before_ + samples >= double(settings_.samples)) return true;
  if (settings_.seconds > 0.0 && seconds >= settings_.seconds) return true;
  return settings_.target_error > 0.0 && relmse >= 0.0 && samples >= RemainingTime::kMinSamples &&
         relmse <= settings_.target_error;
}

int StoppingPolicy::next_samples(double seconds, uint64_t done, const ImagePlan* image_plan,
                                 const GoalSupport& support) const {
  double next = double(std::max<uint64_t>(1, done));
  if (done > 0 && seconds > 0.0) {
    const double rate = double(done) / seconds;
    next = std::min(next, std::max(1.0, rate * 0.33));
    if (settings_.seconds > 0.0) next = std::min(next, std::max(1.0, rate * (settings_.seconds - seconds)));
  }
  if (settings_.samples > 0) next = std::min(next, double(settings_.samples) - samples_before_ - double(done));
  if (image_plan) {
    if (support.by_passes) return 1;
    next = std::min(next, double(image_plan->next_decision(uint32_t(done))) - double(done));
    if (done < support.equal) next = std::min(next, double(support.equal / 4 - done % (support.equal / 4)));
  }
  // Errors are estimated from images with 2^k samples.
  next = std::min(next, double(std::bit_ceil(done + 1)) - double(done));
  // If an error ends the render, it is estimated after fixed numbers of samples, so that the image does not depend on
  // the clock.
  if (settings_.target_error > 0.0) {
    const uint64_t step = std::max<uint64_t>(1, std::bit_floor(std::max<uint64_t>(1, done)) / 8);
    next = std::min(next, double(step - done % step));
  }
  return std::max(1, int(next));
}

bool StoppingPolicy::error_due(double seconds, uint64_t done) const {
  return settings_.target_error > 0.0 || std::has_single_bit(done) || enough(seconds, double(done), -1.0) ||
         error_look_seconds_ < kErrorShare * seconds_since(last_error_look_);
}

double StoppingPolicy::remaining_seconds(double seconds, double relmse) const {
  double min_left = kInfinity;
  const auto consider = [&](double left) {
    if (left >= 0.0) min_left = std::min(min_left, left);
  };
  if (settings_.samples > 0) consider(remaining_time.until_samples(double(settings_.samples) - samples_before_));
  if (settings_.seconds > 0.0) consider(std::max(0.0, settings_.seconds - seconds));
  consider(remaining_time.until_error(relmse, settings_.target_error));
  return std::isfinite(min_left) ? min_left : -1.0;
}

void StoppingPolicy::error_looked_at(Clock::time_point start) {
  error_look_seconds_ = seconds_since(start);
  last_error_look_ = Clock::now();
}

float StoppingPolicy::fraction(double seconds, uint64_t done) const {
  float fraction = 0.0f;
  if (settings_.samples > 0) fraction = float((samples_before_ + double(done)) / settings_.samples);
  if (settings_.seconds > 0.0) fraction = std::max(fraction, float(seconds / settings_.seconds));
  return std::min(1.0f, fraction);
}

}  // namespace ajar
