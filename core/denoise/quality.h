// How much time the denoising of a picture may take, and what is done in it.
//
// Measured steps (docs/research/denoising.md): a large network instead of a smaller one lowers the error most, then direct
// light apart from the rest, then a run for each half of the samples.
#pragma once

#include "denoise/denoise.h"
#include "denoise/open_image_denoise.h"

namespace ajar {

enum class DenoiseQuality {
  High,      ///< a large network, for each half of the samples; direct light and the rest apart
  Balanced,  ///< a large network, once for direct light and once for the rest; the error is estimated by a small one
  Fast,      ///< a large network, once for the picture
  Fastest    ///< a smaller network, once for the picture
};

/// What a quality does.
struct DenoisePlan {
  DenoiseNetwork network;
  DenoiseRuns runs;
  bool separates;         ///< direct light is denoised apart
  bool estimates_errors;  ///< also where nobody asks for them
};
DenoisePlan plan_of(DenoiseQuality quality);

/// The best quality that takes at most a tenth of a render with this number of rays, or, except High, `free_seconds` of a
/// core. It follows from fixed costs, not from the clock: frames of different machines agree. `separates`: the picture
/// has direct light apart, which takes twice the time with High and half as long again with Balanced.
DenoiseQuality denoise_quality_for(double rays, double pixels, double free_seconds, bool separates);
/// Seconds of a core that this quality is expected to take. As `denoise_quality_for` assumes.
double denoise_seconds(DenoiseQuality quality, double pixels, bool separates);
constexpr double kDenoiseSecondsPerRay = 0.5e-6;  ///< of a core, as `denoise_quality_for` assumes

}  // namespace ajar
