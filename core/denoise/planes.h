// Images as sums of planes of details, from fine to coarse, and means over windows.
//
// The decomposition is the undecimated wavelet transform "à trous" with the B3 spline [Starck and Murtagh 1994]: each
// plane is the difference between the image and a smoother one, and the smoother image is decomposed further. Images
// are rows of interleaved channels; beyond the border they are mirrored.
#pragma once

#include <cstddef>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace ajar {

struct ImageSize {
  int width, height, channels;
  size_t values() const { return size_t(width) * size_t(height) * size_t(channels); }
};

/// Calls `work(i)` for each number below `count` in parallel.
template <class Work>
void for_pixels(size_t count, const Work& work) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) work(i);
  });
}
/// Calls `work(y)` for each row in parallel.
template <class Work>
void for_rows(int height, const Work& work) {
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) work(y);
  });
}

/// `result`: the image smoothed with the weights 1, 4, 6, 4, 1 (sixteenths) at a distance of `step` pixels, in both
/// directions.
void smooth(const std::vector<float>& image, ImageSize size, int step, std::vector<float>& result);

/// Replaces the image by its mean over a square of 2 * reach + 1 pixels. Where the square leaves the image, it is
/// smaller. `scratch` is any image; a caller with many images reuses it.
void square_mean(std::vector<float>& image, ImageSize size, int reach, std::vector<float>& scratch);
/// Replaces an image of one channel by its maximum over a square of 2 * reach + 1 pixels.
void square_max(std::vector<float>& image, ImageSize size, int reach, std::vector<float>& scratch);
/// Replaces the image by its mean over a window: the mean over a square, applied twice.
void window_mean(std::vector<float>& image, ImageSize size, int reach, std::vector<float>& scratch);
/// Number of equal weights with the variance of a window's mean, in pixels.
double window_count(int reach);

}  // namespace ajar
