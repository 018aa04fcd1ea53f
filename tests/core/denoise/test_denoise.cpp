// Tests of the combination of a denoised image with the halves of the rendered one. The denoisers are simple functions,
// so that their bias is known.
#include "denoise/denoise.h"

#include <gtest/gtest.h>

#include "denoise/noisy_images.h"
#include "math/random.h"
#include "math/statistics.h"

namespace ajar::test_denoise {

namespace {

double sum_of(const std::vector<float>& image) {
  CompensatedSum sum;
  for (const float v : image) sum.add(double(v));
  return sum.value();
}

TEST(Denoise, smooth_images_are_means_and_keep_constants) {
  const ImageSize size{7, 5, 2};
  const std::vector<float> constant(size.values(), 3.0f);
  std::vector<float> result, scratch;
  for (const int step : {1, 2, 16}) {
    smooth(constant, size, step, result);
    for (const float v : result) EXPECT_NEAR(v, 3.0f, 1e-6f);
  }
  for (const int reach : {0, 1, 30}) {
    result = constant;
    window_mean(result, size, reach, scratch);
    for (const float v : result) EXPECT_NEAR(v, 3.0f, 1e-5f);
  }
  std::vector<float> mean(kValues, 0.0f);
  mean[3 * (30 * kWidth + 40)] = 1.0f;
  window_mean(mean, {kWidth, kHeight, 3}, 2, scratch);
  EXPECT_NEAR(mean[3 * (30 * kWidth + 40)], 1.0f / 25.0f, 1e-6f);
  EXPECT_NEAR(mean[3 * (30 * kWidth + 44)], 1.0f / 125.0f, 1e-6f);
  EXPECT_EQ(mean[3 * (30 * kWidth + 45)], 0.0f);
  double squares = 0.0;
  for (const float v : mean) squares += double(v) * double(v);
  EXPECT_NEAR(1.0 / squares, window_count(2), 0.1 * window_count(2));
}

TEST(Denoise, the_result_converges_although_the_denoiser_is_wrong) {
  const std::vector<float> clean = truth();
  const double bias = relative_error(dark_blur(clean), clean);
  EXPECT_GT(bias, 0.01);
  double before[2] = {1e9, 1e9};
  for (const int samples : {16, 256, 4096, 65536 * 16}) {
    const int drawn = std::min(samples, 4096);
    Rendered r = rendered(clean, drawn, 7);
    if (drawn < samples)  // the same noise, scaled
      for (size_t i = 0; i < kValues; ++i) {
        const float scale = std::sqrt(float(drawn) / float(samples));
        for (size_t half = 0; half < 2; ++half) {
          float& v = r.halves[6 * (i / 3) + 3 * half + i % 3];
          v = clean[i] + scale * (v - clean[i]);
        }
        r.image[i] = clean[i] + scale * (r.image[i] - clean[i]);
      }
    const double noisy = relative_error(r.image, clean);
    for (const DenoiseRuns runs : {DenoiseRuns::HalvesAndWhole, DenoiseRuns::Whole}) {
      const double error = relative_error(denoise(r.image, r.halves, kWidth, kHeight, dark_blur, runs).image, clean);
      double& last = before[runs == DenoiseRuns::Whole];
      EXPECT_LT(error, last) << samples << " samples, " << int(runs);
      EXPECT_LT(error, 1.02 * noisy + 1e-9) << samples << " samples, " << int(runs);
      last = error;
    }
  }
  for (const double last : before) EXPECT_LT(last, 1e-3 * bias);
}

TEST(Denoise, the_estimated_error_is_that_of_the_image_or_twice_as_large) {
  // The blur leaves noise, and a bias at the border of the disc. The identity leaves all noise. The one bright pixel is
  // taken out: the blur spreads it, and its error cannot be seen in the noise of few samples.
  std::vector<float> clean = truth();
  for (float& v : clean) v = std::min(v, 3.0f);
  const auto blur = [](const std::vector<float>& image) {
    std::vector<float> result = image, scratch;
    window_mean(result, {kWidth, kHeight, 3}, 1, scratch);
    return result;
  };
  const auto identity = [](const std::vector<float>& image) { return image; };
  for (const DenoiseFunction& denoiser : {DenoiseFunction(blur), DenoiseFunction(identity)})
    for (const int samples : {16, 1024}) {
      RunningMoments ratio;
      for (uint64_t seed = 1; seed <= 5; ++seed) {
        const Rendered r = rendered(clean, samples, seed);
        const Denoised result = denoise(r.image, r.halves, kWidth, kHeight, denoiser);
        ratio.add(sum_of(result.error) / double(result.error.size()) / relative_error(result.image, clean));
      }
      EXPECT_GT(ratio.mean(), 0.8) << samples;
      EXPECT_LT(ratio.mean(), 2.2) << samples;
    }
}

TEST(Denoise, a_good_denoiser_is_not_made_noisy) {
  const std::vector<float> clean = truth();
  const auto perfect = [&](const std::vector<float>&) { return clean; };
  RunningMoments ratio;
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Rendered r = rendered(clean, 4, seed);
    ratio.add(relative_error(denoise(r.image, r.halves, kWidth, kHeight, perfect).image, clean) /
              relative_error(r.image, clean));
  }
  EXPECT_LT(ratio.mean(), 0.01);
}

TEST(Denoise, light_that_the_denoiser_takes_away_returns) {
  const std::vector<float> clean = truth();
  const Rendered r = rendered(clean, 64, 3);
  EXPECT_NEAR(sum_of(dark_blur(r.image)) / sum_of(clean), 0.9, 0.02);
  for (const DenoiseRuns runs : {DenoiseRuns::HalvesAndWhole, DenoiseRuns::Whole})
    EXPECT_NEAR(sum_of(denoise(r.image, r.halves, kWidth, kHeight, dark_blur, runs).image) / sum_of(r.image), 1.0,
                0.005);
}

TEST(Denoise, one_run_on_the_whole_image_has_an_error_only_with_an_estimator) {
  const std::vector<float> clean = truth();
  const Rendered r = rendered(clean, 16, 3);
  const NoisyImage noisy{r.image, r.halves, {}, kWidth, kHeight};
  int calls = 0;
  const auto estimator = [&](const std::vector<float>& image) {
    ++calls;
    return dark_blur(image);
  };
  const auto identity = [](const std::vector<float>& image) { return image; };
  const Denoised plain = denoise(noisy, identity, DenoiseRuns::Whole),
                 estimated = denoise(noisy, identity, DenoiseRuns::Whole, estimator);
  EXPECT_EQ(calls, 2);
  EXPECT_TRUE(plain.error.empty());
  EXPECT_EQ(plain.image, estimated.image);
  EXPECT_EQ(estimated.error, denoise(noisy, dark_blur, DenoiseRuns::Halves).error);
}

TEST(Denoise, the_error_of_a_bright_surface_does_not_reach_a_dark_one) {
  // A dark half beside a bright one, of which the denoiser takes a tenth of the light.
  std::vector<float> clean(kValues);
  for (size_t i = 0; i < kValues; ++i) clean[i] = (i / 3) % kWidth < kWidth / 2 ? 0.05f : 50.0f;
  const auto dims_bright = [&](const std::vector<float>&) {
    std::vector<float> image = clean;
    for (float& v : image) v *= v > 1.0f ? 0.9f : 1.0f;
    return image;
  };
  const Rendered r = rendered(clean, 16, 11);
  const std::vector<float> result = denoise(r.image, r.halves, kWidth, kHeight, dims_bright).image;
  double dark = 0.0, bright = 0.0;
  for (size_t i = 0; i < kValues; ++i) (clean[i] < 1.0f ? dark : bright) += std::abs(result[i] / clean[i] - 1.0f);
  EXPECT_LT(dark / (kValues / 2), 0.02);
  EXPECT_LT(bright / (kValues / 2), 0.05);
}

TEST(Denoise, only_pixels_that_are_bright_in_one_half_are_darkened) {
  std::vector<float> one(kValues, 0.5f), two = one;
  for (size_t c = 0; c < 3; ++c) {
    one[3 * 700 + c] = 100.0f;                       // a firefly
    one[3 * 2000 + c] = two[3 * 2000 + c] = 100.0f;  // a highlight
  }
  const std::vector<float> result = limited(one, two, kWidth, kHeight);
  EXPECT_NEAR(result[3 * 700], 1.5f, 1e-5f);
  EXPECT_EQ(result[3 * 2000], 100.0f);
  EXPECT_EQ(result[3 * 300], 0.5f);
}

TEST(Denoise, a_firefly_of_one_half_is_not_restored) {
  const std::vector<float> clean = truth();
  Rendered r = rendered(clean, 64, 5);
  const size_t pixel = 50 * kWidth + 10;
  for (size_t c = 0; c < 3; ++c) {
    r.halves[6 * pixel + c] += 1000.0f;
    r.image[3 * pixel + c] += 500.0f;
  }
  const auto identity = [](const std::vector<float>& image) { return image; };
  EXPECT_LT(denoise(r.image, r.halves, kWidth, kHeight, identity).image[3 * pixel], 5.0f);
}

TEST(Denoise, noisy_images_are_denoised_as_a_whole_as_well) {
  // The denoiser knows the image, but adds a fine pattern in proportion to the noise of its input.
  const std::vector<float> clean = truth();
  int calls = 0;
  const auto adds_pattern = [&](const std::vector<float>& noisy) {
    ++calls;
    const float noise = float(relative_error(noisy, clean));
    std::vector<float> result = clean;
    for (size_t i = 0; i < kValues; ++i) result[i] *= 1.0f + ((i / 3 + i / 3 / kWidth) % 2 == 0 ? noise : -noise);
    return result;
  };
  const Rendered noisy = rendered(clean, 2, 21), calm = rendered(clean, 400, 21);
  const auto error = [&](const Rendered& r, DenoiseRuns runs) {
    return relative_error(denoise(r.image, r.halves, kWidth, kHeight, adds_pattern, runs).image, clean);
  };
  const double without = error(noisy, DenoiseRuns::Halves);
  EXPECT_EQ(calls, 2);
  EXPECT_LT(error(noisy, DenoiseRuns::HalvesAndWhole), 0.7 * without);
  EXPECT_EQ(calls, 5);
  EXPECT_EQ(error(calm, DenoiseRuns::HalvesAndWhole), error(calm, DenoiseRuns::Halves));
  EXPECT_EQ(calls, 9);
  EXPECT_LT(error(noisy, DenoiseRuns::Whole), 0.7 * without);
  EXPECT_EQ(calls, 10);
}

TEST(Denoise, bright_pixels_keep_their_light_where_they_are_frequent) {
  // On the left, all light is in a twentieth of the pixels. On the right, there is one firefly.
  std::vector<float> image(kValues, 0.5f), halves(2 * kValues, 0.5f);
  Pcg32 rng(3);
  double light = 0.0;
  for (size_t i = 0; i < kValues / 3; ++i) {
    const bool left = i % kWidth < kWidth / 2;
    for (size_t half = 0; half < 2; ++half) {
      const bool bright = left ? rng.next_float() < 0.05f : i == 40 * kWidth + 80 && half == 0;
      for (size_t c = 0; c < 3; ++c)
        halves[6 * i + 3 * half + c] = left ? (bright ? 10.0f : 0.0f) : (bright ? 500.0f : 0.5f);
    }
    if (left) light += double(halves[6 * i] + halves[6 * i + 3]);
    for (size_t c = 0; c < 3; ++c) image[3 * i + c] = 0.5f * (halves[6 * i + c] + halves[6 * i + 3 + c]);
  }
  double seen = 0.0, most = 0.0;
  denoise(
      image, halves, kWidth, kHeight,
      [&](std::vector<float> noisy) {
        for (size_t i = 0; i < kValues / 3; ++i) {
          if (i % kWidth < kWidth / 2)
            seen += double(noisy[3 * i]);
          else if (i % kWidth > kWidth / 2 + 12)
            most = std::max(most, double(noisy[3 * i]));
        }
        return noisy;
      },
      DenoiseRuns::Halves);
  EXPECT_GT(seen, 0.9 * light);
  EXPECT_LT(most, 5.0);
}

TEST(Denoise, a_pixel_that_is_bright_in_both_halves_by_chance_is_not_restored_but_a_highlight_is) {
  const std::vector<float> clean(kValues, 0.5f);
  const auto removes = [&](const std::vector<float>&) { return clean; };
  const size_t pixel = 30 * kWidth + 40;
  const auto shown = [&](float first, float second) {
    Rendered r = rendered(clean, 8, 31);
    for (size_t c = 0; c < 3; ++c) {
      r.halves[6 * pixel + c] = first;
      r.halves[6 * pixel + 3 + c] = second;
      r.image[3 * pixel + c] = 0.5f * (first + second);
    }
    return denoise(r.image, r.halves, kWidth, kHeight, removes).image[3 * pixel];
  };
  EXPECT_LT(shown(30.0f, 20.0f), 2.0f);
  EXPECT_GT(shown(30.0f, 29.9f), 25.0f);
}

TEST(Denoise, a_highlight_in_heavy_noise_has_no_dark_ring) {
  // Two of a hundred pixels of each half are bright, all others are 0.2. The highlight is significant in the finest plane,
  // and so are the negative values of this plane around it.
  const std::vector<float> clean(kValues, 0.35f);
  const auto removes = [&](const std::vector<float>&) { return clean; };
  const size_t pixel = 30 * kWidth + 40;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Rendered r{std::vector<float>(kValues), std::vector<float>(2 * kValues, 0.2f)};
    Pcg32 rng(seed);
    for (size_t i = 0; i < 2 * kValues; i += 3) {
      const float found = rng.next_float() < 0.02f ? 15.0f * rng.next_float() : 0.0f;
      for (size_t c = i; c < i + 3; ++c) r.halves[c] = i / 6 == pixel ? 30.0f : r.halves[c] + found;
    }
    take_mean_of_halves(r);
    const std::vector<float> shown = denoise(r.image, r.halves, kWidth, kHeight, removes).image;
    EXPECT_GT(shown[3 * pixel], 20.0f);
    EXPECT_GT(*std::min_element(shown.begin(), shown.end()), 0.19f) << "seed " << seed;
  }
}

