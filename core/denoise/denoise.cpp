#include "denoise/denoise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "denoise/bright_pixels.h"
#include "math/relative_error.h"
#include "math/statistics.h"
#include "math/types.h"

namespace ajar {

namespace {

constexpr int kDarkestReach = 2;     // pixels to each side, for the lower bound of a pixel
constexpr int kNeighbours = 3;       // pixels to each side, in which a bright pixel is compared
constexpr size_t kRank = 3;          // the neighbour with which it is compared, from the brightest
constexpr float kMaxRatio = 3.0f;    // of the brightness of a pixel to that neighbour
constexpr float kUsualNoise = 3.0f;  // times the mean of |m - n| in a window
constexpr float kChance = 5.0f;      // times noise over energy: how far a pixel can be bright in both halves by chance
constexpr float kUsualError = 4.0f;  // times the mean error of a window: above it, a pixel can be so by chance
constexpr float kSpot = 8.0f;        // area of a bright spot in a plane, in squares of its step
constexpr int kFrequentReach = 8;    // pixels to each side of the window in which darkened pixels are counted
constexpr float kFrequent = 0.012f;  // share of darkened pixels above which they keep their light
constexpr float kMaxWhole = 0.6f;    // maximum share of D(N)
constexpr double kNoiseOfWhole = 0.02;    // relative noise, squared, at which the share of D(N) is half of the maximum
constexpr double kLeastWhole = 0.1;       // share of D(N) below which it is not computed
constexpr int kChancePlanes = 3;          // in which pixels that are bright by chance do not count
constexpr int kErrorReach = 2;            // pixels to each side of the window of the error
constexpr double kMinSignificance = 2.5;  // the mean of the products over its standard error, below which g is 0

std::vector<float> luminances(const std::vector<float>& image) {
  std::vector<float> result(image.size() / 3);
  for_pixels(result.size(), [&](size_t i) { result[i] = luminance_at(image, i); });
  return result;
}

/// The luminance of the neighbour of this rank, or a smaller one that is at least `enough`.
float bright_neighbour(const std::vector<float>& light, int x, int y, int width, int height, float enough) {
  std::array<float, kRank> brightest{};
  for (int v = std::max(0, y - kNeighbours); v <= std::min(height - 1, y + kNeighbours); ++v)
    for (int u = std::max(0, x - kNeighbours); u <= std::min(width - 1, x + kNeighbours); ++u) {
      if (u == x && v == y) continue;
      float value = light[size_t(v) * size_t(width) + size_t(u)];
      for (float& place : brightest)
        if (value > place) std::swap(value, place);
      if (brightest.back() >= enough) return brightest.back();
    }
  return brightest.back();
}

/// Images of the relative error, as fractions of the light of each pixel, or their means over a neighbourhood.
struct Residuals {
  std::vector<float> first, second;  ///< B - D(A) and A - D(B)
  std::vector<float> halves;         ///< A - B
  std::vector<float> whole;          ///< D - (D(A) + D(B)) / 2; empty: it is 0

  std::array<std::vector<float>*, 4> all() { return {&first, &second, &halves, &whole}; }
};

/// What a pixel of a plane tells: the energies of the residuals and of A - B, and the product of the residuals of D(A).
struct PlanePixel {
  float energy = 0.0f, noise = 0.0f, product = 0.0f;
};
/// The denoiser's images of both halves, and D if it is not their mean. With one run, both are D.
struct DenoisedHalves {
  std::vector<float> from_a, from_b, whole;
};

/// The combination of the planes. Its images are reused for all planes.
class Combination {
 public:
  /// `by_chance`: pixels that are bright in both halves by chance (BrightPixels), in [0, 1].
  Combination(Residuals residuals, std::vector<float> by_chance, int width, int height);
  /// The sums over the planes of g (A - D(A)) + (1 - g) (D - (D(A) + D(B)) / 2), and of the same for B.
  std::array<std::vector<float>, 2> significant_parts();

 private:
  void find_plane();
  void find_weights(int level);
  /// Of a detail whose part in a finer plane counts, the part in this plane counts too. It has less noise. Alone, a fine
  /// plane would be negative around a bright detail and leave a dark ring.
  void follow_finer_weights(int level);

