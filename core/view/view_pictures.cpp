#include "view/view_pictures.h"

#include <algorithm>
#include <cmath>

#include "denoise/denoise.h"
#include "denoise/quality.h"

namespace ajar {

namespace {

constexpr int kSkips = 6;               // largest divider after which light of half the resolution follows at once
constexpr size_t kMaxKept = 4;          // networks
constexpr double kMeasuredShare = 0.5;  // of the newest measurement in what is expected
constexpr int kDividers[] = {1, 2, 3, 4, 6, 8, 12, ViewSchedule::kCoarsest};

int divided_up(int value, int divider) { return (value + divider - 1) / divider; }

void measure(double& expected, double seconds) { expected += kMeasuredShare * (std::max(seconds, 1e-9) - expected); }

}  // namespace

ViewSize divided(int width, int height, const std::array<int, 4>& region, int divider) {
  const int across = std::max(1, divided_up(width, divider)), up = std::max(1, divided_up(height, divider));
  const int left = std::min(region[0] / divider, across - 1), bottom = std::min(region[1] / divider, up - 1);
  return {across,
          up,
          {left, bottom, std::clamp(divided_up(region[2], divider), left + 1, across),
           std::clamp(divided_up(region[3], divider), bottom + 1, up)}};
}

void ViewSchedule::rendered(double pixels, double samples, double seconds) {
  if (pixels > 0.0 && samples > 0.0) measure(seconds_of_sample_, seconds / (pixels * samples));
}

void ViewSchedule::denoised(double pixels, double seconds) {
  if (pixels > 0.0) measure(seconds_of_network_, seconds / pixels);
}

ViewLevel ViewSchedule::first(double pixels) const {
  for (const int divider : kDividers)
    if (expected_seconds(pixels / (divider * divider)) <= kFirstSeconds) return {divider, false};
  return {kCoarsest, false};
}

ViewLevel ViewSchedule::finer(ViewLevel level, double pixels, bool guided) const {
  if (level.divider <= 2 || expected_seconds(pixels) <= kNextSeconds) return {1, false};
  if (level.divider <= kSkips || expected_seconds(pixels / 4) <= kNextSeconds) return {2, guided};
  return {level.divider / 2, false};
}

PreparedDenoiser& ViewDenoiser::network_for(const DenoiserInput& input, DenoiseNetwork kind, int threads) {
  const bool guided = !input.albedo.empty() && !input.normal.empty();
  const auto fits = [&](const Kept& k) {
    return k.width == input.width && k.height == input.height && k.threads == threads && k.guided == guided &&
           k.kind == kind;
  };
  const auto found = std::find_if(kept_.begin(), kept_.end(), fits);
  if (found != kept_.end()) {
    kept_.splice(kept_.begin(), kept_, found);
  } else {
    if (kept_.size() >= kMaxKept) kept_.pop_back();
    auto network = std::make_unique<PreparedDenoiser>(input.width, input.height, guided, kind, threads);
    kept_.push_front({input.width, input.height, threads, guided, kind, std::move(network)});
  }
  return *kept_.front().network;
}

std::vector<float> ViewDenoiser::operator()(const DenoiserInput& input, double samples, double rays, int threads,
                                            const std::atomic<bool>& stop) {
  const bool consistent = samples >= kConsistentSamples;
  const DenoiseQuality quality = denoise_quality_for(rays, double(input.width) * double(input.height), 0.0, false);
  const DenoisePlan plan = consistent ? plan_of(quality)
                                      : DenoisePlan{DenoiseNetwork::Small, DenoiseRuns::Whole, false, false};
  const std::vector<float> none;
  const std::vector<float>&image = rgb_of(input.combined), &halves = consistent ? input.halves : none;
  const NoisyImage noisy{image, halves, {}, input.width, input.height, {}, input.exposure};
  Denoised result;
  if (plan.network == DenoiseNetwork::Large) {
    const OpenImageDenoise library(input.width, input.height, input.albedo, input.normal, plan.network, threads, stop);
    result = denoise(noisy, std::cref(library), plan.runs);
  } else {
    PreparedDenoiser& network = network_for(input, plan.network, threads);
    network.set_guides(input.albedo, input.normal);
    result = denoise(
        noisy, [&](std::vector<float> one) { return network(std::move(one), stop); }, plan.runs);
  }
  std::vector<float> rgba = input.combined;
  for (size_t i = 0; i < rgba.size() / 4; ++i) std::copy_n(&result.image[3 * i], 3, &rgba[4 * i]);
  return rgba;
}

}  // namespace ajar