TEST(Denoise, extremely_bright_details_are_finite) {
  const std::vector<float> clean(kValues, 0.05f);
  for (const float light : {1e10f, 1e18f}) {
    Rendered r = rendered(clean, 4, 3);
    for (size_t i = 1000; i < 1020; ++i)
      for (size_t c = 0; c < 3; ++c) {
        r.halves[6 * i + c + (i % 2) * 3] = light;
        r.image[3 * i + c] = 0.5f * light;
      }
    const Denoised result = denoise(r.image, r.halves, kWidth, kHeight,
                                    [&](const std::vector<float>&) { return clean; });
    for (const float v : result.image) ASSERT_TRUE(std::isfinite(v)) << light;
  }
}

TEST(Denoise, sparks_that_the_denoiser_removes_have_no_halo) {
  // Few samples: the pixels of a spark are bright in each half with a probability of 0.4.
  constexpr float kGround = 0.05f;
  const std::vector<float> clean(kValues, kGround);
  const auto removes = [&](const std::vector<float>&) { return clean; };
  const auto is_spark = [](int x, int y) { return x % 32 >= 12 && x % 32 < 20 && y % 32 >= 14 && y % 32 < 17; };
  const auto is_near = [](int x, int y) { return x % 32 >= 8 && x % 32 < 24 && y % 32 >= 10 && y % 32 < 21; };
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Rendered r = rendered(clean, 4, seed);
    Pcg32 rng(seed);
    for (int i = 0; i < kWidth * kHeight; ++i)
      for (size_t half = 0; half < 2; ++half) {
        if (!is_spark(i % kWidth, i / kWidth) || rng.next_float() > 0.4f) continue;
        for (size_t c = 0; c < 3; ++c) r.halves[6 * size_t(i) + 3 * half + c] = 50.0f;
      }
    take_mean_of_halves(r);
    const std::vector<float> shown = denoise(r.image, r.halves, kWidth, kHeight, removes).image;
    double brightest = 0.0, light = 0.0;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      if (is_spark(i % kWidth, i / kWidth)) light += double(shown[3 * size_t(i)]) / (6 * 24);
      if (!is_near(i % kWidth, i / kWidth)) brightest = std::max(brightest, double(shown[3 * size_t(i)]));
    }
    EXPECT_LT(brightest, 4.0 * double(kGround)) << "seed " << seed;
    EXPECT_GT(light, 0.08 * 0.4 * 50.0) << "seed " << seed;
  }
}

