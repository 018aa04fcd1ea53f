#include "film/image_plan.h"

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <span>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "film/tvi.h"
#include "math/random.h"

namespace ajar {

namespace {

/// Of the average pixel's samples, what every pixel has for certain. It bounds what a wrong guess can cost, and is
/// the past that later decisions look at.
constexpr float kFloor = 0.25f;
/// Errors that fall like 1/C^p are least in sum with shares to the power 1/(1+p): p is 1 for independent samples, and 1.5 or so
/// where the low-discrepancy sequence has a smooth or an edge to integrate.
constexpr float kExponent = 0.4f;
/// No pixel gets more than so many times the average: beyond, it is a stray sample that speaks.
constexpr float kMost = 16.0f;
/// Counts keep this many binary digits below their first: low-discrepancy sequences are best cut at round numbers.
constexpr int kDigits = 1;
/// Estimates from few samples are drawn towards those of a wide neighbourhood: as if so many samples had found its variance, and so many
/// pixels the difference that it expects of their halves.
constexpr float kWideSamples = 8.0f, kWideHalves = 6.0f;
constexpr int kWideReach = 3;

/// Neighbours with their weights: of the other colour, from which shares are made, and of the same, which tell how good such shares are.
struct Neighbour {
  int x, y;
  float weight;
};
constexpr float kFar = 0.2f;
constexpr Neighbour kOther[] = {{1, 0, 1.0f},   {-1, 0, 1.0f},  {0, 1, 1.0f},  {0, -1, 1.0f}, {2, 1, kFar},  {2, -1, kFar},
                                {-2, 1, kFar}, {-2, -1, kFar}, {1, 2, kFar}, {1, -2, kFar}, {-1, 2, kFar}, {-1, -2, kFar}};
constexpr Neighbour kSame[] = {{1, 1, 1.0f}, {1, -1, 1.0f}, {-1, 1, 1.0f}, {-1, -1, 1.0f}, {2, 0, kFar}, {-2, 0, kFar}, {0, 2, kFar}, {0, -2, kFar}};
/// Parts of the samples that may be shared out equally; which is best, the samples tell.
constexpr float kUniformParts[] = {0.01f, 0.1f, 0.25f, 0.5f, 0.75f, 1.0f};

/// What the first samples of a pixel tell, of one sample's luminance.
struct Noise {
  float mean = 0.0f;
  float variance = 0.0f;
  float halves = 0.0f;   ///< the variance that explains how far the means of the two halves are apart: less where strata help
};

std::vector<Noise> noise_of_first(EarlySamples& early, size_t pixels, uint32_t count) {
  std::vector<Noise> noise(pixels);
  early.join(count / 2);
  for (size_t i = 0; i < pixels; ++i) noise[i].halves = early.first(i).sum;
  early.join(count);
  for (size_t i = 0; i < pixels; ++i) {
    const EarlySamples::Moments& m = early.first(i);
    const float difference = 2.0f * noise[i].halves - m.sum;
    noise[i].mean = m.sum / float(count);
    noise[i].variance = std::max(0.0f, m.sum_squared - m.sum * noise[i].mean) / float(count - 1);
    noise[i].halves = difference * difference / float(count);
  }
  return noise;
}

/// Sums along rows over the wide neighbourhood, of the pixels of one colour.
std::vector<Noise> wide_sums(const std::vector<Noise>& noise, int width, int color) {
  std::vector<Noise> sums(noise.size());
  for (size_t i = 0; i < noise.size(); ++i) {
    const int x = int(i % size_t(width)), y = int(i / size_t(width));
    for (int u = std::max(0, x - kWideReach); u <= std::min(width - 1, x + kWideReach); ++u) {
      if (((u + y) & 1) != color) continue;
      const Noise& n = noise[i + size_t(u) - size_t(x)];
      sums[i].mean += 1.0f;   // here: how many
      sums[i].variance += n.variance;
      sums[i].halves += n.halves;
    }
  }
  return sums;
}

/// Threshold at which a pixel's leftover fraction becomes samples: spread evenly over the plane [Roberts 2018, the R2 sequence].
float threshold(int x, int y, float offset) {
  const double t = 0.7548776662466927 * x + 0.5698402909980532 * y + double(offset);
  return std::min(float(t - std::floor(t)), 0x1.fffffep-1f);
}

/// A round number next to y, such that its mean over all thresholds is y.
uint32_t round_count(float y, float threshold) {
  const uint32_t whole = uint32_t(y);
  const int drop = int(std::bit_width(whole)) - 1 - kDigits;
  const uint32_t step = drop > 0 ? 1u << drop : 1u, base = whole & ~(step - 1);
  return base + ((y - float(base)) / float(step) + threshold >= 1.0f ? step : 0u);
}

}  // namespace

ImagePlan::ImagePlan(ErrorMeasure measure, uint32_t first, uint32_t seed, std::vector<float> importance)
    : measure_(measure), first_(std::bit_ceil(std::max(2u, first))), seed_(seed), importance_(std::move(importance)) {}

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
  const int width = film.width(), height = film.height();
  early_ = looked_at(planned_);
  decided_goals_ = film.goals();
  const std::vector<Noise> noise = noise_of_first(film.early_samples(), decided_goals_.size(), early_);
  const std::vector<Noise> rows[2] = {wide_sums(noise, width, 0), wide_sums(noise, width, 1)};
  const auto unit = [&](float mean) {
    return measure_ == ErrorMeasure::Relative ? mean * mean + 0.01f : float(tvi(double(mean) * kCandelasPerUnit) / kCandelasPerUnit);
  };
  // The error of a pixel, per sample, that its neighbours let expect, and its unit. Negative: it has none.
  struct Expected {
    float error = -1.0f, unit = 1.0f;
  };
  const auto expect = [&](int x, int y, std::span<const Neighbour> neighbours, bool same) -> Expected {
    Noise near, wide;
    float weight = 0.0f;
    for (const Neighbour& n : neighbours) {
      const int u = x + n.x, v = y + n.y;
      if (u < 0 || u >= width || v < 0 || v >= height) continue;
      const Noise& other = noise[size_t(v) * size_t(width) + size_t(u)];
      near.mean += n.weight * other.mean;
      near.variance += n.weight * other.variance;
      near.halves += n.weight * other.halves;
      weight += n.weight;
    }
    if (weight == 0.0f) return {};
    for (int v = std::max(0, y - kWideReach); v <= std::min(height - 1, y + kWideReach); ++v) {
      const Noise& row = rows[(x + y + (same ? 0 : 1)) & 1][size_t(v) * size_t(width) + size_t(x)];
      wide.mean += row.mean;
      wide.variance += row.variance;
      wide.halves += row.halves;
    }
    if (same) {
      const Noise& own = noise[size_t(y) * size_t(width) + size_t(x)];
      wide.mean -= 1.0f;
      wide.variance = std::max(0.0f, wide.variance - own.variance);
      wide.halves = std::max(0.0f, wide.halves - own.halves);
    }
    // How noisy it is here, by the scatter of samples; how much less that matters because they are stratified, by the halves.
    const float scatter = (float(early_) * near.variance + kWideSamples * wide.variance / wide.mean) / (float(early_) * weight + kWideSamples);
    const float kept = wide.variance > 0.0f ? std::min(1.0f, wide.halves / wide.variance) : 1.0f;
    const float here = unit(std::max(0.0f, near.mean / weight));
    return {(near.halves + kWideHalves * kept * scatter) / (weight + kWideHalves) / here, here};
  };

