// Compares small images by several techniques: how noisy they are, and whether one is clearly better than the first.
//
// Each technique gives two independent images; their difference gives its variance. The variance is relative to the
// maximum light that any technique has found around the pixel: a firefly that only one technique has found must not be
// compared with the darkness that the others have there. It is summed twice, over all pixels and without the worst few,
// because an advantage in a few pixels only can be accidental.
#pragma once

#include <cstddef>
#include <vector>

namespace ajar {

/// Two independent images by one technique, RGBA.
struct PilotImages {
  std::vector<float> first, second;
};

/// Means over windows of a few pixels.
std::vector<float> blurred(std::vector<float> image, int width, int height);
/// The mean of both.
std::vector<float> mean_of(const PilotImages& pilot);
/// The maximum of the blurred means of all techniques, for each pixel.
std::vector<float> max_light(const std::vector<const PilotImages*>& pilots, int width, int height);

/// relMSE, or a prediction of it.
struct PilotNoise {
  double whole = 0.0;
  double typical = 0.0;  ///< without the worst thousandth of the pixels
};
/// Noise of the mean of both images, relative to `light`.
PilotNoise noise_of(const PilotImages& pilot, const std::vector<float>& light);
/// About the noise that a denoiser leaves: that of means over small windows. A denoiser removes single bright pixels; but
/// where most light arrives in such pixels, it cannot do without them. The result is the geometric mean of the noises
/// with and without them.
PilotNoise denoised_noise_of(const PilotImages& pilot, const std::vector<float>& light, int width, int height);
/// relMSE that is not noise: the difference of the blurred image to that of an unbiased technique, beyond the noise of
/// both.
double bias_of(const PilotImages& pilot, const PilotImages& unbiased, const std::vector<float>& light, int width,
               int height);

/// relMSE of the mean that the difference of both images cannot show: of light that `other` has found in both of its
/// images, and `pilot` in neither. If the n pixels around a pixel are too dark by e, fewer than one in n of their
/// samples found that light, and the variance of each pixel is at least n e^2. 0 if the techniques differ only by
/// noise.
constexpr double kUnseenPixels = 49.0;  ///< n
double unseen_noise_of(const PilotImages& pilot, const PilotImages& other, const std::vector<float>& light, int width,
                       int height);

/// The factor by which another technique must be better than the first. The first is stratified, and a small image
/// shows this advantage least.
constexpr double kClearlyBetter = 1.6;
/// Index of the best technique: the first, unless others are clearly better, also without the worst pixels. Of these,
/// it is the best one by both sums.
size_t clearly_best(const std::vector<PilotNoise>& techniques);
/// Whether a technique has more than `factor` times the noise of the first, by both sums, so that similar ones need not be
/// tried.
bool is_hopeless(const PilotNoise& technique, const PilotNoise& first, double factor);

}  // namespace ajar
