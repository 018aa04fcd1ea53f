#include "denoise/denoise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "math/types.h"

namespace ajar {

namespace {

constexpr int kNeighbours = 3;            // pixels to each side, in which a bright pixel is compared
constexpr size_t kRank = 3;               // the neighbour with which it is compared, from the brightest
constexpr float kMaxRatio = 3.0f;         // of the brightness of a pixel to that neighbour
constexpr float kDarkest = 0.01f;         // added to squares of light, as in relMSE
constexpr float kUsualNoise = 3.0f;       // times the mean of |m - n| in a window
constexpr double kMinSignificance = 2.5;  // the mean of the products over its standard error, below which g is 0

float luminance_at(const std::vector<float>& image, size_t pixel) {
  return luminance(Color(image[3 * pixel], image[3 * pixel + 1], image[3 * pixel + 2]));
}

template <class Work>
void for_pixels(size_t count, const Work& work) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) work(i);
  });
}

/// What a pixel of a plane tells. With the error e of the denoised image and the noises m and n of the halves, the
/// product (e + m) (e + n) has the noise e (m + n) + m n. `noise` is (m - n)^2, which has the mean of m^2 + n^2.
struct PlanePixel {
  float product, noise, energy;
};
PlanePixel plane_pixel(const std::vector<float>& own, const std::vector<float>& other, float inverse_square, size_t i) {
  double product = 0.0, noise = 0.0, energy = 0.0;
  for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
    const double one = double(own[c]), two = double(other[c]);
    product += one * two;
    noise += (one - two) * (one - two);
    energy += one * one;
  }
  const double scale = double(inverse_square);
  return {float(product * scale), float(noise * scale), float(energy * scale)};
}

/// The weights g of a plane, one for each pixel. `own` is the plane of the residual to which they apply and `other` that
/// of the other half; `inverse_square`: one over the squared light of each pixel.
std::vector<float> weights_of(const std::vector<float>& own, const std::vector<float>& other,
                              const std::vector<float>& inverse_square, int width, int height, int level) {
  const size_t pixels = inverse_square.size();
  const int reach = (4 << level) - 1;
  std::vector<float> roots(2 * pixels);
  for_pixels(pixels, [&](size_t i) {
    const PlanePixel p = plane_pixel(own, other, inverse_square[i], i);
    roots[2 * i] = std::sqrt(p.noise);
    roots[2 * i + 1] = std::sqrt(std::abs(p.product));
  });
  roots = window_mean(roots, {width, height, 2}, reach);
  // A pixel counts less if its noise is far above the usual noise and error of the window, and above its own error.
  std::vector<float> trust(pixels), terms(3 * pixels);
  for_pixels(pixels, [&](size_t i) {
    const PlanePixel p = plane_pixel(own, other, inverse_square[i], i);
    const float noise = roots[2 * i], error = roots[2 * i + 1],
                usual = kUsualNoise * kUsualNoise * noise * noise + error * error + std::abs(p.product);
    const float w = usual > 0.0f ? usual / (usual + p.noise) : 1.0f;
    trust[i] = w;
    terms[3 * i] = w * p.product;
    terms[3 * i + 1] = w * w * p.noise * (std::abs(p.product) + 0.25f * p.noise);  // variance of the product
    terms[3 * i + 2] = w * p.energy;
  });
  const std::vector<float> means = window_mean(terms, {width, height, 3}, reach);
  // Neighbouring values of a plane are correlated over its step.
  const double independent = std::max(1.0, window_count(reach) / double(size_t(1) << (2 * level)));
  for_pixels(pixels, [&](size_t i) {
    const double mean = double(means[3 * i]), energy = double(means[3 * i + 2]),
                 variance = double(means[3 * i + 1]) / independent;
    const double safe = mean > 0.0 ? mean - kMinSignificance * kMinSignificance * variance / mean : 0.0;
    trust[i] *= energy > 0.0 ? float(std::clamp(safe / energy, 0.0, 1.0)) : 0.0f;
  });
  return trust;
}

std::vector<float> difference(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<float> result(a.size());
  for_pixels(a.size(), [&](size_t i) { result[i] = a[i] - b[i]; });
  return result;
}

