// The comparison of pilot images. Another technique is chosen if it is better in most pixels, not if it is better in a
// few.
#include <gtest/gtest.h>

#include <cmath>

#include "choice/pilot_comparison.h"
#include "math/random.h"

namespace ajar::test_pilot_comparison {

namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr size_t kPixels = size_t(kWidth) * kHeight;

/// Images of the value 0.5 with noise of this standard deviation.
PilotImages noisy(float deviation, uint32_t seed) {
  PilotImages pilot;
  for (std::vector<float>* picture : {&pilot.first, &pilot.second}) {
    for (size_t i = 0; i < kPixels; ++i) {
      const float value = 0.5f + deviation * std::sqrt(12.0f) * (to_unit_float(seed = hash_combine(seed, 1u)) - 0.5f);
      picture->insert(picture->end(), {value, value, value, 1.0f});
    }
  }
  return pilot;
}
/// Adds a firefly to one pixel of the first image.
void add_firefly(PilotImages& pilot, size_t pixel, float brightness) {
  for (size_t c = 0; c < 3; ++c) pilot.first[4 * pixel + c] += brightness;
}

std::vector<PilotNoise> noises_of(const std::vector<const PilotImages*>& pilots) {
  const std::vector<float> light = max_light(pilots, kWidth, kHeight);
  std::vector<PilotNoise> noises;
  for (const PilotImages* pilot : pilots) noises.push_back(noise_of(*pilot, light));
  return noises;
}

TEST(PilotComparison, noise_is_the_variance_of_the_mean) {
  const PilotImages pilot = noisy(0.1f, 1);
  const PilotNoise noise = noises_of({&pilot})[0];
  const double expected = 0.5 * 0.1 * 0.1 / (0.25 + 0.01);  // of the mean of two images
  EXPECT_NEAR(noise.whole, expected, 0.1 * expected);
  EXPECT_LT(noise.typical, noise.whole);
  EXPECT_GT(noise.typical, 0.9 * noise.whole) << "no pixel is an outlier";
}

TEST(PilotComparison, an_advantage_in_three_pixels_is_ignored) {
  PilotImages path = noisy(0.1f, 1);
  for (const size_t pixel : {size_t(500), size_t(1500), size_t(2500)}) add_firefly(path, pixel, 50.0f);
  const PilotImages chains = noisy(0.1f, 2), photons = noisy(0.12f, 3);
  const std::vector<PilotNoise> noises = noises_of({&path, &chains, &photons});
  EXPECT_GT(noises[0].whole, 10.0 * noises[1].whole) << "over all pixels, path tracing is much noisier";
  EXPECT_GT(noises[0].whole, 10.0 * noises[2].whole);
  // The factors are the relative costs of the other techniques, which are applied before the comparison.
  EXPECT_EQ(clearly_best({noises[0],
                          {1.4 * noises[1].whole, 1.4 * noises[1].typical},
                          {2.5 * noises[2].whole, 2.5 * noises[2].typical}}),
            0u);
}

TEST(PilotComparison, an_advantage_in_all_pixels_counts) {
  const PilotImages path = noisy(0.3f, 1);
  PilotImages chains = noisy(0.1f, 2);
  const PilotImages photons = noisy(0.15f, 3);
  EXPECT_EQ(clearly_best(noises_of({&path, &chains, &photons})), 1u);
  EXPECT_EQ(clearly_best(noises_of({&path, &photons, &chains})), 2u);
  for (const size_t pixel : {size_t(500), size_t(1500)}) add_firefly(chains, pixel, 50.0f);
  EXPECT_EQ(clearly_best(noises_of({&path, &chains, &photons})), 2u) << "a technique with fireflies is not chosen";
}

TEST(PilotComparison, the_noise_of_a_bright_strip_does_not_count_on_dark_neighbours) {
  PilotImages pilot = noisy(0.05f, 4);
  for (std::vector<float>* picture : {&pilot.first, &pilot.second})
    for (size_t i = 0; i < picture->size(); ++i)
      if (i % 4 != 3) (*picture)[i] *= (i / 4) % kWidth < 4 ? 1000.0f : 0.1f;
  const std::vector<float> light = max_light({&pilot}, kWidth, kHeight);
  const PilotNoise noise = noise_of(pilot, light), left = denoised_noise_of(pilot, light, kWidth, kHeight);
  EXPECT_GT(left.whole, 0.0);
  EXPECT_LT(left.whole, 0.1 * noise.whole);  // a mean over 56 pixels
}

TEST(PilotComparison, light_that_arrives_in_single_pixels_only_is_not_free_of_noise) {
  // Each image has 20 bright pixels and is black otherwise: without these pixels, nothing is left that could differ.
  PilotImages fireflies = noisy(0.0f, 5);
  for (std::vector<float>* picture : {&fireflies.first, &fireflies.second})
    for (size_t i = 0; i < picture->size(); ++i)
      if (i % 4 != 3) (*picture)[i] = 0.0f;
  const size_t pixels = size_t(kWidth) * kHeight;
  for (size_t k = 0; k < 20; ++k) {
    add_firefly(fireflies, (k * 131 + 7) % pixels, 50.0f);
    std::swap(fireflies.first, fireflies.second);
  }
  const PilotImages calm = noisy(0.1f, 6);
  const std::vector<float> light = max_light({&fireflies, &calm}, kWidth, kHeight);
  const PilotNoise left = denoised_noise_of(fireflies, light, kWidth, kHeight),
                   left_calm = denoised_noise_of(calm, light, kWidth, kHeight);
  EXPECT_GT(left.whole, left_calm.whole);
  EXPECT_GT(left.typical, left_calm.typical);
  EXPECT_EQ(clearly_best({left, left_calm}), 1u);
}

TEST(PilotComparison, the_blur_uses_only_pixels_inside_the_image) {
  std::vector<float> image(4 * 9 * 10, 0.0f);
  image[4 * (1 * 9 + 2) + 1] = 20.0f;  // at (2, 1)
  const std::vector<float> result = blurred(image, 9, 10);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 9; ++x) {
      const int columns = std::min(8, x + 3) - std::max(0, x - 3) + 1,
                rows = std::min(9, y + 3) - std::max(0, y - 3) + 1;
      const float expected = x <= 5 && y <= 4 ? 20.0f / float(columns * rows) : 0.0f;
      for (int c = 0; c < 4; ++c)
        EXPECT_NEAR(result[size_t(4 * (y * 9 + x) + c)], c == 1 ? expected : 0.0f, 1e-6f) << x << ", " << y;
    }
}