  shares_.assign(noise.size(), 1.0f);
  struct Test {
    float error, share;
  };
  std::vector<Test> tests[2];
  double sum_of_shares[2] = {0.0, 0.0}, sum_of_tests[2] = {0.0, 0.0};
  size_t pixels[2] = {0, 0};
  for (size_t i = 0; i < noise.size(); ++i) {
    const int x = int(i % size_t(width)), y = int(i / size_t(width)), color = (x + y) & 1;
    if (const Expected e = expect(x, y, kOther, false); e.error >= 0.0f) shares_[i] = std::pow(e.error, kExponent);
    sum_of_shares[color] += double(shares_[i]);
    ++pixels[color];
    if (const Expected e = expect(x, y, kSame, true); e.error >= 0.0f) {
      tests[color].push_back({noise[i].variance / e.unit, std::pow(e.error, kExponent)});
      sum_of_tests[color] += double(tests[color].back().share);
    }
  }
  // Rare bright samples make noise where their neighbours saw none. How much of it there is, pixels of the other colour tell: each was foretold by
  // its like and has samples of its own, independent of theirs. The part shared out equally is the one with the least error there.
  for (int color = 0; color < 2; ++color) {
    const std::vector<Test>& seen = tests[1 - color];
    const float mean_test = seen.empty() ? 0.0f : float(sum_of_tests[1 - color] / double(seen.size()));
    const float mean_share = pixels[color] > 0 ? float(sum_of_shares[color] / double(pixels[color])) : 0.0f;
    double least = std::numeric_limits<double>::infinity();
    float best = 1.0f;
    for (const float part : kUniformParts) {
      double error = 0.0;
      for (const Test& test : seen) error += double(test.error / std::max(kFloor, part + (1.0f - part) * test.share / mean_test));
      if (error < least) least = error, best = part;
    }
    for (size_t i = 0; i < noise.size(); ++i)
      if (((i % size_t(width) + i / size_t(width)) & 1) == size_t(color)) shares_[i] = best * mean_share + (1.0f - best) * shares_[i];
  }
  for (size_t i = 0; i < importance_.size(); ++i) shares_[i] *= importance_[i];
}

