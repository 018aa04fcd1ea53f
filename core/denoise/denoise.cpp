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

/// Images of the relative error, as fractions of the light of each pixel, or one plane of them.
struct Residuals {
  std::vector<float> first, second;  ///< B - D(A) and A - D(B)
  std::vector<float> halves;         ///< A - B
  std::vector<float> mean;           ///< N - D

  std::array<std::vector<float>*, 4> all() { return {&first, &second, &halves, &mean}; }
};

/// What a pixel of a plane tells: the energies of the residuals and of A - B, and the product of the residuals of D(A).
struct PlanePixel {
  float energy = 0.0f, noise = 0.0f, product = 0.0f;
};
PlanePixel plane_pixel(const Residuals& plane, size_t i) {
  PlanePixel p;
  for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
    const float one = plane.first[c], two = plane.second[c], n = plane.halves[c];
    p.energy += 0.5f * (one * one + two * two);
    p.noise += n * n;
    p.product += 0.5f * (one * (one + n) + two * (two - n));  // A - D(A) is B - D(A) + (A - B)
  }
  p.product = std::abs(p.product);
  return p;
}

/// The weights g of a plane, one for each pixel.
std::vector<float> weights_of(const Residuals& plane, int width, int height, int level) {
  const size_t pixels = size_t(width) * size_t(height);
  const int reach = (4 << level) - 1;
  std::vector<float> roots(2 * pixels);
  for_pixels(pixels, [&](size_t i) {
    const PlanePixel p = plane_pixel(plane, i);
    roots[2 * i] = std::sqrt(p.noise);
    roots[2 * i + 1] = std::sqrt(p.product);
  });
  roots = window_mean(roots, {width, height, 2}, reach);
  // A pixel counts less if its noise is far above the usual noise and error of the window, and above its own error.
  std::vector<float> trust(pixels), terms(3 * pixels);
  for_pixels(pixels, [&](size_t i) {
    const PlanePixel p = plane_pixel(plane, i);
    const float noise = roots[2 * i], error = roots[2 * i + 1],
                usual = kUsualNoise * kUsualNoise * noise * noise + error * error + p.product;
    const float w = usual > 0.0f ? usual / (usual + p.noise) : 1.0f;
    trust[i] = w;
    terms[3 * i] = w * (p.energy - 0.5f * p.noise);
    terms[3 * i + 1] = w * w * p.noise * (p.product + 0.25f * p.noise);  // variance
    terms[3 * i + 2] = w * p.noise;
  });
  const std::vector<float> means = window_mean(terms, {width, height, 3}, reach);
  // Neighbouring values of a plane are correlated over its step.
  const double independent = std::max(1.0, window_count(reach) / double(size_t(1) << (2 * level)));
  for_pixels(pixels, [&](size_t i) {
    const double mean = double(means[3 * i]), variance = double(means[3 * i + 1]) / independent,
                 noise_of_mean = 0.25 * double(means[3 * i + 2]);
    const double error = mean > 0.0 ? mean - kMinSignificance * kMinSignificance * variance / mean : 0.0;
    trust[i] *= error > 0.0 ? float(error / (error + std::max(0.0, noise_of_mean))) : 0.0f;
  });
  return trust;
}

/// The sum of the planes of the mean residual, with their weights.
std::vector<float> significant_part(Residuals rest, int width, int height) {
  const ImageSize size{width, height, 3};
  const int planes = plane_count(width, height);
  std::vector<float> sum(size.values());
  for (int level = 0; level <= planes; ++level) {
    Residuals smooth;
    for (size_t k = 0; k < 4 && level < planes; ++k) {
      std::vector<float>&of_rest = *rest.all()[k], &of_smooth = *smooth.all()[k];
      of_smooth = smoothed(of_rest, size, 1 << level);
      for_pixels(size.values(), [&](size_t i) { of_rest[i] -= of_smooth[i]; });
    }
    const std::vector<float> weights = weights_of(rest, width, height, level);
    for_pixels(size.values(), [&](size_t i) { sum[i] += weights[i / 3] * rest.mean[i]; });
    rest = std::move(smooth);
  }
  return sum;
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
  std::vector<float> light(pixels);
  for_pixels(pixels, [&](size_t i) {
    const float y = 0.5f * (luminance_at(from_a, i) + luminance_at(from_b, i));
    light[i] = std::sqrt(y * y + kDarkest);
  });
  const size_t values = 3 * pixels;
  Residuals residuals{std::vector<float>(values), std::vector<float>(values), std::vector<float>(values),
                      std::vector<float>(values)};
  for_pixels(values, [&](size_t i) {
    const float scale = 1.0f / light[i / 3];
    residuals.first[i] = scale * (b[i] - from_a[i]);
    residuals.second[i] = scale * (a[i] - from_b[i]);
    residuals.halves[i] = scale * (a[i] - b[i]);
    residuals.mean[i] = scale * (image[i] - 0.5f * (from_a[i] + from_b[i]));
  });
  std::vector<float> result = significant_part(std::move(residuals), width, height);
  // A residual can be larger than the light. Only negative lamps make an image negative.
  for_pixels(values, [&](size_t i) {
    result[i] = std::max(0.5f * (from_a[i] + from_b[i]) + light[i / 3] * result[i], std::min(0.0f, image[i]));
  });
  return result;
}

}  // namespace ajar
