// A denoised image that converges to the correct one: the third use of optimizing control variates.
//
// The thesis combines estimators by weights that are learned from their samples [Fan 2006, chapter 6]. Here one
// estimator is biased (the image D of a neural denoiser) and one is noisy (the rendered image N). The combination is
// D + sum over planes j of g_j * plane j of (N - D), with planes from fine to coarse (denoise/planes.h). All residuals
// are divided by the light of the pixel before, so that a coarse plane does not carry the error of a bright surface
// to a dark one. The weight g_j of a place is e^2 / (e^2 + noise), with the energy e^2 of D's error and that of N's noise.
//
// The render keeps the means A and B of two independent halves of its samples. D is the mean of D(A) and D(B), and with
// much noise a mean of this and D((A + B) / 2): then the bias of a denoiser falls with the noise of its input. With
// little noise, the mean of two is better, because it takes out a part of the denoiser's own noise. The residual B -
// D(A) of independent images has the energy e^2 plus the noise of B; (A - B)^2 has twice that noise. Their means over a
// window give both, without a model of the noise, so that the correlated noise of chains is treated correctly [James
// and Stein 1961]. With the standard error s of the estimate p of e^2, p (1 - (2.5 s / p)^2) is used, and 0 if p < 2.5
// s. Pixels whose halves differ far more than usual in the window count less, for g and in the sum. As the number of
// samples grows, the noise vanishes and g becomes 1 wherever D is wrong: the image is consistent. g_j is at least as
// large as the mean of g_{j-1} around: the coarse part of a detail has less noise than its fine part, without which it
// would have a dark ring.
//
// With the weights, each half alone gives an image G(A) = D(A) + sum of g_j * plane j of (A - D(A)), with 1 - g_j times
// the plane of D - (D(A) + D(B)) / 2 in both, and the result is (G(A) + G(B)) / 2. Its variance is |G(A) - G(B)|^2 / 4.
// The estimate of the squared error is twice as much: the bias that is left cannot be separated from the noise, and in
// test renders it is about as large (docs/research/denoising.md).
//
// A short render has no time for a run for each half. D is then D((A + B) / 2) alone, and D(A) and D(B) are D. Because D
// keeps a part of the noise of both halves, e^2 is estimated too small by twice the covariance of D and the noise: the
// weights are too small where N is nearly as good as D. This vanishes with the noise, so that the image is consistent
// as well. The halves do not tell the error of such an image. Two more runs of a small network do, because the error of
// an image from halves is about the same.
//
// Light that is found directly has another kind of noise than the rest: little noise, with edges of shadows. If the
// render separates it ("Direct Halves" of film.h), both parts are denoised and combined apart, and added. This takes
// twice the time, and the error is usually a tenth to a quarter smaller (docs/research/denoising.md).
//
// Where light is found rarely, a few pixels are bright in both halves by chance, and look like details. As many as
// independent halves have by chance do not count in the three finest planes.
//
// Several techniques can render one image. Each has its own halves and gives its own image
// (denoise/technique_images.h).
//
// Small bright details that the denoiser loses, such as sparks, have residuals of many times the denoised light, which
// coarse planes would spread as a halo. The planes do not contain them. They get the rendered light with a weight of
// their own (denoise/bright_pixels.h). Spots of a plane that can be bright in both halves by chance count as one value
// for the significance, not as many.
//
// Single pixels that are far brighter than all their neighbours, and bright in one half only, are darkened before the
// denoiser sees them, unless there are many of them around. They stay in N: coarse planes return their energy where it is
// significant.
#pragma once

#include <functional>
#include <vector>

#include "denoise/planes.h"
#include "denoise/technique_images.h"

namespace ajar {

/// Takes the noise out of a linear RGB image.
using DenoiseFunction = std::function<std::vector<float>(std::vector<float>)>;

/// The colors of an image with four channels.
std::vector<float> rgb_of(const std::vector<float>& rgba);

/// What is denoised. `halves`: the means of the even and of the odd samples of each pixel, six channels for each
/// technique. A pixel without two halves is NaN there, and the technique does not count; then, and if `halves` is
/// empty, `image` is denoised without a combination, and `error` is empty. `direct_halves`: the part of the halves by
/// direct paths; empty, or NaN anywhere: they are not separated. `biased`: of each technique; empty: none is.
struct NoisyImage {
  const std::vector<float>&image, &halves;  ///< image: RGB
  std::vector<float> direct_halves;
  int width, height;
  std::vector<bool> biased{};
  float exposure = 1.0f;  ///< light times this is displayed
};
/// What the denoiser sees.
enum class DenoiseRuns {
  HalvesAndWhole,  ///< both halves, and with much noise also the image, which takes half as long again
  Halves,          ///< both halves
  Whole            ///< the image
};
/// `estimator`: a fast denoiser, by which the error is estimated if the denoiser sees the image alone. Without it,
/// `error` is empty then; only the mean of several techniques needs errors, and the denoiser itself estimates them.
Denoised denoise(const NoisyImage& noisy, const DenoiseFunction& denoiser,
                 DenoiseRuns runs = DenoiseRuns::HalvesAndWhole, const DenoiseFunction& estimator = {});
/// The same without direct halves.
inline Denoised denoise(const std::vector<float>& image, const std::vector<float>& halves, int width, int height,
                        const DenoiseFunction& denoiser, DenoiseRuns runs = DenoiseRuns::HalvesAndWhole) {
  return denoise({image, halves, {}, width, height}, denoiser, runs);
}

/// For each technique of the halves, the estimated relMSE of its denoised image. Empty if a pixel of one technique has no
/// two halves.
std::vector<double> technique_errors(const NoisyImage& noisy, const DenoiseFunction& denoiser);

/// The image, RGB, in which single pixels are darkened that are bright here and not in `other`.
std::vector<float> limited(const std::vector<float>& image, const std::vector<float>& other, int width, int height);
/// Number of planes for an image of this size. The step of the coarsest is an eighth of the smaller side at most.
int plane_count(int width, int height);

}  // namespace ajar