/// Goals of the pixels of one colour: `samples` for each on average, none below what it has, nor below the floor.
void ImagePlan::share_out(int width, int color, uint32_t samples, std::vector<uint32_t>& goals) const {
  struct Place {
    size_t pixel;
    float share, threshold;
    uint32_t least;
  };
  std::vector<Place> places;
  places.reserve(goals.size() / 2 + 1);
  const float offset = to_unit_float(hash_combine(seed_, early_)), floor = std::max(float(first_), kFloor * float(samples));
  double sum_of_shares = 0.0;
  for (size_t i = 0; i < goals.size(); ++i) {
    const int x = int(i % size_t(width)), y = int(i / size_t(width));
    if (((x + y) & 1) != color) continue;
    const float t = threshold(x, y, offset);
    places.push_back({i, shares_[i], t, std::max(decided_goals_[i], round_count(floor, t))});
    sum_of_shares += double(shares_[i]);
  }
  if (!(sum_of_shares > 0.0) || !std::isfinite(sum_of_shares)) {   // nothing varies
    for (const Place& p : places) goals[p.pixel] = std::max(samples, decided_goals_[p.pixel]);
    return;
  }
  const float most = kMost * float(samples);
  const auto count = [&](const Place& p, float lambda) { return std::max(p.least, round_count(std::min(most, lambda * p.share), p.threshold)); };
  const auto total = [&](float lambda) {
    return tbb::parallel_reduce(
        tbb::blocked_range<size_t>(0, places.size(), 4096), uint64_t(0),
        [&](const tbb::blocked_range<size_t>& range, uint64_t sum) {
          for (size_t i = range.begin(); i != range.end(); ++i) sum += count(places[i], lambda);
          return sum;
        },
        std::plus<>());
  };
  // The largest lambda for which the samples suffice: by secants and bisections in turn.
  const uint64_t wanted = uint64_t(samples) * places.size();
  float low = 0.0f, high = float(double(wanted) / sum_of_shares);
  uint64_t at_low = total(low), at_high = total(high);
  while (at_high < wanted && high < 1e30f) low = high, at_low = at_high, high *= 2.0f, at_high = total(high);
  for (bool secant = true; at_low < wanted; secant = !secant) {
    const float part = secant ? std::clamp(float(wanted - at_low) / float(at_high - at_low), 0.02f, 0.98f) : 0.5f;
    const float middle = low + part * (high - low);
    if (!(middle > low && middle < high)) break;
    const uint64_t at_middle = total(middle);
    if (at_middle <= wanted) low = middle, at_low = at_middle;
    else high = middle, at_high = at_middle;
  }
  // Samples that are left go to those whose turn is next; they have equal claims.
  uint64_t left = wanted - std::min(wanted, at_low);
  for (const Place& p : places) {
    goals[p.pixel] = count(p, low);
    const uint32_t more = uint32_t(std::min<uint64_t>(left, count(p, high) - goals[p.pixel]));
    goals[p.pixel] += more;
    left -= more;
  }
}

}  // namespace ajar
