#include "film/image_plan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include "film/tvi.h"
#include "math/random.h"

namespace ajar {

namespace {

/// Fraction of the average count that every pixel gets. It bounds the cost of a wrong prediction, and later decisions
/// use these samples.
constexpr float kFloor = 0.25f;
/// If errors fall like 1/C^p, their sum is minimal with shares to the power 1/(1+p). p is 1 for independent samples,
/// and about 1.5 where a low-discrepancy sequence integrates a smooth function or an edge.
constexpr float kExponent = 0.4f;
/// Maximum count of a pixel, relative to the average. A prediction above it is probably due to a firefly.
constexpr float kMax = 16.0f;
/// Number of binary digits of a count after the first one: low-discrepancy sequences are best at round counts.
constexpr int kRoundDigits = 2, kAllDigits = 31;
/// Standard deviations, in pixels, of the neighbourhoods over which noise is averaged, and fractions of the samples
/// that are distributed equally. The samples decide which of them are best.
constexpr float kReaches[] = {0.7f, 1.5f, 3.0f};
constexpr float kUniformParts[] = {0.01f, 0.1f, 0.25f, 0.5f};
/// All samples are distributed equally unless this reduces the error by more than this fraction, and by more than this
/// number of standard deviations of the reduction. If few bright samples make nearly all the noise, a prediction can be
/// right by accident; the reduction is then about one standard deviation.
constexpr double kMinGain = 0.05, kGainConfidence = 1.5;
/// Time of a sample without its rays, in rays.
constexpr float kCostOfSample = 1.0f;
constexpr float kNearPixels = 4.0f;  // effective number of pixels in a neighbourhood of the narrowest reach
constexpr float kMinWeight = 1e-6f;  // minimum sum of the weights of neighbours
constexpr int kBand = 32;            // rows that one task smooths

/// Estimates from the first samples of a pixel, for one sample; or weighted sums of these over pixels.
struct Noise {
  float weight = 1.0f, mean = 0.0f, variance = 0.0f;  ///< of the displayed luminance
  float stratified = 0.0f;  ///< the variance that independent samples with the noise of the first half would have
  float cost = 0.0f;        ///< time, in rays
  void add(const Noise& n, float w) {
    weight += w * n.weight;
    mean += w * n.mean;
    variance += w * n.variance;
    cost += w * n.cost;
  }
};

/// `exposure`: light times this is displayed.
std::vector<Noise> noise_of_first(EarlySamples& early, size_t pixels, uint32_t count, float exposure) {
  std::vector<Noise> noise(pixels);
  early.join(count);
  for (size_t i = 0; i < pixels; ++i) {
    const EarlySamples::Moments& m = early.first(i);
    noise[i].mean = m.sum / float(count);
    noise[i].variance = std::max(0.0f, m.sum_squared - m.sum * noise[i].mean) / float(count - 1);
    const float difference = 2.0f * early.first_half(i) - m.sum;  // of the sums of both halves
    noise[i].stratified = exposure * exposure * difference * difference / float(count);
    noise[i].mean *= exposure;
    noise[i].variance *= exposure * exposure;
    noise[i].cost = kCostOfSample + early.mean_rays(i, count);
  }
  return noise;
}

/// Calls visit(pixel, own, other) for each pixel, in parallel. `own` and `other` are sums with Gaussian weights over
/// the neighbours of the pixel's colour, without the pixel, and of the other colour.
template <class Visit>
void for_each_neighbourhood(const std::vector<Noise>& noise, int width, float reach, Visit&& visit) {
  const int height = int(noise.size() / size_t(width)), radius = int(std::ceil(2.0f * reach));
  std::vector<float> kernel(size_t(radius) + 1);
  for (int t = 0; t <= radius; ++t) kernel[size_t(t)] = std::exp(-0.5f * float(t * t) / (reach * reach));
  struct Sums {
    Noise of[2] = {{0.0f}, {0.0f}};  ///< own colour, other colour
  };
  tbb::parallel_for(
      tbb::blocked_range<int>(0, (height + kBand - 1) / kBand, 1), [&](const tbb::blocked_range<int>& bands) {
        const int y0 = bands.begin() * kBand, y1 = std::min(bands.end() * kBand, height);
        const int top = std::max(0, y0 - radius), end = std::min(height, y1 + radius);
        std::vector<Sums> rows(size_t(end - top) * size_t(width));
        for (int y = top; y < end; ++y)
          for (int x = 0; x < width; ++x)
            for (int u = std::max(0, x - radius); u <= std::min(width - 1, x + radius); ++u)
              rows[size_t(y - top) * size_t(width) + size_t(x)].of[(u - x) & 1].add(
                  noise[size_t(y) * size_t(width) + size_t(u)], kernel[size_t(std::abs(u - x))]);
        for (int y = y0; y < y1; ++y) {
          for (int x = 0; x < width; ++x) {
            Sums sums;
            for (int v = std::max(0, y - radius); v <= std::min(height - 1, y + radius); ++v)
              for (int color = 0; color < 2; ++color)
                sums.of[color].add(rows[size_t(v - top) * size_t(width) + size_t(x)].of[(color + v - y) & 1],
                                   kernel[size_t(std::abs(v - y))]);
            const size_t i = size_t(y) * size_t(width) + size_t(x);
            sums.of[0].add(noise[i], -1.0f);
            visit(i, sums.of[0], sums.of[1]);
          }
        }
      });
}

/// The error of a pixel with about `count` times the samples for which it is 1. It falls like 1 / C^power at the powers of
/// two of C and like 1 / C between them, where a low-discrepancy sequence is not complete. The count is rounded (see
/// kRoundDigits).
double error_of_count(float count, float power) {
  const auto exact = [&](float c) { return std::exp2((1.0f - power) * std::floor(std::log2(c))) / c; };
  const float whole = std::exp2(std::floor(std::log2(count))), step = whole / float(1 << kRoundDigits);
  const float steps = (count - whole) / step, low = whole + step * std::floor(steps);
  return double(std::lerp(exact(low), exact(low + step), steps - std::floor(steps)));
}

/// Finds the shares of all pixels from the noise of their first samples.
class ShareSearch {
 public:
  ShareSearch(const std::vector<Noise>& noise, int width, ErrorMeasure measure, uint32_t early, bool round_counts)
      : noise_(noise),
        width_(width),
        measure_(measure),
        early_(early),
        round_counts_(round_counts),
        predictions_{std::vector<Prediction>(noise.size()), std::vector<Prediction>(noise.size())},
        shares_(noise.size(), 1.0f) {}

