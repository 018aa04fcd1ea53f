// The denoised image of a render by several techniques (choice/mixture.h), from the denoised image of each.
//
// What is left of the noise, and what a denoiser makes of it, is independent in the images, so that their mean is better
// than each of them. It is weighted by the inverse of the estimated errors around a pixel: where one technique has left
// a false spot, the others count. [Fan 2006, chapter 6: the best combination of what several samplers have found]
//
// The estimate from two halves of one technique does not see light that neither half has found, or that the denoiser has
// taken for noise. The rendered image N of another technique shows it: the mean of N - D over a small window has the
// energy of the error of D plus the noise of N, which follows from the halves of N. What is above twice this noise is
// added to the error of D, for the N that shows most. An N that is darker than D in a wide window says nothing: its own
// technique may not have found that light, which its halves would not show.
//
// Windows of a pixel show what D has blurred; a mean over more pixels shows missing light of which little is found. The N
// of a biased technique is blurred itself, and only shows light that is missing in a wide window.
#pragma once

#include <vector>

#include "denoise/planes.h"
#include "math/types.h"

namespace ajar {

/// Of a pixel of an RGB image.
inline float luminance_at(const std::vector<float>& image, size_t pixel) {
  return luminance(Color(image[3 * pixel], image[3 * pixel + 1], image[3 * pixel + 2]));
}

struct Denoised {
  std::vector<float> image;  ///< RGB
  /// Of each pixel: estimate of the relMSE, squared error / (squared light + 0.01) as displayed, mean over a window.
  std::vector<float> error;
};

/// Two independent images of the same light, RGB.
struct Halves {
  std::vector<float> a, b;
};

/// The denoised image by one technique, and the halves that it is made from.
struct TechniqueImage {
  Denoised denoised;
  Halves halves;
  bool is_biased = false;  ///< the mean of its rendered images is not the correct image
};
/// Estimates of the relMSE of each pixel, for each image. `dark`: what is added to squares of light (dark_squared).
std::vector<std::vector<float>> errors_of(const std::vector<TechniqueImage>& images, ImageSize size, float dark);
Denoised mean_of(const std::vector<TechniqueImage>& images, ImageSize size, float dark);

}  // namespace ajar