TEST(Denoise, a_bright_pixel_of_both_halves_among_rare_light_has_no_dark_ring) {
  constexpr float kGround = 0.2f;
  const std::vector<float> clean(kValues, kGround);
  constexpr int kX = kWidth / 2, kY = kHeight / 2;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Rendered r = rendered(clean, 4, seed);
    Pcg32 rng(seed);
    for (size_t i = 0; i < size_t(kWidth * kHeight); ++i)
      for (size_t half = 0; half < 2; ++half) {
        const bool is_detail = i == size_t(kY * kWidth + kX);
        // Rare light leaves most pixels dark.
        const float light = is_detail                  ? 17.0f + 3.0f * float(half)
                            : rng.next_float() < 0.05f ? 3.0f + 9.0f * rng.next_float()
                                                       : 0.05f;
        for (size_t c = 0; c < 3; ++c) r.halves[6 * i + 3 * half + c] = light;
      }
    take_mean_of_halves(r);
    const std::vector<float> shown = denoise(r.image, r.halves, kWidth, kHeight, [&](const std::vector<float>&) {
                                       return clean;
                                     }).image;
    const auto at = [&](int x, int y) { return double(shown[3 * size_t(y * kWidth + x)]); };
    double ring = 0.0;
    for (int v = -1; v <= 1; ++v)
      for (int u = -1; u <= 1; ++u)
        if (u != 0 || v != 0) ring += at(kX + u, kY + v) / 8.0;
    EXPECT_GT(at(kX, kY), 10.0) << "seed " << seed;
    EXPECT_GT(ring, 0.6 * double(kGround)) << "seed " << seed;
  }
}

