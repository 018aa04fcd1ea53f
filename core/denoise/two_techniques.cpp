#include "denoise/two_techniques.h"

#include <algorithm>
#include <cmath>

#include "math/types.h"

namespace ajar {

namespace {

constexpr float kDarkest = 0.01f;   // added to squares of light, as in relMSE
constexpr int kReach = 3;           // pixels to each side of the window in which N - D is averaged
constexpr int kWideReach = 8;       // pixels to each side of the window of its energy
constexpr float kMinEnergy = 2.0f;  // times the noise

/// Errors of `denoised`, relative as its own estimate, that the rendered image `other` of the other technique shows.
std::vector<float> errors_shown_by(const Halves& other, const Denoised& denoised,
                                   const std::vector<float>& inverse_light, ImageSize size) {
  std::vector<float> residual(size.values()), noise(size.values()), scratch;
  for (size_t i = 0; i < residual.size(); ++i) {
    residual[i] = (0.5f * (other.a[i] + other.b[i]) - denoised.image[i]) * inverse_light[i / 3];
    noise[i] = 0.5f * (other.a[i] - other.b[i]) * inverse_light[i / 3];
  }
  square_mean(residual, size, kReach, scratch);
  square_mean(noise, size, kReach, scratch);
  std::vector<float> wide = residual;
  square_mean(wide, size, kWideReach - kReach, scratch);
  std::vector<float> energies(2 * size.values() / 3);
  for (size_t i = 0; i < residual.size(); ++i) {
    const float r = residual[i] - std::min(0.0f, wide[i]);
    energies[2 * (i / 3)] += r * r / 3.0f;
    energies[2 * (i / 3) + 1] += noise[i] * noise[i] / 3.0f;
  }
  square_mean(energies, {size.width, size.height, 2}, kWideReach, scratch);
  std::vector<float> errors(energies.size() / 2);
  for (size_t i = 0; i < errors.size(); ++i)
    errors[i] = std::max(0.0f, energies[2 * i] - kMinEnergy * energies[2 * i + 1]);
  return errors;
}

}  // namespace

Denoised mean_of_techniques(const TechniqueImage& one, const TechniqueImage& two, ImageSize size) {
  std::vector<float> inverse_light(size.values() / 3);
  for (size_t i = 0; i < inverse_light.size(); ++i) {
    const auto light = [i](const Denoised& d) {
      return luminance(Color(d.image[3 * i], d.image[3 * i + 1], d.image[3 * i + 2]));
    };
    const float y = 0.5f * (light(one.denoised) + light(two.denoised));
    inverse_light[i] = 1.0f / std::sqrt(y * y + kDarkest);
  }
  const std::vector<float> shown_of_one = errors_shown_by(two.halves, one.denoised, inverse_light, size),
                           shown_of_two = errors_shown_by(one.halves, two.denoised, inverse_light, size);
  Denoised result{std::vector<float>(size.values()), std::vector<float>(size.values() / 3)};
  for (size_t i = 0; i < result.error.size(); ++i) {
    const float e1 = one.denoised.error[i] + shown_of_one[i], e2 = two.denoised.error[i] + shown_of_two[i],
                sum = e1 + e2, w = sum > 0.0f ? e2 / sum : 0.5f;
    for (size_t c = 3 * i; c < 3 * i + 3; ++c)
      result.image[c] = w * one.denoised.image[c] + (1.0f - w) * two.denoised.image[c];
    result.error[i] = w * w * e1 + (1.0f - w) * (1.0f - w) * e2;
  }
  return result;
}

}  // namespace ajar
