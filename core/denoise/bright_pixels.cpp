#include "denoise/bright_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ajar {

namespace {

constexpr float kBright = 2.5f;  // times the denoised light around: a pixel that is far brighter
constexpr float kDim = 0.02f;    // added to that light
// Among bright pixels of rare light, brighter ones are found.
constexpr float kRatios[] = {kBright, 8.0f * kBright, 64.0f * kBright};
constexpr float kUsualBright = 1.25f;  // times the brightest pixel of one half around
constexpr int kReach = 8;              // pixels to each side of the window in which bright pixels are counted
constexpr int kSamePlace = 3;          // pixels to each side in which the halves agree about a place
constexpr int kOtherPlace = 12;        // pixels to a place that has nothing to do with this one
constexpr int kOfDetail = 3;           // pixels to each side of an agreement that belong to the same detail
constexpr float kChance = 20.0f;       // times noise over energy: how far pixels can be bright in both halves by chance
constexpr float kMinPixels = 1.5f;     // with light in both halves, if they can be so by chance
constexpr float kPixels = float((2 * kReach + 1) * (2 * kReach + 1));

/// The denoised light around each pixel.
std::vector<float> light_around(const std::vector<float>& light_a, const std::vector<float>& light_b,
                                ImageSize one_channel) {
  std::vector<float> around(one_channel.values()), scratch;
  for_pixels(around.size(),
             [&](size_t i) { around[i] = 0.5f * (luminance_at(light_a, i) + luminance_at(light_b, i)); });
  square_max(around, one_channel, 1, scratch);
  return around;
}

/// 1 for the pixels of each half that are more than `ratio` times brighter than the light around them, else 0.
struct BrightInHalves {
  std::vector<float> a, b;
};
BrightInHalves bright_in(const Halves& halves, const std::vector<float>& around, float ratio) {
  BrightInHalves bright{std::vector<float>(around.size()), std::vector<float>(around.size())};
  for_pixels(around.size(), [&](size_t i) {
    const float limit = ratio * (around[i] + kDim);
    bright.a[i] = luminance_at(halves.a, i) > limit ? 1.0f : 0.0f;
    bright.b[i] = luminance_at(halves.b, i) > limit ? 1.0f : 0.0f;
  });
  return bright;
}

/// Pixels that are bright in both halves by chance (BrightPixels::by_chance).
std::vector<float> by_chance_of(const Halves& halves, const BrightInHalves& bright, ImageSize one_channel) {
  std::vector<float> share(one_channel.values()), both(share.size()), scratch;
  std::vector<float> brightest(share.size());  // of those in one half
  for_pixels(share.size(), [&](size_t i) {
    both[i] = bright.a[i] * bright.b[i];
    if (bright.a[i] == bright.b[i]) return;
    share[i] = 0.5f;
    brightest[i] = std::max(luminance_at(halves.a, i), luminance_at(halves.b, i));
  });
  std::vector<float> together = both;
  square_mean(share, one_channel, kReach, scratch);
  square_mean(together, one_channel, kReach, scratch);
  square_max(brightest, one_channel, kReach, scratch);
  for_pixels(both.size(), [&](size_t i) {
    // About the number that independent halves exceed with a probability of 1e-3.
    const float expected = kPixels * share[i] * share[i],
                likely = expected + 3.0f * std::sqrt(expected) + std::min(1.0f, 1e3f * expected);
    const bool is_usual = std::min(luminance_at(halves.a, i), luminance_at(halves.b, i)) <= kUsualBright * brightest[i];
    both[i] = both[i] > 0.0f && is_usual && kPixels * together[i] <= likely + 0.01f ? 1.0f : 0.0f;
  });
  return both;
}

/// Adds the pixels of details among these pixels.
void add_details(const BrightInHalves& bright, ImageSize one_channel, std::vector<float>& details) {
  const auto [width, height, channels] = one_channel;
  std::vector<float> near_a = bright.a, near_b = bright.b, scratch;
  square_max(near_a, one_channel, kSamePlace, scratch);
  square_max(near_b, one_channel, kSamePlace, scratch);
  std::vector<float> here(bright.a.size()), there(bright.a.size());  // how often the halves agree: 0 to 2
  constexpr std::array<std::array<int, 2>, 4> kShifts{
      {{kOtherPlace, 0}, {-kOtherPlace, 0}, {0, kOtherPlace}, {0, -kOtherPlace}}};
  for_rows(height, [&, width = width, height = height](int y) {
    for (int x = 0; x < width; ++x) {
      const auto at = [&](int u, int v) { return size_t(v) * size_t(width) + size_t(u); };
      const size_t i = at(x, y);
      if (bright.a[i] + bright.b[i] == 0.0f) continue;
      here[i] = bright.a[i] * near_b[i] + bright.b[i] * near_a[i];
      for (const auto& [dx, dy] : kShifts) {
        const int u = std::clamp(x + dx, 0, width - 1), v = std::clamp(y + dy, 0, height - 1);
        there[i] += (bright.a[i] * near_b[at(u, v)] + bright.b[i] * near_a[at(u, v)]) / float(kShifts.size());
      }
    }
  });
  std::vector<float> often = here;
  square_mean(often, one_channel, kReach, scratch);
  square_mean(there, one_channel, kReach, scratch);
  for_pixels(here.size(), [&](size_t i) {
    const float by_chance = kPixels * there[i];
    if (kPixels * often[i] <= 2.0f * by_chance + 3.0f * std::sqrt(by_chance) + 0.5f) here[i] = 0.0f;
  });
  square_max(here, one_channel, kOfDetail, scratch);
  for_pixels(here.size(), [&](size_t i) {
    if (here[i] > 0.0f && bright.a[i] + bright.b[i] > 0.0f) details[i] = 1.0f;
  });
}

/// The weights of details (BrightPixels::detail_weight).
std::vector<float> weights_of(const BrightPixels& bright, const Halves& halves, const std::vector<float>& light_a,
                              const std::vector<float>& light_b, ImageSize one_channel) {
  const auto& [a, b] = halves;
  const ImageSize three_channels{one_channel.width, one_channel.height, 3};
  std::vector<float> sums(three_channels.values()), weights(one_channel.values()), scratch;
  const float brightest = std::max(*std::max_element(a.begin(), a.end()), *std::max_element(b.begin(), b.end()));
  const float unit = 1.0f / std::max(brightest, 1.0f);  // so that fourth powers of light are finite
  for_pixels(weights.size(), [&](size_t i) {
    if (bright.detail[i] == 0.0f || bright.by_chance[i] > 0.0f) return;
    float error = 0.0f, noise = 0.0f;
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
      const float one = unit * a[c], two = unit * b[c], of_a = unit * light_a[c], of_b = unit * light_b[c];
      error += 0.5f * ((one - of_a) * (two - of_a) + (one - of_b) * (two - of_b));
      noise += 0.25f * (one - two) * (one - two);
    }
    sums[3 * i] = error;
    sums[3 * i + 1] = noise;
    // The variance of the error by what can be so by chance.
    if (error > 0.0f) sums[3 * i + 2] = std::min(1.0f, kChance * noise / error) * error * error;
  });
  square_mean(sums, three_channels, kOfDetail, scratch);
  constexpr float kWindow = float((2 * kOfDetail + 1) * (2 * kOfDetail + 1));
  for_pixels(weights.size(), [&](size_t i) {
    const float error = sums[3 * i], noise = sums[3 * i + 1];
    if (bright.detail[i] == 0.0f || !(error > 0.0f)) return;
    const double variance = double(kMinPixels * sums[3 * i + 2]) / (double(kWindow) * double(error) * double(error));
    weights[i] = float(std::max(0.0, 1.0 - variance)) * error / (error + noise);
  });
  return weights;
}

}  // namespace

BrightPixels bright_pixels_of(const Halves& halves, const std::vector<float>& light_a,
                              const std::vector<float>& light_b, ImageSize size) {
  const ImageSize one_channel{size.width, size.height, 1};
  const std::vector<float> around = light_around(light_a, light_b, one_channel);
  const BrightInHalves bright = bright_in(halves, around, kBright);
  BrightPixels result{by_chance_of(halves, bright, one_channel), std::vector<float>(around.size()), {}};
  for_pixels(around.size(),
             [&](size_t i) { result.detail[i] = bright.a[i] * bright.b[i] * (1.0f - result.by_chance[i]); });
  for (const float ratio : kRatios) add_details(bright_in(halves, around, ratio), one_channel, result.detail);
  result.detail_weight = weights_of(result, halves, light_a, light_b, one_channel);
  return result;
}

}  // namespace ajar
