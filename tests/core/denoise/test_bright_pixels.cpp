// Details and rare light are told apart by the places of bright pixels in two halves.
#include "denoise/bright_pixels.h"

#include <gtest/gtest.h>

#include "math/random.h"

namespace ajar {
namespace {

constexpr int kWidth = 128, kHeight = 128;
constexpr size_t kPixels = size_t(kWidth) * kHeight;
constexpr ImageSize kSize{kWidth, kHeight, 3};

/// Halves in which each pixel is bright with the probability of `chance(x, y)`, and the bright pixels of both.
template <class Chance>
Halves halves_with(const Chance& chance, uint64_t seed, size_t& bright) {
  Pcg32 rng(seed);
  Halves halves{std::vector<float>(3 * kPixels, 0.1f), std::vector<float>(3 * kPixels, 0.1f)};
  for (std::vector<float>* half : {&halves.a, &halves.b})
    for (size_t i = 0; i < kPixels; ++i) {
      if (rng.next_float() >= chance(int(i) % kWidth, int(i) / kWidth)) continue;
      const float light = 1.0f + 20.0f * rng.next_float();
      for (size_t c = 0; c < 3; ++c) (*half)[3 * i + c] = light;
      ++bright;
    }
  return halves;
}

/// The share of the bright pixels that are found to belong to details.
template <class Chance>
double share_of_details(const Chance& chance, uint64_t seed) {
  size_t bright = 0, found = 0;
  const Halves halves = halves_with(chance, seed, bright);
  const std::vector<float> dark(3 * kPixels, 0.1f);
  const BrightPixels result = bright_pixels_of(halves, dark, dark, kSize);
  for (size_t i = 0; i < kPixels; ++i)
    if (result.detail[i] > 0.0f) found += size_t(halves.a[3 * i] > 0.5f) + size_t(halves.b[3 * i] > 0.5f);
  return double(found) / double(bright);
}

TEST(BrightPixels, rare_light_is_no_detail) {
  for (const float density : {0.002f, 0.01f, 0.05f, 0.2f})
    for (uint64_t seed = 1; seed <= 3; ++seed)
      EXPECT_LT(share_of_details([&](int, int) { return density; }, seed), 0.15) << density << " seed " << seed;
}

TEST(BrightPixels, the_edge_of_an_area_of_rare_light_is_no_detail) {
  for (uint64_t seed = 1; seed <= 3; ++seed)
    EXPECT_LT(share_of_details([](int x, int) { return x < kWidth / 2 ? 0.05f : 0.0f; }, seed), 0.15) << seed;
}

TEST(BrightPixels, sparks_are_details_also_among_rare_light) {
  for (const float rare : {0.0f, 0.002f})
    for (uint64_t seed = 1; seed <= 3; ++seed)
      EXPECT_GT(
          share_of_details(
              [&](int x, int y) { return x % 32 > 12 && x % 32 < 20 && y % 32 > 14 && y % 32 < 18 ? 0.4f : rare; },
              seed),
          0.8)
          << rare << " seed " << seed;
}

TEST(BrightPixels, details_that_both_halves_show_are_kept_and_single_coincidences_are_not) {
  const std::vector<float> dark(3 * kPixels, 0.1f);
  Halves halves{dark, dark};
  const auto set = [&](int x, int y, float a, float b) {
    for (size_t c = 0; c < 3; ++c) {
      halves.a[3 * (size_t(y) * kWidth + size_t(x)) + c] = a;
      halves.b[3 * (size_t(y) * kWidth + size_t(x)) + c] = b;
    }
  };
  for (int x = 30; x < 36; ++x) set(x, 30, 20.0f, 19.0f);
  set(90, 90, 20.0f, 10.0f);
  const BrightPixels result = bright_pixels_of(halves, dark, dark, kSize);
  EXPECT_GT(result.detail_weight[30 * kWidth + 32], 0.99f);
  EXPECT_LT(result.detail_weight[90 * kWidth + 90], 0.01f);
  EXPECT_EQ(result.detail_weight[30 * kWidth + 20], 0.0f);
}

TEST(BrightPixels, a_pixel_that_both_halves_show_is_a_detail_also_among_rare_light) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    size_t bright = 0;
    Halves halves = halves_with([](int, int) { return 0.05f; }, seed, bright);
    constexpr size_t kPlace = 64 * kWidth + 64;
    for (size_t c = 3 * kPlace; c < 3 * kPlace + 3; ++c) halves.a[c] = 200.0f, halves.b[c] = 190.0f;
    const std::vector<float> dark(3 * kPixels, 0.1f);
    const BrightPixels result = bright_pixels_of(halves, dark, dark, kSize);
    EXPECT_EQ(result.detail[kPlace], 1.0f) << seed;
    EXPECT_GT(result.detail_weight[kPlace], 0.9f) << seed;
  }
}

}  // namespace
}  // namespace ajar