// Of a detail whose fine part is significant, the coarse part counts too.
TEST(Denoise, stripes_that_the_denoiser_removes_return_with_their_coarse_parts) {
  const std::vector<float> ground(kValues, 0.4f);
  std::vector<float> clean = ground;
  for (size_t i = 0; i < kValues; ++i)
    if (int(i / 3) % kWidth % 32 < 3) clean[i] = 0.9f;
  const auto removes = [&](const std::vector<float>&) { return ground; };
  RunningMoments error;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    const Rendered r = rendered(clean, 25, seed);
    error.add(relative_error(denoise(r.image, r.halves, kWidth, kHeight, removes).image, clean));
  }
  EXPECT_LT(error.mean(), 0.0115);
}

TEST(Denoise, without_halves_the_image_of_the_denoiser_is_returned) {
  const std::vector<float> clean = truth();
  Rendered r = rendered(clean, 4, 9);
  EXPECT_EQ(denoise(r.image, {}, kWidth, kHeight, dark_blur).image, dark_blur(r.image));
  r.halves[100] = std::numeric_limits<float>::quiet_NaN();
  const Denoised result = denoise(r.image, r.halves, kWidth, kHeight, dark_blur);
  EXPECT_EQ(result.image, dark_blur(r.image));
  EXPECT_TRUE(result.error.empty());
}