/// `denoised` plus the part of (own - denoised) that is not noise. `other`: the half that was denoised.
std::vector<float> corrected(std::vector<float> denoised, const std::vector<float>& own,
                             const std::vector<float>& other, const std::vector<float>& inverse_square, int width,
                             int height) {
  std::vector<float> own_rest = difference(own, denoised), other_rest = difference(other, denoised);
  const ImageSize size{width, height, 3};
  const int planes = plane_count(width, height);
  for (int level = 0; level <= planes; ++level) {
    std::vector<float> own_smooth, other_smooth;
    if (level < planes) {
      own_smooth = smoothed(own_rest, size, 1 << level);
      other_smooth = smoothed(other_rest, size, 1 << level);
      own_rest = difference(own_rest, own_smooth);
      other_rest = difference(other_rest, other_smooth);
    }
    const std::vector<float> weights = weights_of(own_rest, other_rest, inverse_square, width, height, level);
    for_pixels(denoised.size(), [&](size_t i) { denoised[i] += weights[i / 3] * own_rest[i]; });
    own_rest = std::move(own_smooth);
    other_rest = std::move(other_smooth);
  }
  return denoised;
}

/// The denoiser's image of non-negative light. Light of negative lamps is added again as it is.
std::vector<float> run(const DenoiseFunction& denoiser, std::vector<float> image) {
  std::vector<float> below(image.size());
  bool any_below = false;
  for (size_t i = 0; i < image.size(); ++i) {
    if (!(image[i] < 0.0f)) continue;
    below[i] = image[i];
    image[i] = 0.0f;
    any_below = true;
  }
  image = denoiser(std::move(image));
  if (any_below)
    for (size_t i = 0; i < image.size(); ++i) image[i] += below[i];
  return image;
}

}  // namespace

int plane_count(int width, int height) {
  int count = 1;
  while ((8 << count) <= std::min(width, height)) ++count;
  return count;
}

std::vector<float> limited(const std::vector<float>& image, const std::vector<float>& other, int width, int height) {
  std::vector<float> result = image;
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y)
      for (int x = 0; x < width; ++x) {
        std::array<float, kRank> brightest{};
        for (int v = std::max(0, y - kNeighbours); v <= std::min(height - 1, y + kNeighbours); ++v)
          for (int u = std::max(0, x - kNeighbours); u <= std::min(width - 1, x + kNeighbours); ++u) {
            if (u == x && v == y) continue;
            float value = luminance_at(image, size_t(v) * size_t(width) + size_t(u));
            for (float& place : brightest)
              if (value > place) std::swap(value, place);
          }
        const size_t pixel = size_t(y) * size_t(width) + size_t(x);
        const float limit = std::max(kMaxRatio * brightest.back(), luminance_at(other, pixel)),
                    own = luminance_at(image, pixel);
        if (own > limit)
          for (size_t c = 3 * pixel; c < 3 * pixel + 3; ++c) result[c] *= limit / own;
      }
  });
  return result;
}

std::vector<float> denoise(const std::vector<float>& image, const std::vector<float>& halves, int width, int height,
                           const DenoiseFunction& denoiser) {
  const size_t pixels = size_t(width) * size_t(height);
  if (halves.empty() || std::any_of(halves.begin(), halves.end(), [](float v) { return std::isnan(v); }))
    return run(denoiser, image);
  std::vector<float> a(3 * pixels), b(3 * pixels);
  for_pixels(pixels, [&](size_t i) {
    for (size_t c = 0; c < 3; ++c) {
      a[3 * i + c] = halves[6 * i + c];
      b[3 * i + c] = halves[6 * i + 3 + c];
    }
  });
  std::vector<float> from_a = run(denoiser, limited(a, b, width, height)),
                     from_b = run(denoiser, limited(b, a, width, height));
  std::vector<float> inverse_square(pixels);
  for_pixels(pixels, [&](size_t i) {
    const float light = 0.5f * (luminance_at(from_a, i) + luminance_at(from_b, i));
    inverse_square[i] = 1.0f / (light * light + kDarkest);
  });
  std::vector<float> result = corrected(std::move(from_a), b, a, inverse_square, width, height);
  const std::vector<float> second = corrected(std::move(from_b), a, b, inverse_square, width, height);
  // A residual can be larger than the light. Only negative lamps make an image negative.
  for_pixels(result.size(),
             [&](size_t i) { result[i] = std::max(0.5f * (result[i] + second[i]), std::min(0.0f, image[i])); });
  return result;
}

}  // namespace ajar
