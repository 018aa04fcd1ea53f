#include "transport/bidirectional/further_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "math/relative_error.h"

namespace ajar {

namespace {

constexpr uint32_t kStream = 0x7365656eU;  // separates the random numbers from those of the samples
constexpr int kAround = 2;                 // pixels to each side
constexpr int kBisections = 48;            // for the limit of further rays
/// Prior probability that a polished surface shows a small lamp that no sample in the pixels around has hit yet.
constexpr double kUnseen = 1.0 / 32.0;

double variance(float sum, float sum_squared, uint32_t count) {
  return count > 1 ? std::max(0.0, (double(sum_squared) - double(sum) * double(sum) / count) / (count - 1)) : 0.0;
}

}  // namespace

void FurtherSamples::prepare(const Scene& scene, const Film& film, const PixelFilter& filter, uint32_t seed,
                             Limits limits) {
  *this = FurtherSamples();
  filter_ = filter;
  seed_ = hash_combine(seed, kStream);
  max_share_ = limits.max_share;
  exposure_ = shown_exposure(scene.settings());
  full_width_ = scene.settings().width;
  x0_ = film.x0(), y0_ = film.y0(), width_ = film.width(), height_ = film.height();
  if (!scene.has_media() && !scene.lights().empty())
    pixels_.assign(size_t(width_) * size_t(height_), {.taken = limits.first});
}

void FurtherSamples::relative_variances(int x, int y, double on_polished, double& part, double& rest) const {
  double part_sum = 0.0, rest_sum = 0.0, mean = 0.0;
  int count = 0;
  for (int v = std::max(0, y - kAround); v <= std::min(height_ - 1, y + kAround); ++v)
    for (int u = std::max(0, x - kAround); u <= std::min(width_ - 1, x + kAround); ++u, ++count) {
      const Pixel& pixel = pixels_[size_t(v) * size_t(width_) + size_t(u)];
      part_sum += variance(pixel.part, pixel.part_squared, pixel.looked);
      rest_sum += variance(pixel.rest, pixel.rest_squared, pixel.samples);
      mean += double(pixel.part) / std::max(1u, pixel.looked) + double(pixel.rest) / std::max(1u, pixel.samples);
    }
  part = part_sum / count;
  rest = rest_sum / count;
  mean /= count;
  if (pixels_[size_t(y) * size_t(width_) + size_t(x)].polished) part += kUnseen * (on_polished - part);
  part /= mean * mean + kDarkSquared;
  rest /= mean * mean + kDarkSquared;
}

void FurtherSamples::learn(uint32_t samples, uint64_t rays_of_rest, uint64_t further_rays) {
  if (!active() || samples < 2 || !std::has_single_bit(samples)) return;
  double on_polished = 0.0;
  uint64_t polished = 0, further = 0;
  for (const Pixel& pixel : pixels_) {
    further += pixel.looked - pixel.samples;
    if (pixel.polished) on_polished += variance(pixel.part, pixel.part_squared, pixel.looked), ++polished;
  }
  on_polished /= double(std::max<uint64_t>(1, polished));
  std::vector<double> wanted(pixels_.size());
  double deviation = 0.0;  // mean of deviations over the pixels: outliers in a few samples count less than in variances
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      double part, rest;
      relative_variances(x, y, on_polished, part, rest);
      wanted[size_t(y) * size_t(width_) + size_t(x)] = std::sqrt(part);
      deviation += std::sqrt(rest);
    }
  deviation /= double(pixels_.size());
  const double rest_rays = double(rays_of_rest) / (double(pixels_.size()) * samples),
               part_rays = double(further_rays) / double(std::max<uint64_t>(1, further));
  const double unit = std::sqrt(rest_rays / std::max(part_rays, 1.0)) / std::max(deviation, 1e-9);
  const double max_further = max_share_ * rest_rays / std::max(part_rays, 1.0) * double(pixels_.size());
  const auto taken = [&](size_t i, double scale) { return std::clamp(scale * wanted[i], 1.0, double(kMax)); };
  const auto further_of = [&](double scale) {
    double sum = 0.0;
    for (size_t i = 0; i < pixels_.size(); ++i) sum += taken(i, scale) - 1.0;
    return sum;
  };
  double scale = unit, min_scale = 0.0;
  if (further_of(unit) > max_further)
    for (int step = 0; step < kBisections; ++step) {
      const double middle = 0.5 * (min_scale + scale);
      (further_of(middle) > max_further ? scale : min_scale) = middle;
    }
  for (size_t i = 0; i < pixels_.size(); ++i) pixels_[i].taken = uint16_t(std::lround(taken(i, scale)));
}

}  // namespace ajar
