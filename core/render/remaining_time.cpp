#include "render/remaining_time.h"

#include <algorithm>
#include <cmath>

namespace ajar {

void RemainingTime::begin(double seconds) { moments_.assign(1, {seconds, 0.0}); }

void RemainingTime::add(double seconds, double samples) {
  if (moments_.empty()) begin(0.0);
  moments_.push_back({seconds, samples});
  size_t first = 0;
  while (first + 2 < moments_.size() && 2.0 * moments_[first + 1].samples <= samples) ++first;
  moments_.erase(moments_.begin(), moments_.begin() + std::ptrdiff_t(first));
}

double RemainingTime::seconds_per_sample() const {
  if (moments_.size() < 2) return -1.0;
  const Moment &first = moments_.front(), &last = moments_.back();
  return last.samples > first.samples ? std::max(0.0, last.seconds - first.seconds) / (last.samples - first.samples)
                                      : -1.0;
}

double RemainingTime::until_samples(double samples) const {
  const double pace = seconds_per_sample();
  return pace < 0.0 ? -1.0 : pace * std::max(0.0, samples - moments_.back().samples);
}

double RemainingTime::until_error(double error, double target) const {
  if (!(error > 0.0) || !(target > 0.0) || moments_.empty()) return -1.0;
  return until_samples(std::max(kMinSamples, moments_.back().samples * std::pow(error / target, 1.0 / kErrorExponent)));
}

}  // namespace ajar
