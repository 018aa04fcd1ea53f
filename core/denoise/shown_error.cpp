#include "denoise/shown_error.h"

#include <functional>
#include <stdexcept>

#include "denoise/denoise.h"
#include "denoise/open_image_denoise.h"
#include "math/statistics.h"

namespace ajar {

namespace {

/// What `estimate` finds with the fastest denoiser; empty if there is none or if it fails. The owner reports a failure
/// when it denoises the final image.
template <class Estimate>
auto with_denoiser(const DenoiserInput& input, int threads, const std::atomic<bool>& stop, const Estimate& estimate) {
  decltype(estimate(DenoiseFunction())) none;
  if (OpenImageDenoise::version().empty()) return none;
  try {
    const OpenImageDenoise library(input.width, input.height, input.albedo, input.normal, DenoiseNetwork::Small,
                                   threads, stop);
    return estimate(std::cref(library));
  } catch (const std::runtime_error&) {
    return none;
  }
}

}  // namespace

double shown_relmse(const DenoiserInput& input, int threads, const std::atomic<bool>& stop) {
  const std::vector<float> rgb = rgb_of(input.combined);
  const std::vector<float> error = with_denoiser(input, threads, stop, [&](const DenoiseFunction& denoiser) {
    return denoise({rgb, input.halves, input.direct_halves, input.width, input.height, input.biased, input.exposure},
                   denoiser, DenoiseRuns::Halves)
        .error;
  });
  if (error.empty()) return -1.0;
  CompensatedSum sum;
  for (const float e : error) sum.add(double(e));
  return sum.value() / double(error.size());
}

std::vector<double> relmse_of_techniques(const DenoiserInput& input, int threads, const std::atomic<bool>& stop) {
  const std::vector<float> rgb = rgb_of(input.combined);
  return with_denoiser(input, threads, stop, [&](const DenoiseFunction& denoiser) {
    return technique_errors({rgb, input.halves, {}, input.width, input.height, input.biased, input.exposure}, denoiser);
  });
}

}  // namespace ajar