TEST(Denoise, negative_light_is_kept) {
  const std::vector<float> dark(kValues, -0.5f);
  std::vector<float> halves(2 * kValues, -0.5f);
  for (const float v : denoise(dark, halves, kWidth, kHeight, dark_blur).image) EXPECT_NEAR(v, -0.5f, 1e-5f);
}

// The part with less noise keeps its edges, because it is denoised alone.
TEST(Denoise, direct_light_is_denoised_apart) {
  std::vector<float> direct = truth(), rest(kValues, 0.3f);
  std::vector<float> clean(kValues);
  for (size_t i = 0; i < kValues; ++i) clean[i] = direct[i] + rest[i];
  double apart = 0.0, together = 0.0;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const Rendered one = rendered(direct, 1024, seed), two = rendered(rest, 4, 100 + seed);
    Rendered sum = one;
    for (size_t i = 0; i < sum.halves.size(); ++i) sum.halves[i] += two.halves[i];
    for (size_t i = 0; i < kValues; ++i) sum.image[i] += two.image[i];
    const Denoised separated = denoise({sum.image, sum.halves, one.halves, kWidth, kHeight}, dark_blur);
    apart += relative_error(separated.image, clean);
    together += relative_error(denoise(sum.image, sum.halves, kWidth, kHeight, dark_blur).image, clean);
    EXPECT_EQ(separated.error.size(), kValues / 3);
  }
  EXPECT_LT(apart, 0.9 * together);
  // Direct halves that an integrator does not know change nothing.
  const Rendered r = rendered(clean, 16, 5);
  const std::vector<float> unknown(2 * kValues, std::nanf(""));
  EXPECT_EQ(denoise({r.image, r.halves, unknown, kWidth, kHeight}, dark_blur).image,
            denoise(r.image, r.halves, kWidth, kHeight, dark_blur).image);
}

