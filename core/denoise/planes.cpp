#include "denoise/planes.h"

#include <algorithm>
#include <cstdlib>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace ajar {

namespace {

/// Index of the pixel that the mirrored image shows at i.
int mirrored(int i, int count) {
  const int period = 2 * count;
  i = ((i % period) + period) % period;
  return i < count ? i : period - 1 - i;
}

/// Calls `work(y)` for each row in parallel.
template <class Work>
void for_rows(int height, const Work& work) {
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) work(y);
  });
}

/// One pass of a square window, with running sums.
std::vector<float> square_mean(const std::vector<float>& image, ImageSize size, int reach) {
  const auto& [w, h, channels] = size;
  const size_t row = size_t(w) * size_t(channels);
  std::vector<float> across(size.values()), result(size.values());
  for_rows(h, [&, w = w, channels = channels](int y) {
    const float* in = image.data() + size_t(y) * row;
    float* out = across.data() + size_t(y) * row;
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
        for (size_t i = first; i < last; ++i) sums[i - first] += sign * double(across[size_t(y) * row + i]);
      };
      for (int y = 0; y <= std::min(reach, h - 1); ++y) add(y, 1.0);
      for (int y = 0; y < h; ++y) {
        const double count = std::min(h - 1, y + reach) - std::max(0, y - reach) + 1;
        for (size_t i = first; i < last; ++i) result[size_t(y) * row + i] = float(sums[i - first] / count);
        if (y + reach + 1 < h) add(y + reach + 1, 1.0);
        if (y - reach >= 0) add(y - reach, -1.0);
      }
    }
  });
  return result;
}

}  // namespace

std::vector<float> smoothed(const std::vector<float>& image, ImageSize size, int step) {
  const auto& [w, h, channels] = size;
  const size_t row = size_t(w) * size_t(channels);
  std::vector<float> across(size.values()), result(size.values());
  constexpr float kWeights[5] = {0.0625f, 0.25f, 0.375f, 0.25f, 0.0625f};
  for_rows(h, [&, w = w, channels = channels](int y) {
    const float* in = image.data() + size_t(y) * row;
    float* out = across.data() + size_t(y) * row;
    for (int x = 0; x < w; ++x) {
      for (int c = 0; c < channels; ++c) out[x * channels + c] = 0.0f;
      for (int k = 0; k < 5; ++k) {
        const int from = mirrored(x + (k - 2) * step, w);
        for (int c = 0; c < channels; ++c) out[x * channels + c] += kWeights[k] * in[from * channels + c];
      }
    }
  });
  for_rows(h, [&, h = h](int y) {
    float* out = result.data() + size_t(y) * row;
    for (int k = 0; k < 5; ++k) {
      const float* in = across.data() + size_t(mirrored(y + (k - 2) * step, h)) * row;
      for (size_t i = 0; i < row; ++i) out[i] += kWeights[k] * in[i];
    }
  });
  return result;
}

std::vector<float> window_mean(const std::vector<float>& image, ImageSize size, int reach) {
  return square_mean(square_mean(image, size, reach), size, reach);
}

double window_count(int reach) {
  // A square applied twice is a triangle in each direction. The sum of its squared weights is 2 / (3 width).
  const double width = 2.0 * reach + 1.0;
  return 2.25 * width * width;
}

}  // namespace ajar
