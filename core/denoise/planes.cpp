#include "denoise/planes.h"

#include <algorithm>
#include <cstdlib>

#include <tbb/enumerable_thread_specific.h>

namespace ajar {

namespace {

/// Index of the pixel that the mirrored image shows at i.
int mirrored(int i, int count) {
  const int period = 2 * count;
  i = ((i % period) + period) % period;
  return i < count ? i : period - 1 - i;
}

}  // namespace

void square_mean(std::vector<float>& image, ImageSize size, int reach, std::vector<float>& scratch) {
  const auto& [w, h, channels] = size;
  const size_t row = size_t(w) * size_t(channels);
  scratch.resize(size.values());
  for_rows(h, [&, w = w, channels = channels](int y) {
    const float* in = image.data() + size_t(y) * row;
    float* out = scratch.data() + size_t(y) * row;
    for (int c = 0; c < channels; ++c) {
      double sum = 0.0;
      for (int x = 0; x <= std::min(reach, w - 1); ++x) sum += double(in[x * channels + c]);
      for (int x = 0; x < w; ++x) {
        out[x * channels + c] = float(sum / (std::min(w - 1, x + reach) - std::max(0, x - reach) + 1));
        if (x + reach + 1 < w) sum += double(in[(x + reach + 1) * channels + c]);
        if (x - reach >= 0) sum -= double(in[(x - reach) * channels + c]);
      }
    }
  });
  constexpr size_t kColumns = 64;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, (row + kColumns - 1) / kColumns), [&, h = h](const auto& blocks) {
    for (size_t block = blocks.begin(); block < blocks.end(); ++block) {
      const size_t first = block * kColumns, last = std::min(row, first + kColumns);
      std::vector<double> sums(last - first, 0.0);
      const auto add = [&](int y, double sign) {
        for (size_t i = first; i < last; ++i) sums[i - first] += sign * double(scratch[size_t(y) * row + i]);
      };
      for (int y = 0; y <= std::min(reach, h - 1); ++y) add(y, 1.0);
      for (int y = 0; y < h; ++y) {
        const double count = std::min(h - 1, y + reach) - std::max(0, y - reach) + 1;
        for (size_t i = first; i < last; ++i) image[size_t(y) * row + i] = float(sums[i - first] / count);
        if (y + reach + 1 < h) add(y + reach + 1, 1.0);
        if (y - reach >= 0) add(y - reach, -1.0);
      }
    }
  });
}

void smooth(const std::vector<float>& image, ImageSize size, int step, std::vector<float>& result) {
  const auto& [w, h, channels] = size;
  const size_t row = size_t(w) * size_t(channels), between = size_t(step) * size_t(channels);
  result.resize(size.values());
  tbb::enumerable_thread_specific<std::vector<float>> wide([&] { return std::vector<float>(row + 4 * between); });
  const auto weighted = [](float a, float b, float c, float d, float e) {
    return 0.0625f * (a + e) + 0.25f * (b + d) + 0.375f * c;
  };
  for_rows(h, [&, w = w, h = h, channels = channels](int y) {
    const float* in[5];
    for (int k = 0; k < 5; ++k) in[k] = image.data() + size_t(mirrored(y + (k - 2) * step, h)) * row;
    // The row between its mirror images.
    float *const begin = wide.local().data(), *const middle = begin + 2 * between;
    for (size_t i = 0; i < row; ++i) middle[i] = weighted(in[0][i], in[1][i], in[2][i], in[3][i], in[4][i]);
    for (int x = -2 * step; x < w + 2 * step; x += x == -1 ? w + 1 : 1)
      std::copy_n(middle + mirrored(x, w) * channels, channels, middle + x * channels);
    float* const out = result.data() + size_t(y) * row;
    for (size_t i = 0; i < row; ++i)
      out[i] = weighted(begin[i], begin[i + between], middle[i], middle[i + between], middle[i + 2 * between]);
  });
}

void square_max(std::vector<float>& image, ImageSize size, int reach, std::vector<float>& scratch) {
  const auto at = [w = size_t(size.width)](int x, int y) { return size_t(y) * w + size_t(x); };
  scratch = image;
  for_rows(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x)
      for (int u = std::max(0, x - reach); u <= std::min(size.width - 1, x + reach); ++u)
        scratch[at(x, y)] = std::max(scratch[at(x, y)], image[at(u, y)]);
  });
  for_rows(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      image[at(x, y)] = scratch[at(x, y)];
      for (int v = std::max(0, y - reach); v <= std::min(size.height - 1, y + reach); ++v)
        image[at(x, y)] = std::max(image[at(x, y)], scratch[at(x, v)]);
    }
  });
}

void window_mean(std::vector<float>& image, ImageSize size, int reach, std::vector<float>& scratch) {
  for (int pass = 0; pass < 2; ++pass) square_mean(image, size, reach, scratch);
}

double window_count(int reach) {
  // A square applied twice is a triangle in each direction. The sum of its squared weights is 2 / (3 width).
  const double width = 2.0 * reach + 1.0;
  return 2.25 * width * width;
}

}  // namespace ajar
