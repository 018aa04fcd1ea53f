#include "denoise/quality.h"

#include <algorithm>

namespace ajar {

namespace {

constexpr double kMaxShare = 0.1;  // of the render

// Seconds of a core for a pixel (1920 x 1080 pixels, guides, AMD EPYC).
constexpr double kGuides = 3.1e-6;  // both, before the large network
constexpr double kLarge = 3.7e-6;   // a run of a network
constexpr double kMedium = 1.55e-6;
constexpr double kSmall = 0.85e-6;
constexpr double kCombination = 0.5e-6;

}  // namespace

DenoisePlan plan_of(DenoiseQuality quality) {
  switch (quality) {
    case DenoiseQuality::High: return {DenoiseNetwork::Large, DenoiseRuns::HalvesAndWhole, true, true};
    case DenoiseQuality::Balanced: return {DenoiseNetwork::Large, DenoiseRuns::Whole, true, true};
    case DenoiseQuality::Fast: return {DenoiseNetwork::Large, DenoiseRuns::Whole, false, false};
    case DenoiseQuality::Fastest: break;
  }
  return {DenoiseNetwork::Medium, DenoiseRuns::Whole, false, false};
}

double denoise_seconds(DenoiseQuality quality, double pixels, bool separates) {
  const DenoisePlan plan = plan_of(quality);
  const double parts = separates && plan.separates ? 2.0 : 1.0, runs = plan.runs == DenoiseRuns::Whole ? 1.0 : 3.0,
               run = plan.network == DenoiseNetwork::Large ? kLarge : kMedium;
  double seconds = parts * (runs * run + kCombination);
  if (plan.network == DenoiseNetwork::Large) seconds += kGuides;
  if (plan.estimates_errors && plan.runs == DenoiseRuns::Whole) seconds += 2.0 * kSmall + kCombination;
  return seconds * pixels;
}

DenoiseQuality denoise_quality_for(double rays, double pixels, double free_seconds, bool separates) {
  const double share = kMaxShare * kDenoiseSecondsPerRay * rays;
  if (denoise_seconds(DenoiseQuality::High, pixels, separates) <= share) return DenoiseQuality::High;
  for (const DenoiseQuality quality : {DenoiseQuality::Balanced, DenoiseQuality::Fast})
    if (denoise_seconds(quality, pixels, separates) <= std::max(share, free_seconds)) return quality;
  return DenoiseQuality::Fastest;
}

}  // namespace ajar
