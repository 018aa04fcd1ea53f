#include "choice/pilot_comparison.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "denoise/denoise.h"
#include "math/relative_error.h"

namespace ajar {

namespace {

constexpr int kBlur = 3;         // pixels to each side
constexpr double kWorst = 1e-3;  // fraction of the pixels

/// Mean over the channels of each pixel.
std::vector<double> squared_differences(const std::vector<float>& a, const std::vector<float>& b,
                                        const std::vector<float>& light) {
  std::vector<double> result(light.size() / 4, 0.0);
  for (size_t i = 0; i < light.size(); ++i) {
    if (i % 4 == 3) continue;
    const double difference = double(a[i]) - double(b[i]);
    result[i / 4] += difference * difference / (double(light[i]) * double(light[i]) + kDarkSquared) / 3.0;
  }
  return result;
}

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double value : values) total += value;
  return total;
}

double squared_difference(const std::vector<float>& a, const std::vector<float>& b, const std::vector<float>& light) {
  return sum(squared_differences(a, b, light)) / (0.25 * double(light.size()));
}

/// `errors`: squared differences of the two images of a pilot.
PilotNoise noise_of_errors(std::vector<double> errors) {
  const size_t pixels = errors.size(), worst = std::min(pixels, size_t(std::ceil(kWorst * double(pixels))));
  PilotNoise noise;
  noise.whole = 0.25 * sum(errors) / double(pixels);
  std::nth_element(errors.begin(), errors.begin() + std::ptrdiff_t(worst), errors.end(), std::greater<>());
  errors.erase(errors.begin(), errors.begin() + std::ptrdiff_t(worst));
  noise.typical = errors.empty() ? 0.0 : 0.25 * sum(errors) / double(errors.size());
  return noise;
}

}  // namespace

std::vector<float> blurred(std::vector<float> image, int width, int height) {
  std::vector<float> scratch;
  square_mean(image, {width, height, 4}, kBlur, scratch);
  return image;
}

std::vector<float> mean_of(const PilotImages& pilot) {
  std::vector<float> mean(pilot.first.size());
  for (size_t i = 0; i < mean.size(); ++i) mean[i] = 0.5f * (pilot.first[i] + pilot.second[i]);
  return mean;
}

std::vector<float> max_light(const std::vector<const PilotImages*>& pilots, int width, int height) {
  std::vector<float> max_found(pilots[0]->first.size(), 0.0f);
  for (const PilotImages* pilot : pilots) {
    const std::vector<float> found = blurred(mean_of(*pilot), width, height);
    for (size_t i = 0; i < max_found.size(); ++i) max_found[i] = std::max(max_found[i], found[i]);
  }
  return max_found;
}

PilotNoise noise_of(const PilotImages& pilot, const std::vector<float>& light) {
  return noise_of_errors(squared_differences(pilot.first, pilot.second, light));
}

PilotNoise denoised_noise_of(const PilotImages& pilot, const std::vector<float>& light, int width, int height) {
  constexpr int kReach = 2;
  // If all light arrives in single bright pixels, nothing is left without them. This is a lack of light, not of noise.
  constexpr double kLeastCalm = 0.01;
  const size_t pixels = size_t(width) * size_t(height);
  std::vector<float> scratch;
  // The noise of a bright surface does not reach a dark one: it is divided by the light first.
  const auto smooth_noise = [&](std::vector<float> a, const std::vector<float>& b) {
    for (size_t i = 0; i < a.size(); ++i) {
      const double here = double(light[4 * (i / 3) + i % 3]);
      a[i] = float((double(a[i]) - double(b[i])) / std::sqrt(here * here + kDarkSquared));
    }
    window_mean(a, {width, height, 3}, kReach, scratch);
    std::vector<double> errors(pixels, 0.0);
    for (size_t i = 0; i < a.size(); ++i) errors[i / 3] += double(a[i]) * double(a[i]) / 3.0;
    return noise_of_errors(std::move(errors));
  };
  const std::vector<float> first = rgb_of(pilot.first), second = rgb_of(pilot.second);
  const PilotNoise with = smooth_noise(first, second),
                   without = smooth_noise(limited(first, second, width, height), limited(second, first, width, height));
  const auto mean = [](double all, double calm) { return std::sqrt(all * std::max(calm, kLeastCalm * all)); };
  return {mean(with.whole, without.whole), mean(with.typical, without.typical)};
}

double bias_of(const PilotImages& pilot, const PilotImages& unbiased, const std::vector<float>& light, int width,
               int height) {
  const auto blur = [&](const std::vector<float>& image) { return blurred(image, width, height); };
  const double noise = 0.25 * (squared_difference(blur(pilot.first), blur(pilot.second), light) +
                               squared_difference(blur(unbiased.first), blur(unbiased.second), light));
  return std::max(0.0, squared_difference(blur(mean_of(pilot)), blur(mean_of(unbiased)), light) - noise);
}

double unseen_noise_of(const PilotImages& pilot, const PilotImages& other, const std::vector<float>& light, int width,
                       int height) {
  const auto blur = [&](const std::vector<float>& image) { return blurred(image, width, height); };
  const std::vector<float> found[2] = {blur(pilot.first), blur(pilot.second)},
                           there[2] = {blur(other.first), blur(other.second)};
  double total = 0.0;
  for (size_t i = 0; i < light.size(); ++i) {
    if (i % 4 == 3) continue;
    const double missed[2] = {double(there[0][i]) - double(found[0][i]), double(there[1][i]) - double(found[1][i])};
    // The product of two independent estimates of the missed light has no noise in the mean. Half of a negative product
    // belongs to light that is found in excess.
    const double square = missed[0] * missed[1];
    if (square > 0.0 && missed[0] < 0.0) continue;
    total += (square > 0.0 ? square : 0.5 * square) / (double(light[i]) * double(light[i]) + kDarkSquared) / 3.0;
  }
  static_assert(kUnseenPixels == (2 * kBlur + 1) * (2 * kBlur + 1));
  return std::max(0.0, kUnseenPixels * total / (0.25 * double(light.size())));
}

size_t clearly_best(const std::vector<PilotNoise>& techniques) {
  size_t best = 0;
  const auto by_both = [&](size_t k) { return techniques[k].whole * techniques[k].typical; };
  for (size_t k = 1; k < techniques.size(); ++k) {
    if (!(by_both(k) > 0.0)) continue;  // nearly nothing was found
    if (techniques[k].whole * kClearlyBetter >= techniques[0].whole || techniques[k].typical >= techniques[0].typical)
      continue;
    if (best == 0 || by_both(k) < by_both(best)) best = k;
  }
  return best;
}

bool is_hopeless(const PilotNoise& technique, const PilotNoise& first, double factor) {
  return technique.whole > factor * first.whole && technique.typical > factor * first.typical;
}

}  // namespace ajar