TEST(Denoise, separated_parts_converge_and_keep_their_energy) {
  const std::vector<float> direct = truth(), rest(kValues, 0.3f);
  std::vector<float> clean(kValues);
  for (size_t i = 0; i < kValues; ++i) clean[i] = direct[i] + rest[i];
  double before[2] = {1e9, 1e9};
  for (const int samples : {16, 256, 4096}) {
    const Rendered one = rendered(direct, samples, 1), two = rendered(rest, samples, 2);
    Rendered sum = one;
    for (size_t i = 0; i < sum.halves.size(); ++i) sum.halves[i] += two.halves[i];
    for (size_t i = 0; i < kValues; ++i) sum.image[i] += two.image[i];
    for (const DenoiseRuns runs : {DenoiseRuns::HalvesAndWhole, DenoiseRuns::Whole}) {
      const Denoised result = denoise({sum.image, sum.halves, one.halves, kWidth, kHeight}, dark_blur, runs);
      const double error = relative_error(result.image, clean);
      double& last = before[runs == DenoiseRuns::Whole];
      EXPECT_LT(error, last) << samples;
      EXPECT_LT(error, 1.02 * relative_error(sum.image, clean) + 1e-9) << samples;
      if (samples > 16) {
        EXPECT_NEAR(sum_of(result.image) / sum_of(sum.image), 1.0, 0.005) << samples;
      }
      last = error;
    }
  }
}

TEST(Denoise, pixels_that_are_bright_in_both_halves_by_chance_are_no_details) {
  // A twentieth of the pixels of each half has found a lamp, with the same brightness. A few have in both halves.
  const std::vector<float> clean(kValues, 0.2f);
  const auto removes = [&](const std::vector<float>&) { return clean; };
  int both = 0;
  double left = 0.0;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    Rendered r = rendered(clean, 4096, seed);
    Pcg32 rng(seed);
    for (size_t i = 0; i < 2 * kValues; i += 6) {
      const bool one = rng.next_float() < 0.05f, two = rng.next_float() < 0.05f;
      both += one && two;
      for (size_t c = i; c < i + 3; ++c) {
        r.halves[c] += one ? 3.0f : 0.0f;
        r.halves[c + 3] += two ? 3.0f : 0.0f;
      }
    }
    const std::vector<float> shown = denoise(r.image, r.halves, kWidth, kHeight, removes).image;
    left += double(std::count_if(shown.begin(), shown.end(), [](float v) { return v > 1.0f; })) / 3.0;
    EXPECT_GT(*std::min_element(shown.begin(), shown.end()), 0.15f) << "seed " << seed;
  }
  EXPECT_GT(both, 20);
  EXPECT_LT(left, 0.2 * both);
}

TEST(Denoise, errors_are_judged_in_the_displayed_image) {
  // A dark and a bright half, whose light the denoiser changes by a tenth.
  std::vector<float> clean(kValues);
  for (size_t i = 0; i < kValues; ++i) clean[i] = (i / 3) % kWidth < kWidth / 2 ? 0.02f : 2.0f;
  constexpr float kTimes = 256.0f;
  Rendered plain = rendered(clean, 16, 11), bright = plain, second = rendered(clean, 16, 12);
  const auto both = [](const Rendered& a, const Rendered& b) {
    std::vector<float> halves(2 * a.halves.size());
    for (size_t i = 0; i < a.halves.size(); i += 6) {
      std::copy_n(&a.halves[i], 6, &halves[2 * i]);
      std::copy_n(&b.halves[i], 6, &halves[2 * i + 6]);
    }
    return halves;
  };
  std::vector<float> halves = both(plain, second), bright_halves = halves;
  for (float& v : bright.image) v *= kTimes;
  for (float& v : bright_halves) v *= kTimes;
  const Denoised a = denoise({plain.image, halves, {}, kWidth, kHeight}, dark_blur),
                 b = denoise({bright.image, bright_halves, {}, kWidth, kHeight, {}, 1.0f / kTimes}, dark_blur),
                 not_told = denoise({bright.image, bright_halves, {}, kWidth, kHeight}, dark_blur);
  double differences = 0.0, not_told_differences = 0.0;
  for (size_t i = 0; i < kValues; ++i) {
    differences += std::abs(b.image[i] / (kTimes * a.image[i]) - 1.0f) / kValues;
    not_told_differences += std::abs(not_told.image[i] / (kTimes * a.image[i]) - 1.0f) / kValues;
  }
  EXPECT_LT(differences, 1e-5);
  EXPECT_GT(not_told_differences, 1e-3);
  for (size_t i = 0; i < a.error.size(); ++i) ASSERT_NEAR(b.error[i], a.error[i], 1e-4f * a.error[i] + 1e-9f);
}

}  // namespace

}  // namespace ajar::test_denoise
