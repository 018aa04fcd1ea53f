#include "denoise/technique_images.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

constexpr int kReaches[] = {0, 3};  // pixels to each side of the windows in which N - D is averaged
constexpr int kWideReach = 8;       // pixels to each side of the window of its energy
constexpr float kMinEnergy = 2.0f;  // times the noise
constexpr float kLeastError = 1e-12f;

/// A rendered image N and the denoised image D of another technique.
struct Residual {
  std::vector<float> difference, noise;  ///< N - D, and a number with the variance of N

  Residual(const Halves& n, const std::vector<float>& d) : difference(d.size()), noise(d.size()) {
    for (size_t i = 0; i < d.size(); ++i) {
      difference[i] = 0.5f * (n.a[i] + n.b[i]) - d[i];
      noise[i] = 0.5f * (n.a[i] - n.b[i]);
    }
  }
};

/// The mean over a square of each pixel, relative to the light of the pixel. (The mean of relative differences would
/// be positive where a pattern is blurred, because its dark pixels would count more.)
std::vector<float> relative_mean(std::vector<float> image, int reach, const std::vector<float>& inverse_light,
                                 ImageSize size, std::vector<float>& scratch) {
  square_mean(image, size, reach, scratch);
  for (size_t i = 0; i < image.size(); ++i) image[i] *= inverse_light[i / 3];
  return image;
}

/// Adds the energy of `mean` that is above the noise to the errors, where it is more than they are.
void raise_errors(std::vector<float>& errors, const std::vector<float>& mean, const std::vector<float>& noise,
                  ImageSize size, std::vector<float>& scratch) {
  std::vector<float> energies(2 * errors.size());
  for (size_t i = 0; i < mean.size(); ++i) {
    energies[2 * (i / 3)] += mean[i] * mean[i] / 3.0f;
    energies[2 * (i / 3) + 1] += noise[i] * noise[i] / 3.0f;
  }
  square_mean(energies, {size.width, size.height, 2}, kWideReach, scratch);
  for (size_t i = 0; i < errors.size(); ++i)
    errors[i] = std::max(errors[i], energies[2 * i] - kMinEnergy * energies[2 * i + 1]);
}

/// Errors of `denoised`, relative as its own estimate, that the rendered image of the other technique shows.
std::vector<float> errors_shown_by(const TechniqueImage& other, const Denoised& denoised,
                                   const std::vector<float>& inverse_light, ImageSize size) {
  const Residual found(other.halves, denoised.image);
  std::vector<float> errors(inverse_light.size()), scratch;
  const auto mean = [&](const std::vector<float>& image, int reach) {
    return relative_mean(image, reach, inverse_light, size, scratch);
  };
  std::vector<float> wide = mean(found.difference, kWideReach);
  if (other.is_biased) {
    for (float& missing : wide) missing = std::max(0.0f, missing);
    raise_errors(errors, wide, mean(found.noise, kWideReach), size, scratch);
    return errors;
  }
  for (const int reach : kReaches) {
    std::vector<float> difference = mean(found.difference, reach);
    for (size_t i = 0; i < wide.size(); ++i) difference[i] -= std::min(0.0f, wide[i]);
    raise_errors(errors, difference, mean(found.noise, reach), size, scratch);
  }
  return errors;
}

}  // namespace

std::vector<std::vector<float>> errors_of(const std::vector<TechniqueImage>& images, ImageSize size, float dark) {
  std::vector<float> inverse_light(size.values() / 3);
  for (size_t i = 0; i < inverse_light.size(); ++i) {
    float y = 0.0f;
    for (const TechniqueImage& one : images) y += luminance_at(one.denoised.image, i) / float(images.size());
    inverse_light[i] = 1.0f / std::sqrt(y * y + dark);
  }
  std::vector<std::vector<float>> errors;
  for (size_t k = 0; k < images.size(); ++k) {
    std::vector<float> shown(inverse_light.size());
    for (size_t j = 0; j < images.size(); ++j) {
      if (j == k) continue;
      const std::vector<float> by_one = errors_shown_by(images[j], images[k].denoised, inverse_light, size);
      for (size_t i = 0; i < shown.size(); ++i) shown[i] = std::max(shown[i], by_one[i]);
    }
    for (size_t i = 0; i < shown.size(); ++i) shown[i] += images[k].denoised.error[i];
    errors.push_back(std::move(shown));
  }
  return errors;
}

Denoised mean_of(const std::vector<TechniqueImage>& images, ImageSize size, float dark) {
  const std::vector<std::vector<float>> errors = errors_of(images, size, dark);
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
