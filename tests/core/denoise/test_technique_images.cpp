// Tests of the denoised image of a render by several techniques.
#include "denoise/technique_images.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "denoise/noisy_images.h"

namespace ajar::test_denoise {

namespace {

/// Both, side by side, as the pass of two techniques.
std::vector<float> side_by_side(const std::vector<float>& one, const std::vector<float>& two) {
  std::vector<float> both;
  for (size_t i = 0; i < one.size(); i += 6) {
    both.insert(both.end(), one.begin() + std::ptrdiff_t(i), one.begin() + std::ptrdiff_t(i + 6));
    both.insert(both.end(), two.begin() + std::ptrdiff_t(i), two.begin() + std::ptrdiff_t(i + 6));
  }
  return both;
}

template <int kReach>
std::vector<float> blur(const std::vector<float>& image) {
  std::vector<float> result = image, scratch;
  window_mean(result, {kWidth, kHeight, 3}, kReach, scratch);
  return result;
}
constexpr auto* small_blur = &blur<1>;
constexpr auto* large_blur = &blur<3>;

TEST(TechniqueImages, two_techniques_are_better_than_each_of_them) {
  const std::vector<float> clean(kValues, 0.5f);
  double alone = 0.0, both = 0.0, estimated = 0.0;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const Rendered one = rendered(clean, 16, seed), two = rendered(clean, 16, 50 + seed);
    const Denoised mean = denoise(one.image, side_by_side(one.halves, two.halves), kWidth, kHeight, small_blur);
    both += relative_error(mean.image, clean);
    for (const float e : mean.error) estimated += double(e) / double(mean.error.size());
    for (const Rendered* r : {&one, &two})
      alone += 0.5 * relative_error(denoise(r->image, r->halves, kWidth, kHeight, small_blur).image, clean);
  }
  EXPECT_LT(both, 0.6 * alone) << "half of the variance";
  EXPECT_GT(estimated, 0.3 * both);
  EXPECT_LT(estimated, 3.0 * both);
}

TEST(TechniqueImages, a_spot_that_one_technique_has_left_does_not_count) {
  const std::vector<float> clean(kValues, 0.5f);
  Rendered one = rendered(clean, 16, 1);
  const Rendered two = rendered(clean, 16, 2);
  for (int y = 28; y < 34; ++y)
    for (int x = 40; x < 46; ++x)
      for (size_t c = 0; c < 3; ++c) one.halves[6 * (size_t(y) * kWidth + size_t(x)) + c] += 8.0f;  // in one half
  const auto error = [&](const std::vector<float>& halves) {
    return relative_error(denoise(one.image, halves, kWidth, kHeight, dark_blur).image, clean);
  };
  const double spotted = error(one.halves), mean = error(side_by_side(one.halves, two.halves));
  EXPECT_GT(spotted, 0.02);
  EXPECT_LT(mean, 0.1 * spotted) << "a mean with equal weights has a quarter";
}

TEST(TechniqueImages, light_that_one_technique_has_missed_is_that_of_the_other) {
  // Three tenths of the light of the left part arrive in the first by rare bright samples, which the denoiser loses. Its
  // halves agree without them.
  const std::vector<float> clean(kValues, 0.5f);
  Rendered one = rendered(clean, 256, 3);
  const Rendered two = rendered(clean, 64, 4);
  constexpr float kRare = 1e-3f;
  Pcg32 rng(9);
  for (size_t i = 0; i < kValues / 3; ++i)
    if (i % kWidth < 40)
      for (size_t half = 6 * i; half < 6 * i + 6; half += 3) {
        const float bright = rng.next_float() < kRare ? 0.15f / kRare : 0.0f;
        for (size_t c = half; c < half + 3; ++c) one.halves[c] = 0.7f * one.halves[c] + bright;
      }
  const auto left_of = [&](const std::vector<float>& halves) {
    const std::vector<float> image = denoise(one.image, halves, kWidth, kHeight, small_blur).image;
    double left = 0.0;
    for (size_t i = 0; i < kValues / 3; ++i)
      if (i % kWidth < 30) left += double(image[3 * i]) / (30.0 * kHeight);
    return left;
  };
  EXPECT_LT(left_of(one.halves), 0.47);
  EXPECT_NEAR(left_of(side_by_side(one.halves, two.halves)), 0.5, 0.015);
}

/// A pattern of squares of two pixels, whose mean over a larger window is 0.5.
std::vector<float> pattern() {
  std::vector<float> image(kValues);
  for (size_t i = 0; i < kValues / 3; ++i)
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) image[c] = (i % kWidth / 2 + i / kWidth / 2) % 2 ? 0.9f : 0.1f;
  return image;
}

TEST(TechniqueImages, a_pattern_that_one_technique_has_blurred_is_that_of_the_other) {
  const std::vector<float> clean = pattern();
  const Rendered noisy = rendered(clean, 1, 1), sharp = rendered(clean, 256, 2);
  const auto error = [&](const std::vector<float>& halves) {
    return relative_error(denoise(noisy.image, halves, kWidth, kHeight, large_blur).image, clean);
  };
  EXPECT_GT(error(noisy.halves), 0.1);
  EXPECT_LT(error(side_by_side(noisy.halves, sharp.halves)), 2.0 * error(sharp.halves));
}

TEST(TechniqueImages, a_biased_technique_shows_no_errors_by_its_blur) {
  const std::vector<float> clean = pattern();
  const Rendered right = rendered(clean, 256, 1), blurred = rendered(large_blur(clean), 4096, 2);
  const std::vector<float> halves = side_by_side(right.halves, blurred.halves);
  const auto errors = [&](bool is_biased) {
    return technique_errors({right.image, halves, {}, kWidth, kHeight, {false, is_biased}}, small_blur);
  };
  EXPECT_GT(errors(false)[0], 0.1) << "it is taken for correct";
  EXPECT_LT(errors(true)[0], 0.01);
  EXPECT_GT(errors(true)[1], 0.1) << "the correct image shows the blur";
}

TEST(TechniqueImages, two_techniques_converge) {
  const std::vector<float> clean = truth();
  for (const DenoiseRuns runs : {DenoiseRuns::HalvesAndWhole, DenoiseRuns::Whole}) {
    double before = 1e9;
    for (const int samples : {16, 256, 4096}) {
      const Rendered one = rendered(clean, samples, 5), two = rendered(clean, 4 * samples, 6);
      const Denoised both = denoise(one.image, side_by_side(one.halves, two.halves), kWidth, kHeight, dark_blur, runs);
      const double error = relative_error(both.image, clean);
      EXPECT_LT(error, before) << samples;
      EXPECT_LT(error, 1.02 * relative_error(one.image, clean)) << samples;
      EXPECT_EQ(both.error.size(), kValues / 3);
      before = error;
    }
  }
}

TEST(TechniqueImages, a_technique_without_halves_does_not_count) {
  const std::vector<float> clean = truth();
  const Rendered one = rendered(clean, 16, 5);
  const std::vector<float> unknown(2 * kValues, std::nanf(""));
  EXPECT_EQ(denoise(one.image, side_by_side(one.halves, unknown), kWidth, kHeight, dark_blur).image,
            denoise(one.image, one.halves, kWidth, kHeight, dark_blur).image);
}

}  // namespace

}  // namespace ajar::test_denoise
