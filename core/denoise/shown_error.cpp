#include "denoise/shown_error.h"

#include <functional>
#include <stdexcept>

#include "denoise/denoise.h"
#include "denoise/open_image_denoise.h"
#include "math/statistics.h"

namespace ajar {

double shown_relmse(const DenoiserInput& input, int threads, const std::atomic<bool>& stop) {
  if (OpenImageDenoise::version().empty()) return -1.0;
  Denoised image;
  try {
    const OpenImageDenoise library(input.width, input.height, input.albedo, input.normal, DenoiseQuality::Fast, threads,
                                   stop);
    const std::vector<float> rgb = rgb_of(input.combined);
    image = denoise({rgb, input.halves, input.direct_halves, input.width, input.height}, std::cref(library), false);
  } catch (const std::runtime_error&) {
    return -1.0;  // the owner reports the failure when it denoises the final image
  }
  if (image.error.empty()) return -1.0;
  CompensatedSum sum;
  for (const float error : image.error) sum.add(double(error));
  return sum.value() / double(image.error.size());
}

}  // namespace ajar
