// A part of the light that is expected to be small and that costs walks of its own. A sample looks for it with a
// probability, by which what it finds is divided, so that the probability does not change the mean. The probability of a
// sample follows from the samples before it.
#pragma once

#include <algorithm>
#include <cstdint>

#include "math/relative_error.h"
#include "math/types.h"

namespace ajar {

class RareLight {
 public:
  static constexpr float kFirst = 0.25f;  ///< the probability before anything is known

  /// Luminances are compared as displayed, so that units do not matter.
  explicit RareLight(float exposure = 1.0f) : exposure_(exposure) {}
  /// A sample has found this other light.
  void note_sample(Color other) {
    ++samples_;
    other_light_ += units(double(luminance(glm::abs(other))) * double(exposure_));
  }
  /// A sample that looked for the light with this probability has found this estimate of it.
  void note_found(Color estimate, uint64_t rays, float probability) {
    const double light = double(luminance(estimate)) * double(exposure_);
    squared_ += units(light * light * double(probability));
    expected_rays_ += units(double(rays) / double(probability));
  }
  void add(const RareLight& other) {
    samples_ += other.samples_;
    other_light_ += other.other_light_;
    squared_ += other.squared_;
    expected_rays_ += other.expected_rays_;
  }

  uint64_t samples() const { return samples_; }
  /// The probability for the next samples. `affordable`: rays that all samples so far might have used for this light.
  float probability(double affordable) const {
    // The variance of one sample relative to the squared luminance of the picture plus 0.01. Less is hidden by the noise
    // of the other light.
    constexpr double kVariance = 0.02, kLeast = 1.0 / 64.0;
    if (samples_ == 0) return kFirst;
    const double of_unit = 1.0 / (kUnits * double(samples_)), mean = of_unit * double(other_light_),
                 variance = of_unit * double(squared_) / (mean * mean + kDarkSquared),
                 rays = double(expected_rays_) / kUnits, possible = rays > affordable ? affordable / rays : 1.0;
    return float(std::clamp(variance / kVariance, kLeast, std::max(kLeast, possible)));
  }

 private:
  static constexpr double kUnits = 0x1p16, kLargest = 0x1p15;
  /// The sums are integers, so that they do not depend on the order of threads. Values that are not finite count as 0.
  static uint64_t units(double value) { return uint64_t(kUnits * std::min(value == value ? value : 0.0, kLargest)); }

  float exposure_;
  uint64_t samples_ = 0, other_light_ = 0;    ///< sum of the luminances of the other light of the samples
  uint64_t squared_ = 0, expected_rays_ = 0;  ///< sums of squared luminances and of rays, if all samples looked for it
};

}  // namespace ajar