  std::vector<float> find() {
    average_widely();
    for (const float reach : kReaches) {
      predict_shares(reach);
      for (int color = 0; color < 2; ++color) test_shares(color);
    }
    return std::move(shares_);
  }

 private:
  /// The prediction for a pixel from the pixels of one colour.
  struct Prediction {
    float mean = 0.0f, variance = 0.0f;  ///< over the widest reach
    float cost = 1.0f;
    float unit = -1.0f, share = 1.0f;  ///< unit: negative if there is no prediction
    /// Counts in proportion to the share minimise the sum of the errors in a given time.
    void set_share(float noise, float time) { share = std::pow(noise / (unit * time), kExponent); }
  };

  template <class Visit>
  void for_each_of(int color, Visit&& visit) const {
    const int height = int(noise_.size() / size_t(width_));
    for (int y = 0; y < height; ++y)
      for (int x = (y + color) & 1; x < width_; x += 2) visit(size_t(y) * size_t(width_) + size_t(x));
  }

  void average_widely();
  float unit_of(const Noise& near, const Prediction& wide) const;
  void predict_shares(float reach);
  float power_of(int color) const;
  void test_shares(int color);

  const std::vector<Noise>& noise_;
  int width_;
  ErrorMeasure measure_;
  uint32_t early_;
  bool round_counts_;
  /// Predictions for each pixel: from its own colour without itself, to test shares, and from the other colour, to set
  /// them.
  std::vector<Prediction> predictions_[2];
  std::vector<float> shares_;
  double best_[2] = {0.0, 0.0};  ///< gain of the shares of each colour
};

void ShareSearch::average_widely() {
  for_each_neighbourhood(noise_, width_, kReaches[2], [&](size_t i, const Noise& own, const Noise& other) {
    const Noise* const sums[2] = {&own, &other};
    for (int k = 0; k < 2; ++k)
      if (sums[k]->weight > kMinWeight)
        predictions_[k][i] = {sums[k]->mean / sums[k]->weight, std::max(0.0f, sums[k]->variance / sums[k]->weight),
                              sums[k]->cost / sums[k]->weight};
  });
}

/// The squared error that counts as one. The luminance is that of the nearest neighbours, as far as it differs from the
/// wider neighbourhood by more than the noise [James and Stein 1961].
float ShareSearch::unit_of(const Noise& near, const Prediction& wide) const {
  const float difference = near.mean / near.weight - wide.mean,
              noise_of_near = wide.variance / (kNearPixels * float(early_));
  const float kept = difference * difference > noise_of_near ? 1.0f - noise_of_near / (difference * difference) : 0.0f;
  const float mean = std::max(0.0f, wide.mean + kept * difference);
  return measure_ == ErrorMeasure::Relative ? mean * mean + float(kDarkSquared)
                                            : float(tvi(double(mean) * kCandelasPerUnit) / kCandelasPerUnit);
}

void ShareSearch::predict_shares(float reach) {
  if (reach == kReaches[2]) {
    for (std::vector<Prediction>& of_color : predictions_)
      for (Prediction& p : of_color)
        if (p.unit > 0.0f) p.set_share(p.variance, p.cost);
    return;
  }
  for_each_neighbourhood(noise_, width_, reach, [&](size_t i, const Noise& own, const Noise& other) {
    const Noise* const sums[2] = {&own, &other};
    for (int k = 0; k < 2; ++k) {
      if (!(sums[k]->weight > kMinWeight)) continue;
      Prediction& p = predictions_[k][i];
      if (reach == kReaches[0]) p.unit = unit_of(*sums[k], p);
      if (p.unit > 0.0f)
        p.set_share(std::max(0.0f, sums[k]->variance / sums[k]->weight), sums[k]->cost / sums[k]->weight);
    }
  });
}

/// The power with which the error of the pixels of a colour falls. It is 1 for independent samples, for which both
/// estimates of the variance are equal.
float ShareSearch::power_of(int color) const {
  constexpr double kMost = 3.0;
  double independent = 0.0, stratified = 0.0;
  for_each_of(color, [&](size_t i) {
    const float unit = predictions_[0][i].unit;
    if (!(unit > 0.0f)) return;
    independent += double(noise_[i].variance / unit);
    stratified += double(noise_[i].stratified / unit);
  });
  if (!(independent > stratified)) return 1.0f;
  return float(stratified > 0.0 ? std::min(1.0 + std::log(independent / stratified) / std::log(double(early_)), kMost)
                                : kMost);
}

/// Pixels of the other colour decide which reach and which equal fraction are best. Each of them is predicted by its own
/// colour, and its own samples are independent of this prediction.
void ShareSearch::test_shares(int color) {
  double sum_own = 0.0, sum_other = 0.0;
  size_t seen = 0, pixels = 0;
  for_each_of(color, [&](size_t i) {
    sum_other += double(predictions_[1][i].share);
    ++pixels;
  });
  for_each_of(1 - color, [&](size_t i) {
    if (!(predictions_[0][i].unit > 0.0f)) return;
    sum_own += double(predictions_[0][i].share);
    ++seen;
  });
  if (!(sum_own > 0.0) || !(sum_other > 0.0)) return;
  const float power = round_counts_ ? power_of(1 - color) : 1.0f;
  const float scale_own = float(double(seen) / sum_own), scale_other = float(double(pixels) / sum_other);
  const auto for_each_test = [&](float part, auto&& visit) {
    for_each_of(1 - color, [&](size_t i) {
      const Prediction& p = predictions_[0][i];
      // The mean of both estimates: the second one alone has much noise.
      if (p.unit > 0.0f)
        visit(std::max(kFloor, part + (1.0f - part) * scale_own * p.share),
              0.5f * (noise_[i].variance + noise_[i].stratified) / p.unit, noise_[i].cost);
    });
  };
  for (const float part : kUniformParts) {
    double time = 0.0, time_of_one = 0.0, even = 0.0, less = 0.0, square = 0.0;
    for_each_test(part, [&](float count, float, float cost) {
      time += double(count * cost);
      time_of_one += double(cost);
    });
    const double even_count = time / time_of_one;  // of all pixels in the same time
    for_each_test(part, [&](float count, float error, float) {
      const double change = double(error) * (1.0 - even_count * error_of_count(count, power));
      even += double(error);
      less += change;
      square += change * change;
    });
    const double gain = less - kGainConfidence * std::sqrt(square);
    if (!(gain > best_[color]) || less < kMinGain * even) continue;
    best_[color] = gain;
    for_each_of(color, [&](size_t i) { shares_[i] = part + (1.0f - part) * scale_other * predictions_[1][i].share; });
  }
}

/// Threshold at which a fraction of a sample becomes a sample of this pixel, spread evenly over the plane [Roberts
/// 2018, the R2 sequence].
float threshold(int x, int y, float offset) {
  const double t = 0.7548776662466927 * x + 0.5698402909980532 * y + double(offset);
  return std::min(float(t - std::floor(t)), 0x1.fffffep-1f);
}

/// A round number near y. Its mean over all thresholds is y.
uint32_t round_count(float y, float threshold, int digits) {
  const uint32_t whole = uint32_t(y);
  const int drop = int(std::bit_width(whole)) - 1 - digits;
  const uint32_t step = drop > 0 ? 1u << drop : 1u, base = whole & ~(step - 1);
  return base + ((y - float(base)) / float(step) + threshold >= 1.0f ? step : 0u);
}

/// Number of pixels of one colour in the first `rows` rows. Colour 0 is that of the first pixel.
size_t pixels_of(int color, int width, int rows) { return (size_t(rows) * size_t(width) + size_t(1 - color)) / 2; }

/// A pixel to which samples are distributed.
struct Place {
  size_t pixel;
  float share, threshold;
  uint32_t min_goal;
};

/// Two values of lambda and the number of samples that they need.
struct LambdaBounds {
  float low, high;
  uint64_t at_low, at_high;
};

/// Moves the bounds up until `high` needs the wanted number of samples.
template <class Total>
void raise(LambdaBounds& b, uint64_t wanted, Total&& total) {
  while (b.at_high < wanted && b.high < 1e30f)
    b.low = b.high, b.at_low = b.at_high, b.high *= 2.0f, b.at_high = total(b.high);
}

/// Moves the bounds together until `low` needs the wanted number of samples or no number lies between them, by secant
/// and bisection steps in turn. Then the goals of more samples are nowhere lower. `total(lambda)` is the number needed.
template <class Total>
void narrow(LambdaBounds& b, uint64_t wanted, Total&& total) {
  for (bool secant = true; b.at_low < wanted; secant = !secant) {
    const float part = secant ? std::clamp(float(wanted - b.at_low) / float(b.at_high - b.at_low), 0.02f, 0.98f) : 0.5f;
    const float middle = b.low + part * (b.high - b.low);
    if (!(middle > b.low && middle < b.high)) break;
    const uint64_t at_middle = total(middle);
    if (at_middle <= wanted)
      b.low = middle, b.at_low = at_middle;
    else
      b.high = middle, b.at_high = at_middle;
  }
}

/// Bounds of the lambda that needs `samples` for each place on average. A part of the places is counted first, then all
/// of them near that result, and then those whose count is still open.
template <class Count>
LambdaBounds bounds_of_lambda(const std::vector<Place>& places, uint32_t samples, double sum_of_shares,
                              const Count& count) {
  constexpr size_t kFewPlaces = 4096;
  constexpr float kNear = 0.01f;
  const auto sum = [&](const std::vector<Place>& of, float lambda, size_t step = 1) {
    return tbb::parallel_reduce(
        tbb::blocked_range<size_t>(0, (of.size() + step - 1) / step, 4096), uint64_t(0),
        [&](const tbb::blocked_range<size_t>& range, uint64_t so_far) {
          for (size_t i = range.begin(); i != range.end(); ++i) so_far += count(of[i * step], lambda);
          return so_far;
        },
        std::plus<>());
  };
  // An odd step, so that the chosen places are not all in the same columns.
  const size_t step = places.size() / kFewPlaces | 1;
  const float middle = float(double(samples) * double(places.size()) / sum_of_shares);
  const auto of_few = [&](float lambda) { return sum(places, lambda, step); };
  LambdaBounds b{0.0f, middle, of_few(0.0f), of_few(middle)};
  const uint64_t wanted_of_few = uint64_t(samples) * ((places.size() + step - 1) / step);
  raise(b, wanted_of_few, of_few);
  narrow(b, wanted_of_few, of_few);
  if (step == 1) return b;
  const auto of_all = [&](float lambda) { return sum(places, lambda); };
  const uint64_t wanted = uint64_t(samples) * places.size();
  b.low *= 1.0f - kNear, b.high *= 1.0f + kNear;
  b.at_low = of_all(b.low), b.at_high = of_all(b.high);
  if (b.at_low > wanted) b.low = 0.0f, b.at_low = of_all(0.0f);
  raise(b, wanted, of_all);
  std::vector<Place> open;
  std::copy_if(places.begin(), places.end(), std::back_inserter(open),
               [&](const Place& p) { return count(p, b.low) != count(p, b.high); });
  const uint64_t others = b.at_low - sum(open, b.low);
  narrow(b, wanted, [&](float lambda) { return others + sum(open, lambda); });
  return b;
}

}  // namespace

ImagePlan::ImagePlan(ErrorMeasure measure, uint32_t first, uint32_t seed, Importance importance, Counts counts)
    : measure_(measure),
      first_(std::bit_ceil(std::max(2u, first))),
      seed_(seed),
      digits_(counts == Counts::Round ? kRoundDigits : kAllDigits),
      find_importance_(std::move(importance)) {}

uint32_t ImagePlan::looked_at(uint32_t done) const {
  if (done < first_) return 0;
  return std::max(first_, std::bit_floor(std::max(1u, uint32_t(kFloor * float(done)))));
}

uint32_t ImagePlan::next_decision(uint32_t done) const {
  return done < first_ ? first_ : uint32_t(float(2 * looked_at(done)) / kFloor);
}

void ImagePlan::plan(Film& film, uint32_t samples) {
  if (looked_at(planned_) > early_) decide(film);
  planned_ = samples;
  std::vector<uint32_t> goals(size_t(film.width()) * size_t(film.height()), samples);
  if (early_ > 0)
    for (int color = 0; color < 2; ++color) share_out(film.width(), color, samples, goals);
  film.set_goals(std::move(goals));
}

void ImagePlan::decide(Film& film) {
  early_ = looked_at(planned_);
  decided_goals_ = film.goals();
  const std::vector<Noise> noise = noise_of_first(film.early_samples(), decided_goals_.size(), early_,
                                                  float(film.shown_exposure()));
  shares_ = ShareSearch(noise, film.width(), measure_, early_, digits_ == kRoundDigits).find();
  if (find_importance_) importance_ = std::exchange(find_importance_, {})();
  for (size_t i = 0; i < importance_.size(); ++i) shares_[i] *= importance_[i];
}

/// Goals of the pixels of one colour: `samples` on average, but at least the decided goal of each pixel and the floor.
void ImagePlan::share_out(int width, int color, uint32_t samples, std::vector<uint32_t>& goals) const {
  const int height = int(goals.size() / size_t(width));
  const float offset = to_unit_float(hash_combine(seed_, early_)),
              floor = std::max(float(first_), kFloor * float(samples));
  std::vector<Place> places(pixels_of(color, width, height));
  tbb::parallel_for(0, height, [&](int y) {
    size_t at = pixels_of(color, width, y);
    for (int x = (y + color) & 1; x < width; x += 2, ++at) {
      const size_t i = size_t(y) * size_t(width) + size_t(x);
      const float t = threshold(x, y, offset);
      places[at] = {i, shares_[i], t, std::max(decided_goals_[i], round_count(floor, t, digits_))};
    }
  });
  double sum_of_shares = 0.0;
  for (const Place& p : places) sum_of_shares += double(p.share);
  if (!(sum_of_shares > 0.0) || !std::isfinite(sum_of_shares)) {  // no pixel varies
    for (const Place& p : places) goals[p.pixel] = std::max(samples, decided_goals_[p.pixel]);
    return;
  }
  const float max_count = kMax * float(samples);
  const auto count = [&](const Place& p, float lambda) {
    return std::max(p.min_goal, round_count(std::min(max_count, lambda * p.share), p.threshold, digits_));
  };
  const uint64_t wanted = uint64_t(samples) * places.size();
  const LambdaBounds found = bounds_of_lambda(places, samples, sum_of_shares, count);
  // The remaining samples go to the pixels that would get more with a slightly larger lambda.
  uint64_t left = wanted - std::min(wanted, found.at_low);
  for (const Place& p : places) {
    goals[p.pixel] = count(p, found.low);
    const uint32_t more = uint32_t(std::min<uint64_t>(left, count(p, found.high) - goals[p.pixel]));
    goals[p.pixel] += more;
    left -= more;
  }
}

}  // namespace ajar