TEST(PilotComparison, the_error_of_a_firefly_is_relative_to_its_own_value) {
  const PilotImages others = noisy(0.1f, 2);
  const auto noise_with = [&](float brightness) {
    PilotImages path = noisy(0.1f, 1);
    add_firefly(path, 1500, brightness);
    return noises_of({&path, &others})[0].whole;
  };
  EXPECT_LT(noise_with(1e6f), 1.1 * noise_with(1e4f)) << "the brightness of the firefly does not matter";
}

TEST(PilotComparison, a_technique_that_found_no_light_is_not_chosen) {
  const PilotImages path = noisy(0.3f, 1),
                    dark{std::vector<float>(4 * kPixels, 0.0f), std::vector<float>(4 * kPixels, 0.0f)};
  EXPECT_EQ(clearly_best(noises_of({&path, &dark})), 0u);
  EXPECT_EQ(clearly_best({{1.0, 1.0}}), 0u);
  EXPECT_EQ(clearly_best({{1.0, 1.0}, {0.7, 0.7}}), 0u) << "the advantage is too small";
}

TEST(PilotComparison, a_technique_with_a_few_bad_pixels_is_not_hopeless) {
  const PilotImages path = noisy(0.1f, 1), bad = noisy(0.3f, 2);
  PilotImages with_firefly = noisy(0.1f, 3);
  for (const size_t pixel : {size_t(500), size_t(1500), size_t(2500)}) add_firefly(with_firefly, pixel, 50.0f);
  const std::vector<PilotNoise> noises = noises_of({&path, &bad, &with_firefly});
  EXPECT_TRUE(is_hopeless(noises[1], noises[0], 1.25));
  EXPECT_FALSE(is_hopeless(noises[2], noises[0], 1.25));
  EXPECT_FALSE(is_hopeless(noises[0], noises[1], 1.25));
}

TEST(PilotComparison, light_that_is_not_found_counts_as_noise) {
  PilotImages path = noisy(0.1f, 1), chains = noisy(0.2f, 2);
  const auto unseen = [&](const PilotImages& pilot, const PilotImages& other) {
    return unseen_noise_of(pilot, other, max_light({&pilot, &other}, kWidth, kHeight), kWidth, kHeight);
  };
  EXPECT_LT(unseen(path, chains), 0.05 * noises_of({&path, &chains})[0].whole) << "the images differ by noise only";
  EXPECT_LT(unseen(chains, path), 0.05 * noises_of({&path, &chains})[1].whole);
  add_firefly(chains, 1500, 500.0f);
  EXPECT_LT(unseen(path, chains), 0.05 * noises_of({&path, &chains})[0].whole)
      << "light in a single image may be random";

  for (std::vector<float>* picture : {&path.first, &path.second})  // path tracing does not find the right half
    for (size_t i = 0; i < kPixels; ++i)
      if (int(i) % kWidth >= kWidth / 2)
        for (size_t c = 0; c < 3; ++c) (*picture)[4 * i + c] = 0.0f;
  chains = noisy(0.2f, 2);
  // None of 49 pixels found the value 0.5, so that one pixel in 49 may have 49 times this value.
  EXPECT_NEAR(unseen(path, chains), 49.0 * 0.5 * 0.25 / (0.25 + 0.01), 1.5);
  EXPECT_LT(unseen(chains, path), 0.05);
}

TEST(PilotComparison, bias_is_the_difference_beyond_the_noise) {
  const PilotImages unbiased = noisy(0.1f, 1);
  PilotImages other = noisy(0.1f, 2);
  const std::vector<float> light = max_light({&unbiased}, kWidth, kHeight);
  EXPECT_LT(bias_of(other, unbiased, light, kWidth, kHeight), 5e-4);
  for (std::vector<float>* picture : {&other.first, &other.second})
    for (float& value : *picture) value *= 0.8f;
  EXPECT_NEAR(bias_of(other, unbiased, light, kWidth, kHeight), 0.01 / (0.25 + 0.01), 4e-3);
}

}  // namespace

}  // namespace ajar::test_pilot_comparison
