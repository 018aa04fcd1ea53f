// How noisy small pictures by several techniques are, and whether one is clearly better than the first.
//
// Each technique gives two independent pictures; their difference tells its variance. It is put in relation to the most
// light that any technique has found around the pixel: a firefly that one technique alone has met must not be measured
// against the darkness that the others left there. And it is summed twice, over all pixels and without the worst few:
// an advantage that rests on a few pixels is probability.
#pragma once

#include <cstddef>
#include <vector>

namespace ajar {

/// Two independent pictures by one technique, RGBA.
struct PilotImages {
  std::vector<float> first, second;
};

/// Means over windows of a few pixels.
std::vector<float> blurred(const std::vector<float>& image, int width, int height);
/// The mean of both.
std::vector<float> mean_of(const PilotImages& pilot);
/// At each pixel, the brightest of all techniques' blurred means.
std::vector<float> max_light(const std::vector<const PilotImages*>& pilots, int width, int height);

/// relMSE, or what is foretold from it.
struct PilotNoise {
  double whole = 0.0;
  double typical = 0.0;  ///< without the worst thousandth of the pixels
};
/// Of the mean of both pictures, relative to `light`.
PilotNoise noise_of(const PilotImages& pilot, const std::vector<float>& light);
/// relMSE that is no noise: how far the blurred picture is from an unbiased technique's, beyond the noise of both.
double bias_of(const PilotImages& pilot, const PilotImages& unbiased, const std::vector<float>& light, int width,
               int height);

/// relMSE of the mean that the difference of both pictures cannot show: of light that `other` has found in both of its
/// own, and `pilot` in neither. Where the n pixels around one are too dark by e, fewer than one in n of their samples
/// met that light, and each pixel's variance is n e^2 or more. Nothing where the techniques only differ by noise.
double unseen_noise_of(const PilotImages& pilot, const PilotImages& other, const std::vector<float>& light, int width,
                       int height);

/// Another technique must be this much better than the first, whose stratification a small picture shows least.
constexpr double kClearlyBetter = 1.6;
/// The first unless others are clearly better, and better without the worst pixels as well: of those the one that is
/// best by both.
size_t clearly_best(const std::vector<PilotNoise>& techniques);
/// Whether a technique is so much worse than the first, by both sums, that others like it need not be tried.
bool is_hopeless(const PilotNoise& technique, const PilotNoise& first);

}  // namespace ajar
