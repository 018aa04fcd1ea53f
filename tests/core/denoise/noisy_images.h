// Images with known noise, and denoisers with a known bias.
#pragma once

#include <cmath>
#include <vector>

#include "denoise/denoise.h"
#include "math/random.h"

namespace ajar::test_denoise {

constexpr int kWidth = 96, kHeight = 64;
constexpr size_t kValues = size_t(kWidth) * kHeight * 3;

/// A gradient with a bright disc of sharp border and one very bright pixel.
inline std::vector<float> truth() {
  std::vector<float> image(kValues);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) {
        const int dx = x - 60, dy = y - 30;
        float value = 0.2f + 0.005f * float(x) + 0.1f * float(c);
        if (dx * dx + dy * dy < 100) value += 1.5f;
        if (x == 20 && y == 20) value = 40.0f;
        image[(size_t(y) * kWidth + size_t(x)) * 3 + size_t(c)] = value;
      }
  return image;
}

struct Rendered {
  std::vector<float> image, halves;
};
/// Makes the image the mean of its halves.
inline void take_mean_of_halves(Rendered& r) {
  for (size_t i = 0; i < kValues; ++i) r.image[i] = 0.5f * (r.halves[i + i / 3 * 3] + r.halves[i + i / 3 * 3 + 3]);
}
/// Gamma-like noise: a few samples with an exponential distribution. `samples` in each half.
inline Rendered rendered(const std::vector<float>& clean, int samples, uint64_t seed) {
  Pcg32 rng(seed);
  Rendered r{std::vector<float>(kValues), std::vector<float>(2 * kValues)};
  for (size_t i = 0; i < kValues; ++i) {
    for (size_t half = 0; half < 2; ++half) {
      double sum = 0.0;
      for (int k = 0; k < samples; ++k) sum -= std::log(1.0 - double(rng.next_float()));
      const float value = clean[i] * float(sum / samples);
      r.halves[6 * (i / 3) + 3 * half + i % 3] = value;
      r.image[i] += 0.5f * value;
    }
  }
  return r;
}
inline double relative_error(const std::vector<float>& image, const std::vector<float>& clean) {
  double sum = 0.0;
  for (size_t i = 0; i < kValues; ++i) {
    const double e = double(image[i]) - double(clean[i]);
    sum += e * e / (double(clean[i]) * double(clean[i]) + 0.01);
  }
  return sum / double(kValues);
}
/// Blurs the image and takes a tenth of its light.
inline std::vector<float> dark_blur(const std::vector<float>& image) {
  std::vector<float> result = image, scratch;
  window_mean(result, {kWidth, kHeight, 3}, 2, scratch);
  for (float& v : result) v *= 0.9f;
  return result;
}

}  // namespace ajar::test_denoise
