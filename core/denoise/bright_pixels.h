// Pixels that are far brighter than the denoised light around them: details that the denoiser has lost, or light that
// samples find rarely. Two independent halves of the samples separate them. They agree about the place of a detail, and
// about the place of rare light only by chance.
#pragma once

#include <vector>

#include "denoise/planes.h"
#include "denoise/technique_images.h"

namespace ajar {

/// Bright pixels of an image.
struct BrightPixels {
  /// 1 for pixels that are bright in both halves, but not more often than two independent halves are by chance, and not
  /// brighter than what one half has around; else 0. Their halves agree, so that they look like details.
  std::vector<float> by_chance;
  /// 1 for pixels of small bright details, else 0: the halves have bright pixels in the same places more often than in
  /// places at some distance; or both are bright in this pixel, and not by chance.
  std::vector<float> detail;
  /// Of a detail: the weight of the halves, e^2 / (e^2 + noise), with the energy e^2 of the denoiser's error and that of
  /// the noise over the pixels of details around; else 0.
  std::vector<float> detail_weight;
};
/// `light_a`, `light_b`: the denoised halves. `size`: of an image, RGB.
BrightPixels bright_pixels_of(const Halves& halves, const std::vector<float>& light_a,
                              const std::vector<float>& light_b, ImageSize size);

}  // namespace ajar
