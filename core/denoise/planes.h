// Images as sums of planes of details, from fine to coarse, and means over windows.
//
// The decomposition is the undecimated wavelet transform "à trous" with the B3 spline [Starck and Murtagh 1994]: each
// plane is the difference between the image and a smoother one, and the smoother image is decomposed further. Images
// are rows of interleaved channels; beyond the border they are mirrored.
#pragma once

#include <cstddef>
#include <vector>

namespace ajar {

struct ImageSize {
  int width, height, channels;
  size_t values() const { return size_t(width) * size_t(height) * size_t(channels); }
};

/// The image smoothed with the weights 1, 4, 6, 4, 1 (sixteenths) at a distance of `step` pixels, in both directions.
std::vector<float> smoothed(const std::vector<float>& image, ImageSize size, int step);

/// Mean over a window: a square of 2 * reach + 1 pixels, applied twice. Where the window leaves the image, it is smaller.
std::vector<float> window_mean(const std::vector<float>& image, ImageSize size, int reach);
/// Number of equal weights with the variance of a window's mean, in pixels.
double window_count(int reach);

}  // namespace ajar