  int width_, height_;
  Residuals rest_, smooth_;       ///< the plane is their difference
  std::vector<float> by_chance_;  ///< the maximum over all pixels that reach this one in the plane
  std::vector<PlanePixel> plane_;
  std::vector<float> weights_;  ///< g, one for each pixel
  std::vector<float> finer_;    ///< of the plane before, spread as far as its details reach in this plane
  std::vector<float> roots_, terms_, scratch_;
};

Combination::Combination(Residuals residuals, std::vector<float> by_chance, int width, int height)
    : width_(width),
      height_(height),
      rest_(std::move(residuals)),
      by_chance_(std::move(by_chance)),
      plane_(size_t(width) * size_t(height)),
      weights_(plane_.size()),
      finer_(plane_.size()),
      roots_(2 * plane_.size()),
      terms_(3 * plane_.size()) {}

void Combination::find_plane() {
  for_pixels(plane_.size(), [&](size_t i) {
    PlanePixel p;
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
      const float one = rest_.first[c] - smooth_.first[c], two = rest_.second[c] - smooth_.second[c],
                  n = rest_.halves[c] - smooth_.halves[c];
      p.energy += 0.5f * (one * one + two * two);
      p.noise += n * n;
      p.product += 0.5f * (one * (one + n) + two * (two - n));  // A - D(A) is B - D(A) + (A - B)
    }
    p.product = std::abs(p.product);
    plane_[i] = p;
  });
}

void Combination::find_weights(int level) {
  const int reach = (4 << level) - 1;
  for_pixels(plane_.size(), [&](size_t i) {
    roots_[2 * i] = std::sqrt(plane_[i].noise);
    roots_[2 * i + 1] = std::sqrt(plane_[i].product);
  });
  window_mean(roots_, {width_, height_, 2}, reach, scratch_);
  // A pixel counts less if its noise is far above the usual noise and error of the window, and above its own error.
  for_pixels(plane_.size(), [&](size_t i) {
    const PlanePixel p = plane_[i];
    const float noise = roots_[2 * i], error = roots_[2 * i + 1],
                usual = kUsualNoise * kUsualNoise * noise * noise + error * error + p.product;
    const float rare = level < kChancePlanes ? by_chance_[i] : 0.0f,
                w = (1.0f - rare) * (usual > 0.0f ? usual / (usual + p.noise) : 1.0f);
    weights_[i] = w;
    const float term = w * (p.energy - 0.5f * p.noise),
                chance = std::min(1.0f, kChance * p.noise / (p.energy + 1e-12f)),
                excess = chance * std::max(0.0f, term - kUsualError * kUsualError * error * error);
    terms_[3 * i] = term;
    // Its variance. What can be so by chance is in spots, whose values are not independent.
    terms_[3 * i + 1] = w * w * p.noise * (p.product + 0.25f * p.noise) + kSpot * excess * excess;
    terms_[3 * i + 2] = w * p.noise;
  });
  window_mean(terms_, {width_, height_, 3}, reach, scratch_);
  // Neighbouring values of a plane are correlated over its step.
  const double independent = std::max(1.0, window_count(reach) / double(size_t(1) << (2 * level)));
  for_pixels(plane_.size(), [&](size_t i) {
    const double mean = double(terms_[3 * i]), variance = double(terms_[3 * i + 1]) / independent,
                 noise_of_mean = 0.25 * double(terms_[3 * i + 2]);
    const double error = mean > 0.0 ? mean - kMinSignificance * kMinSignificance * variance / mean : 0.0;
    weights_[i] *= error > 0.0 ? float(error / (error + std::max(0.0, noise_of_mean))) : 0.0f;
  });
}

void Combination::follow_finer_weights(int level) {
  for_pixels(weights_.size(), [&](size_t i) { weights_[i] = std::max(weights_[i], finer_[i]); });
  smooth(weights_, {width_, height_, 1}, 1 << level, finer_);
}

std::array<std::vector<float>, 2> Combination::significant_parts() {
  const ImageSize size{width_, height_, 3};
  const int planes = plane_count(width_, height_);
  std::array<std::vector<float>, 2> sums{std::vector<float>(size.values()), std::vector<float>(size.values())};
  for (int level = 0; level <= planes; ++level) {
    for (size_t k = 0; k < rest_.all().size(); ++k) {
      if (rest_.all()[k]->empty()) continue;
      if (level < planes)
        smooth(*rest_.all()[k], size, 1 << level, *smooth_.all()[k]);
      else
        std::fill(smooth_.all()[k]->begin(), smooth_.all()[k]->end(), 0.0f);
    }
    find_plane();
    if (level < kChancePlanes) square_max(by_chance_, {width_, height_, 1}, 2 << level, scratch_);
    find_weights(level);
    follow_finer_weights(level);
    for_pixels(size.values(), [&](size_t i) {
      const float n = rest_.halves[i] - smooth_.halves[i];
      const float g = weights_[i / 3],
                  whole = rest_.whole.empty() ? 0.0f : (1.0f - g) * (rest_.whole[i] - smooth_.whole[i]);
      sums[0][i] += g * (rest_.first[i] - smooth_.first[i] + n) + whole;
      sums[1][i] += g * (rest_.second[i] - smooth_.second[i] - n) + whole;
    });
    std::swap(rest_, smooth_);
  }
  return sums;
}

/// Minimum of the mean of both images around a pixel, of one channel. Where a highlight is significant in a fine plane but
/// not in a coarse one, the negative values of the fine plane around it would leave a dark ring. No pixel becomes darker
/// than the denoiser's image and than all rendered pixels around it, among which the correct value lies in the limit.
float darkest_around(const std::vector<float>& a, const std::vector<float>& b, ImageSize size, size_t value) {
  const int x = int(value / 3) % size.width, y = int(value / 3) / size.width;
  float darkest = std::numeric_limits<float>::max();
  for (int v = std::max(0, y - kDarkestReach); v <= std::min(size.height - 1, y + kDarkestReach); ++v)
    for (int u = std::max(0, x - kDarkestReach); u <= std::min(size.width - 1, x + kDarkestReach); ++u) {
      const size_t there = (size_t(v) * size_t(size.width) + size_t(u)) * 3 + value % 3;
      darkest = std::min(darkest, 0.5f * (a[there] + b[there]));
    }
  return darkest;
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

/// Pixels of `limited_a` and `limited_b` are darkened. Where many are, they are not outliers but the way in which light
/// is found: there they get their light back.
void restore_frequent(const std::vector<float>& a, const std::vector<float>& b, ImageSize size,
                      std::vector<float>& limited_a, std::vector<float>& limited_b) {
  const size_t pixels = size.values() / 3;
  std::vector<float> share(pixels), scratch;
  const auto is_darker = [](const std::vector<float>& now, const std::vector<float>& before, size_t pixel) {
    return luminance_at(now, pixel) < luminance_at(before, pixel) ? 0.5f : 0.0f;
  };
  for_pixels(pixels, [&](size_t i) { share[i] = is_darker(limited_a, a, i) + is_darker(limited_b, b, i); });
  window_mean(share, {size.width, size.height, 1}, kFrequentReach, scratch);
  for_pixels(pixels, [&](size_t i) {
    const float ratio = share[i] / kFrequent, ratio4 = ratio * ratio * ratio * ratio, kept = ratio4 / (ratio4 + 1.0f);
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
      limited_a[c] += kept * (a[c] - limited_a[c]);
      limited_b[c] += kept * (b[c] - limited_b[c]);
    }
  });
}

/// sqrt(y^2 + dark), with the luminance y of the mean of both. `dark`: see dark_squared.
std::vector<float> light_of(const std::vector<float>& one, const std::vector<float>& two, float dark) {
  std::vector<float> light(one.size() / 3);
  for_pixels(light.size(), [&](size_t i) {
    const float y = 0.5f * (luminance_at(one, i) + luminance_at(two, i));
    light[i] = std::sqrt(y * y + dark);
  });
  return light;
}

DenoisedHalves denoise_halves(const std::vector<float>& a, const std::vector<float>& b, ImageSize size, float dark,
                              const DenoiseFunction& denoiser, DenoiseRuns runs) {
  const bool with_halves = runs != DenoiseRuns::Whole, with_whole = runs != DenoiseRuns::Halves;
  std::vector<float> one = limited(a, b, size.width, size.height), two = limited(b, a, size.width, size.height), mean,
                     noise;  // squared
  if (with_halves && with_whole) {
    noise.resize(size.values() / 3);
    for_pixels(noise.size(), [&](size_t i) {
      for (size_t c = 3 * i; c < 3 * i + 3; ++c) noise[i] += (one[c] - two[c]) * (one[c] - two[c]) / 12.0f;
    });
  }
  restore_frequent(a, b, size, one, two);
  if (with_whole) {
    mean.resize(size.values());
    for_pixels(mean.size(), [&](size_t i) { mean[i] = 0.5f * (one[i] + two[i]); });
  }
  if (!with_halves) {
    DenoisedHalves d{run(denoiser, std::move(mean)), {}, {}};
    d.from_b = d.from_a;
    return d;
  }
  DenoisedHalves d{run(denoiser, std::move(one)), run(denoiser, std::move(two)), {}};
  if (!with_whole) return d;

  const std::vector<float> light = light_of(d.from_a, d.from_b, dark);
  double relative = 0.0;
  for (size_t i = 0; i < noise.size(); ++i) relative += double(noise[i]) / (double(light[i]) * double(light[i]));
  relative /= double(noise.size());
  const double share = double(kMaxWhole) * relative / (relative + kNoiseOfWhole);
  if (!(share >= kLeastWhole)) return d;
  d.whole = run(denoiser, std::move(mean));
  for_pixels(d.whole.size(), [&](size_t i) {
    const float of_halves = 0.5f * (d.from_a[i] + d.from_b[i]);
    d.whole[i] = of_halves + float(share) * (d.whole[i] - of_halves);
  });
  return d;
}

bool is_known(const Halves& halves) {
  const auto known = [](const std::vector<float>& image) {
    return !image.empty() && std::none_of(image.begin(), image.end(), [](float v) { return std::isnan(v); });
  };
  return known(halves.a) && known(halves.b);
}
constexpr size_t kHalfChannels = 6;  // of one technique
/// Those of technique k of an image with `techniques` of them.
Halves separate(const std::vector<float>& halves, size_t k, size_t techniques) {
  const size_t pixels = halves.size() / (kHalfChannels * techniques);
  Halves result{std::vector<float>(3 * pixels), std::vector<float>(3 * pixels)};
  for_pixels(pixels, [&](size_t i) {
    const float* from = &halves[kHalfChannels * (techniques * i + k)];
    for (size_t c = 0; c < 3; ++c) {
      result.a[3 * i + c] = from[c];
      result.b[3 * i + c] = from[3 + c];
    }
  });
  return result;
}

/// A denoised image, and the difference G(A) - G(B) of the images for each half.
struct Combined {
  std::vector<float> image, difference;
};
Combined combine(const Halves& halves, ImageSize size, float dark, const DenoiseFunction& denoiser, DenoiseRuns runs) {
  const auto& [a, b] = halves;
  const auto [from_a, from_b, whole] = denoise_halves(a, b, size, dark, denoiser, runs);
  BrightPixels bright = bright_pixels_of(halves, from_a, from_b, size);
  const std::vector<float> light = light_of(from_a, from_b, dark);
  Residuals residuals;
  for (std::vector<float>* one : residuals.all())
    if (one != &residuals.whole || !whole.empty()) one->resize(size.values());
  for_pixels(size.values(), [&](size_t i) {
    const float scale = 1.0f / light[i / 3];
    if (!whole.empty()) residuals.whole[i] = scale * (whole[i] - 0.5f * (from_a[i] + from_b[i]));
    if (bright.detail[i / 3] > 0.0f) return;
    residuals.first[i] = scale * (b[i] - from_a[i]);
    residuals.second[i] = scale * (a[i] - from_b[i]);
    residuals.halves[i] = scale * (a[i] - b[i]);
  });
  const auto parts = Combination(std::move(residuals), std::move(bright.by_chance), size.width, size.height)
                         .significant_parts();
  Combined result{std::vector<float>(size.values()), std::vector<float>(size.values())};
  for_pixels(size.values(), [&](size_t i) {
    const float g = bright.detail_weight[i / 3];
    const float of_a = from_a[i] + light[i / 3] * parts[0][i] + g * (a[i] - from_a[i]),
                of_b = from_b[i] + light[i / 3] * parts[1][i] + g * (b[i] - from_b[i]);
    // A residual can be larger than the light. Only negative lamps make an image negative.
    float value = std::max(0.5f * (of_a + of_b), std::min(0.0f, std::min(a[i], b[i])));
    const float of_denoiser = std::min(from_a[i], from_b[i]);
    if (value < of_denoiser) value = std::max(value, std::min(of_denoiser, darkest_around(a, b, size, i)));
    result.image[i] = value;
    result.difference[i] = of_a - of_b;
  });
  return result;
}

/// The image by one technique. `direct`: the part of the halves by direct paths; unknown: they are not separated. Without
/// runs for the halves, the error is empty.
Denoised denoise_technique(const Halves& all, Halves direct, ImageSize size, float dark,
                           const DenoiseFunction& denoiser, DenoiseRuns runs) {
  std::vector<Halves> parts{all};
  if (is_known(direct)) {
    for (size_t i = 0; i < size.values(); ++i) {
      parts[0].a[i] -= direct.a[i];
      parts[0].b[i] -= direct.b[i];
    }
    parts.push_back(std::move(direct));
  }
  Denoised result{std::vector<float>(size.values()), {}};
  std::vector<float> difference(size.values());
  for (const Halves& part : parts) {
    const Combined combined = combine(part, size, dark, denoiser, runs);
    for_pixels(size.values(), [&](size_t i) {
      result.image[i] += combined.image[i];
      difference[i] += combined.difference[i];
    });
  }
  if (runs == DenoiseRuns::Whole) return result;
  result.error.resize(size.values() / 3);
  for_pixels(result.error.size(), [&](size_t i) {
    for (size_t c = 3 * i; c < 3 * i + 3; ++c)
      result.error[i] += 0.5f * difference[c] * difference[c] / (result.image[c] * result.image[c] + dark) / 3.0f;
  });
  std::vector<float> scratch;
  window_mean(result.error, {size.width, size.height, 1}, kErrorReach, scratch);
  return result;
}

float dark_of(const NoisyImage& noisy) { return float(dark_squared(double(noisy.exposure))); }

size_t techniques_of(const NoisyImage& noisy) {
  return noisy.halves.size() / (kHalfChannels * size_t(noisy.width) * size_t(noisy.height));
}

/// The images of the techniques whose halves are known. `estimator`: see `denoise`.
std::vector<TechniqueImage> denoise_techniques(const NoisyImage& noisy, const DenoiseFunction& denoiser,
                                               DenoiseRuns runs, const DenoiseFunction& estimator) {
  const ImageSize size{noisy.width, noisy.height, 3};
  const size_t techniques = techniques_of(noisy);
  std::vector<TechniqueImage> images;
  for (size_t k = 0; k < techniques; ++k) {
    Halves all = separate(noisy.halves, k, techniques), direct;
    if (!is_known(all)) continue;
    if (!noisy.direct_halves.empty()) direct = separate(noisy.direct_halves, k, techniques);
    Denoised denoised = denoise_technique(all, std::move(direct), size, dark_of(noisy), denoiser, runs);
    if (runs == DenoiseRuns::Whole && estimator)
      denoised.error = denoise_technique(all, {}, size, dark_of(noisy), estimator, DenoiseRuns::Halves).error;
    images.push_back({std::move(denoised), std::move(all), k < noisy.biased.size() && noisy.biased[k]});
  }
  return images;
}

}  // namespace

