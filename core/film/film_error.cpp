// The noise of pixels, and the error of the image that is estimated from it.
#include "film/film.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "math/statistics.h"

namespace ajar {

namespace {

constexpr uint32_t kSettledSamples = 16;  // for the average pixel; by then, an adaptive render has found its shares
constexpr int kErrorBlock = 8;            // pixels, along each side
// minimum ratio of the present sample count to that of the image with which the present image is compared
constexpr double kFirstStep = 4.0 / 3.0;
// number of standard deviations by which errors must fall faster than those of independent samples
constexpr double kErrorConfidence = 2.0;

/// An image whose samples extend those of an earlier image differs from it by the variance that it has lost. With a
/// variance of c n^-p after n samples, the differences from n2 to n1 and from n1 to n determine p and c. p is 1 for
/// independent samples and more for stratified ones.
double error_from_steps(double before, double recent, double n2, double n1, double n) {
  double low = 1.0, high = 2.5;
  for (int i = 0; i < 40; ++i) {
    const double p = 0.5 * (low + high),
                 ratio = (std::pow(n2, -p) - std::pow(n1, -p)) / (std::pow(n1, -p) - std::pow(n, -p));
    (ratio * recent < before ? low : high) = p;
  }
  return recent * std::pow(n, -low) / (std::pow(n1, -low) - std::pow(n, -low));
}

}  // namespace

/// Variance of the mean luminance of a pixel for independent samples. Stratified samples have slightly less.
double Film::scatter_variance(const Pixel& p) {
  if (p.count < 2) return 0.0;
  const double mean = luminance_of(p.sum) / double(p.count);
  return std::max(0.0, p.sum_luminance_squared / double(p.count) - mean * mean) / double(p.count - 1);
}

/// Variance of the mean luminance of each pixel. For samples it follows from their scatter. For splats it follows from
/// the difference of their halves, averaged over a neighbourhood, because a single difference is too noisy.
std::vector<float> Film::variance_of_mean() const {
  constexpr int kReach = 2;
  std::vector<float> variance(pixels_.size(), 0.0f), splat_variance(splats_ ? pixels_.size() : 0);
  for (size_t i = 0; i < splat_variance.size(); ++i) {
    double difference[3];
    for (int c = 0; c < 3; ++c) difference[c] = splat_scale_ * (splats_[i].sum[1][c] - splats_[i].sum[0][c]);
    splat_variance[i] = float(luminance_of(difference) * luminance_of(difference));
  }
  for (int y = 0; y < height(); ++y) {
    for (int x = 0; x < width(); ++x) {
      const size_t i = size_t(y) * size_t(width()) + size_t(x);
      const Pixel& p = pixels_[i];
      variance[i] = float(scatter_variance(p));
      if (!splats_) continue;
      double sum = 0.0;
      int terms = 0;
      for (int v = std::max(0, y - kReach); v <= std::min(height() - 1, y + kReach); ++v)
        for (int u = std::max(0, x - kReach); u <= std::min(width() - 1, x + kReach); ++u, ++terms)
          sum += double(splat_variance[size_t(v) * size_t(width()) + size_t(u)]);
      variance[i] += float(sum / terms);
    }
  }
  return variance;
}

bool Film::has_halves(const Pixel& p) const {
  return (p.half_count > 0 && p.half_count < p.count) || (splats_ && p.count == 0);
}

/// Mean of a pixel and the difference between the means of its two halves. Returns false if there are too few samples.
bool Film::halves_of(size_t index, double mean[3], double difference[3]) const {
  const Pixel& p = pixels_[index];
  const uint32_t even = p.count - p.half_count;
  if (!has_halves(p)) return false;
  for (int c = 0; c < 3; ++c) {
    mean[c] = splatted(index, c);
    difference[c] = 0.0;
    if (p.count > 0) {
      difference[c] = p.half[c] / double(p.half_count) - (p.sum[c] - p.half[c]) / double(even);
      mean[c] += p.sum[c] / double(p.count);
    }
    if (splats_) difference[c] += 2.0 * splat_scale_ * (splats_[index].sum[1][c] - splats_[index].sum[0][c]);
  }
  return true;
}

void Film::means_of_halves(size_t index, double exposure, float out[6]) const {
  means_of_halves(index, pixels_[index].sum, pixels_[index].half, index, exposure, out);
}

void Film::means_of_direct_halves(size_t index, double exposure, float out[6]) const {
  if (!wants_direct() || !direct_known_.load(std::memory_order_relaxed) || caught_.enabled()) {
    std::fill_n(out, 6, std::numeric_limits<float>::quiet_NaN());
    return;
  }
  means_of_halves(index, direct_[index].sum, direct_[index].half, index + pixels_.size() * direct_plane(), exposure,
                  out);
}

/// The means of the halves of sums over the samples of a pixel, with splats from this index on.
void Film::means_of_halves(size_t index, const double sum[3], const double half[3], size_t splats, double exposure,
                           float out[6]) const {
  const Pixel& p = pixels_[index];
  const bool known = has_halves(p);
  const uint32_t even = p.count - p.half_count;
  for (int c = 0; c < 3; ++c) {
    double first = 0.0, second = 0.0;
    if (p.count > 0 && known) {
      first = (sum[c] - half[c]) / double(even);
      second = half[c] / double(p.half_count);
    }
    if (splats_) {
      first += 2.0 * splat_scale_ * splats_[splats].sum[0][c];
      second += 2.0 * splat_scale_ * splats_[splats].sum[1][c];
    }
    out[c] = known ? float(first * exposure) : std::numeric_limits<float>::quiet_NaN();
    out[3 + c] = known ? float(second * exposure) : std::numeric_limits<float>::quiet_NaN();
  }
}

/// An estimate of the true value of a pixel, for the denominator of a relative error. `value` holds the mean of the
/// pixel and `around` the mean of its neighbours. If a channel of the pixel is above its neighbours by no more than the
/// scatter of its samples explains, the cause is probably a firefly. Its value is then moved towards the neighbours
/// [after James and Stein 1961].
void Film::make_likely(size_t index, const double around[3], double value[3]) const {
  double above[3];
  bool any_above = false;
  for (int c = 0; c < 3; ++c) {
    above[c] = value[c] - around[c];
    any_above |= above[c] > 0.0;
  }
  double mean[3], difference[3];
  if (!any_above || !halves_of(index, mean, difference)) return;
  const double y_own = luminance_of(mean), y_half = 0.5 * luminance_of(difference);
  const double variance = scatter_variance(pixels_[index]) + (splats_ ? y_half * y_half : 0.0);
  for (int c = 0; c < 3; ++c) {
    if (!(above[c] > 0.0)) continue;
    const double part = y_own > 0.0 ? value[c] / y_own : 1.0;  // ratio of the channel to the luminance
    value[c] = around[c] + above[c] * std::max(0.0, 1.0 - variance * part * part / (above[c] * above[c]));
  }
}

/// Sums over the pixels at most one away in each direction, for row y of `image`; `columns` is temporary memory.
void Film::sums_around(const std::vector<float>& image, int y, std::vector<double>& columns,
                       std::vector<double>& sums) const {
  const size_t w = size_t(width());
  const float* const row = image.data() + size_t(y) * w;
  const float* const below = y > 0 ? row - w : nullptr;
  const float* const above = y + 1 < height() ? row + w : nullptr;
  columns.assign(row, row + w);
  for (const float* const other : {below, above})
    for (size_t x = 0; other && x < w; ++x) columns[x] += double(other[x]);
  sums = columns;
  for (size_t x = 0; x + 1 < w; ++x) sums[x] += columns[x + 1];
  for (size_t x = 1; x < w; ++x) sums[x] += columns[x - 1];
}

Film::ErrorEstimate Film::estimated_error_of_few() const {
  constexpr ErrorEstimate kUnknown{-1.0, -1.0};
  CompensatedSum sum, scattered, halved, seen;
  for (size_t i = 0; i < pixels_.size(); ++i) {
    double mean[3], difference[3];
    if (!halves_of(i, mean, difference)) return kUnknown;
    for (int c = 0; c < 3; ++c) sum.add(0.25 * difference[c] * difference[c] / relative_square(mean[c]));
    const double y = luminance_of(mean), d = luminance_of(difference), weight = 1.0 / relative_square(y);
    const double of_scatter = splats_ ? 0.0 : scatter_variance(pixels_[i]), of_halves = 0.25 * d * d;
    seen.add(candelas_per_unit() * (splats_ ? of_halves : of_scatter) / threshold_at(y));
    if (splats_) continue;
    halved.add(of_halves * weight);
    scattered.add(of_scatter * weight);
  }
  if (pixels_.empty()) return kUnknown;
  const double pixels = double(pixels_.size());
  return {sum.value() / (3.0 * pixels) * (halved.value() > 0.0 ? scattered.value() / halved.value() : 1.0),
          seen.value() / pixels};
}

double Film::threshold_at(double luminance) const {
  return tvi(candelas_per_unit() * std::max(0.0, luminance)) / candelas_per_unit();
}

std::array<std::vector<float>, 3> Film::means() const {
  std::array<std::vector<float>, 3> image;
  for (int c = 0; c < 3; ++c) {
    image[size_t(c)].resize(pixels_.size());
    for (size_t i = 0; i < pixels_.size(); ++i)
      image[size_t(c)][i] = float((pixels_[i].count > 0 ? pixels_[i].sum[c] / double(pixels_[i].count) : 0.0) +
                                  splatted(i, c));
  }
  return image;
}

void Film::remember(uint32_t samples) {
  if (remembered_.size() == kMaxRemembered) remembered_.erase(remembered_.begin());
  remembered_.push_back({samples, means()});
}

Film::ErrorEstimate Film::estimated_error(uint32_t samples) const {
  // The latest remembered image that has sufficiently fewer samples.
  size_t k = remembered_.size();
  while (k > 0 && kFirstStep * double(remembered_[k - 1].samples) > double(samples)) --k;
  if (k < 2 || !std::all_of(pixels_.begin(), pixels_.end(), [&](const Pixel& p) { return has_halves(p); }))
    return estimated_error_of_few();
  const ErrorEstimate latest = error_from_pictures(remembered_[k - 1], remembered_[k - 2], samples);
  // An image is used from 4/3 of its samples on, where the difference to it is small and uncertain. Until twice its
  // samples, the estimate moves from the image before it to this one, without a jump.
  const double part = std::clamp(
      (double(samples) / double(remembered_[k - 1].samples) - kFirstStep) / (2.0 - kFirstStep), 0.0, 1.0);
  if (k < 3 || part == 1.0 || !(latest.relmse > 0.0) || !(latest.perceptual > 0.0)) return latest;
  const ErrorEstimate before = error_from_pictures(remembered_[k - 2], remembered_[k - 3], samples);
  if (!(before.relmse > 0.0) || !(before.perceptual > 0.0)) return latest;
  return {std::pow(before.relmse, 1.0 - part) * std::pow(latest.relmse, part),
          std::pow(before.perceptual, 1.0 - part) * std::pow(latest.perceptual, part)};
}

/// Error of the present image from its difference to `one`, and from the difference of `one` to `two`, which has half
/// the samples of `one`.
Film::ErrorEstimate Film::error_from_pictures(const Remembered& one, const Remembered& two, uint32_t samples) const {
  const std::array<std::vector<float>, 3> now = means();
  const size_t columns = size_t((width() + kErrorBlock - 1) / kErrorBlock);
  std::vector<std::array<double, 2>> blocks(columns * size_t((height() + kErrorBlock - 1) / kErrorBlock));
  CompensatedSum recent, before, recent_seen, before_seen;
  std::array<std::vector<double>, 3> sums;
  std::vector<double> room;
  for (int y = 0; y < height(); ++y) {
    for (size_t c = 0; c < 3; ++c) sums_around(now[c], y, room, sums[c]);
    const int rows = std::min(height() - 1, y + 1) - std::max(0, y - 1) + 1;
    for (int x = 0; x < width(); ++x) {
      const int others = rows * (std::min(width() - 1, x + 1) - std::max(0, x - 1) + 1) - 1;
      const size_t i = size_t(y) * size_t(width()) + size_t(x);
      double value[3], around[3], recently[3], earlier[3];
      for (size_t c = 0; c < 3; ++c) {
        value[c] = double(now[c][i]);
        around[c] = others > 0 ? (sums[c][size_t(x)] - value[c]) / others : value[c];
        recently[c] = value[c] - double(one.image[c][i]);
        earlier[c] = double(one.image[c][i]) - double(two.image[c][i]);
      }
      make_likely(i, around, value);
      std::array<double, 2>& block = blocks[size_t(y / kErrorBlock) * columns + size_t(x / kErrorBlock)];
      for (size_t c = 0; c < 3; ++c) {
        const double unit = relative_square(value[c]);
        block[0] += earlier[c] * earlier[c] / unit;
        block[1] += recently[c] * recently[c] / unit;
      }
      const double unit = threshold_at(luminance_of(value)) / candelas_per_unit();
      const double y_recently = luminance_of(recently), y_earlier = luminance_of(earlier);
      recent_seen.add(y_recently * y_recently / unit);
      before_seen.add(y_earlier * y_earlier / unit);
    }
  }
  for (const std::array<double, 2>& block : blocks) {
    before.add(block[0]);
    recent.add(block[1]);
  }
  // The blocks show how certain it is that errors fall faster than 1/n. If a few blocks have most of the error, it is
  // uncertain.
  double deviation = 0.0;
  if (recent.value() > 0.0 && before.value() > 0.0)
    for (const std::array<double, 2>& block : blocks) {
      const double d = block[0] / before.value() - block[1] / recent.value();
      deviation += d * d;
    }
  // While the counts still adapt to the noise, errors fall faster than they will later.
  const bool is_settled = goals_.empty() || two.samples >= kSettledSamples;
  const double confidence = !is_settled ? 0.0 : std::exp(-kErrorConfidence * std::sqrt(deviation));
  const double pixels = double(pixels_.size());
  return {
      error_from_steps(confidence * before.value(), recent.value(), two.samples, one.samples, samples) / (3.0 * pixels),
      error_from_steps(confidence * before_seen.value(), recent_seen.value(), two.samples, one.samples, samples) /
          pixels};
}

std::unique_ptr<Film> make_film(const RenderSettings& s, const std::vector<std::string>& passes) {
  auto film = std::make_unique<Film>(s.region[0], s.region[1], s.region[2], s.region[3], passes);
  film->set_shown_exposure(double(shown_exposure(s)));
  return film;
}

}  // namespace ajar
