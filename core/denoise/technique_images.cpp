#include "denoise/technique_images.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

constexpr int kReach = 3;           // pixels to each side of the window in which N - D is averaged
constexpr int kWideReach = 8;       // pixels to each side of the window of its energy
constexpr float kMinEnergy = 2.0f;  // times the noise
constexpr float kLeastError = 1e-12f;

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

std::vector<std::vector<float>> errors_of(const std::vector<TechniqueImage>& images, ImageSize size) {
  std::vector<float> inverse_light(size.values() / 3);
  for (size_t i = 0; i < inverse_light.size(); ++i) {
    float y = 0.0f;
    for (const TechniqueImage& one : images) y += luminance_at(one.denoised.image, i) / float(images.size());
    inverse_light[i] = 1.0f / std::sqrt(y * y + kDarkestSquared);
  }
  std::vector<std::vector<float>> errors;
  for (size_t k = 0; k < images.size(); ++k) {
    std::vector<float> shown(inverse_light.size());
    for (size_t j = 0; j < images.size(); ++j) {
      if (j == k) continue;
      const std::vector<float> by_one = errors_shown_by(images[j].halves, images[k].denoised, inverse_light, size);
      for (size_t i = 0; i < shown.size(); ++i) shown[i] = std::max(shown[i], by_one[i]);
    }
    for (size_t i = 0; i < shown.size(); ++i) shown[i] += images[k].denoised.error[i];
    errors.push_back(std::move(shown));
  }
  return errors;
}

Denoised mean_of(const std::vector<TechniqueImage>& images, ImageSize size) {
  const std::vector<std::vector<float>> errors = errors_of(images, size);
  Denoised result{std::vector<float>(size.values()), std::vector<float>(size.values() / 3)};
  for (size_t i = 0; i < result.error.size(); ++i) {
    float sum = 0.0f;
    for (const std::vector<float>& e : errors) sum += 1.0f / std::max(e[i], kLeastError);
    for (size_t k = 0; k < images.size(); ++k) {
      const float w = 1.0f / (std::max(errors[k][i], kLeastError) * sum);
      for (size_t c = 3 * i; c < 3 * i + 3; ++c) result.image[c] += w * images[k].denoised.image[c];
      result.error[i] += w * w * errors[k][i];
    }
  }
  return result;
}

}  // namespace ajar