std::vector<float> rgb_of(const std::vector<float>& rgba) {
  std::vector<float> rgb(rgba.size() / 4 * 3);
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = rgba[4 * (i / 3) + i % 3];
  return rgb;
}

int plane_count(int width, int height) {
  int count = 1;
  while ((8 << count) <= std::min(width, height)) ++count;
  return count;
}

std::vector<float> limited(const std::vector<float>& image, const std::vector<float>& other, int width, int height) {
  const std::vector<float> light = luminances(image);
  std::vector<float> result = image;
  for_rows(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const size_t pixel = size_t(y) * size_t(width) + size_t(x);
      const float there = luminance_at(other, pixel);
      if (light[pixel] <= there) continue;
      const float around = bright_neighbour(light, x, y, width, height, light[pixel] / kMaxRatio),
                  limit = std::max(kMaxRatio * around, there);
      if (light[pixel] > limit)
        for (size_t c = 3 * pixel; c < 3 * pixel + 3; ++c) result[c] *= limit / light[pixel];
    }
  });
  return result;
}

std::vector<double> technique_errors(const NoisyImage& noisy, const DenoiseFunction& denoiser) {
  const ImageSize size{noisy.width, noisy.height, 3};
  const std::vector<TechniqueImage> images = denoise_techniques(noisy, denoiser, DenoiseRuns::Halves, {});
  if (images.size() != techniques_of(noisy)) return {};
  std::vector<double> means;
  for (const std::vector<float>& errors : errors_of(images, size, dark_of(noisy))) {
    CompensatedSum sum;
    for (const float e : errors) sum.add(double(e));
    means.push_back(sum.value() / double(errors.size()));
  }
  return means;
}

Denoised denoise(const NoisyImage& noisy, const DenoiseFunction& denoiser, DenoiseRuns runs,
                 const DenoiseFunction& estimator) {
  const bool needs_errors = techniques_of(noisy) > 1 && !estimator;
  std::vector<TechniqueImage> images = denoise_techniques(noisy, denoiser, runs, needs_errors ? denoiser : estimator);
  if (images.empty()) return {run(denoiser, noisy.image), {}};
  return images.size() == 1 ? std::move(images[0].denoised)
                            : mean_of(images, {noisy.width, noisy.height, 3}, dark_of(noisy));
}

}  // namespace ajar
