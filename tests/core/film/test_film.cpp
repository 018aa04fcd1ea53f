#include <gtest/gtest.h>

#include "film/film.h"
#include "film/filter.h"
#include "film/tvi.h"
#include "math/random.h"
#include "math/statistics.h"
#include "sampling/sampler.h"

namespace ajar::test_film {

TEST(Film, refuses_and_counts_non_finite_samples_and_keeps_the_others) {
  Film film(0, 0, 2, 1, {"Combined"});
  EXPECT_TRUE(film.add_sample(0, 0, Color(1.0f), 1.0f, nullptr));
  EXPECT_FALSE(film.add_sample(0, 0, Color(std::nanf("")), 1.0f, nullptr));
  EXPECT_FALSE(film.add_sample(1, 0, Color(kInfinity, 0, 0), 1.0f, nullptr));
  EXPECT_EQ(film.refused(), 2u);
  const auto combined = film.resolve("Combined", 1.0f);
  EXPECT_FLOAT_EQ(combined[0], 0.5f);
  EXPECT_FLOAT_EQ(combined[4], 0.0f);
}

TEST(Film, ten_million_samples_do_not_drift) {
  Film film(0, 0, 1, 1, {"Combined"});
  const Color value(0.1f, 1e6f, 3e-7f);
  for (int i = 0; i < 10'000'000; ++i) film.add_sample(0, 0, value, 1.0f, nullptr);
  const auto combined = film.resolve("Combined", 1.0f);
  for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(combined[size_t(c)], value[c]);
}

TEST(Film, estimated_relmse_is_the_variance_of_the_mean) {
  // Independent noise of known variance around a large mean.
  Film film(0, 0, 64, 64, {"Combined"});
  Pcg32 rng(11);
  const int samples = 64;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int s = 0; s < samples; ++s) film.add_sample(x, y, Color(10.0f + rng.next_float()), 1.0f, nullptr);
  const double expected = (1.0 / 12.0) / samples / (10.5 * 10.5 + 0.01);
  EXPECT_NEAR(film.estimated_relmse() / expected, 1.0, 0.1);
  const auto variance = film.resolve("Variance", 1.0f);
  double mean = 0.0;
  for (float v : variance) mean += double(v) / double(variance.size());
  EXPECT_NEAR(mean / ((1.0 / 12.0) / samples), 1.0, 0.05);
}

TEST(Film, the_error_for_an_unknown_pass_lists_the_known_ones) {
  try {
    Film film(0, 0, 1, 1, {"Kombiniert"});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("Combined"), std::string::npos);
  }
}

class Filters : public ::testing::TestWithParam<std::pair<FilterKind, float>> {};

TEST_P(Filters, samples_are_distributed_like_the_filter) {
  const auto [kind, width] = GetParam();
  const PixelFilter filter(kind, width);
  constexpr int kBins = 64, kSamples = 1 << 20;
  const float full = PixelFilter::full_width(kind, width);
  std::vector<double> counts(kBins, 0.0), expected(kBins, 0.0);
  double total = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const float x = filter.sample({(float(i) + 0.5f) / kSamples, 0.5f}).x;
    ASSERT_LE(std::abs(x), 0.5f * full + 1e-5f);
    counts[size_t(std::min(kBins - 1, int((x / full + 0.5f) * kBins)))] += 1.0;
  }
  for (int b = 0; b < kBins; ++b) {
    for (int k = 0; k < 100; ++k)
      expected[size_t(b)] += filter.value(kind, ((b + (k + 0.5) / 100.0) / kBins - 0.5) * double(full));
    total += expected[size_t(b)];
  }
  for (int b = 0; b < kBins; ++b)
    EXPECT_NEAR(counts[size_t(b)] / kSamples, expected[size_t(b)] / total, 2e-4) << "bin " << b;
}

INSTANTIATE_TEST_SUITE_P(Kinds, Filters,
                         ::testing::Values(std::pair(FilterKind::Box, 1.0f), std::pair(FilterKind::Gaussian, 1.5f),
                                           std::pair(FilterKind::BlackmanHarris, 1.5f),
                                           std::pair(FilterKind::BlackmanHarris, 4.0f)));

TEST(Film, splats_add_to_the_mean_of_samples_in_any_order) {
  Film film(2, 3, 4, 5, {"Combined"}), other(2, 3, 4, 5, {"Combined"});
  film.enable_splats();
  other.enable_splats();
  Pcg32 rng(3);
  std::vector<Color> values;
  for (int i = 0; i < 1000; ++i) values.push_back(Color(rng.next_float() * 1000.0f, rng.next_float() * 1e-3f, 1.0f));
  for (size_t i = 0; i < values.size(); ++i) film.add_splat(3, 4, values[i], i & 1);
  for (size_t i = values.size(); i-- > 0;) other.add_splat(3, 4, values[i], i & 1);
  film.add_splat(0, 0, Color(1e6f), false);  // outside the film: ignored
  for (Film* f : {&film, &other}) {
    f->add_sample(3, 4, Color(2.0f), 1.0f, nullptr);
    f->add_sample(3, 4, Color(4.0f), 1.0f, nullptr);
    f->end_splats(0.5);
  }
  double sum = 0.0;
  for (const Color& v : values) sum += double(v.x);
  const auto image = film.resolve("Combined", 1.0f);
  EXPECT_EQ(image, other.resolve("Combined", 1.0f));
  EXPECT_FLOAT_EQ(image[3 * 4], float(3.0 + 0.5 * sum));
  EXPECT_FLOAT_EQ(image[3 * 4 + 2], 503.0f);
  EXPECT_EQ(image[0], 0.0f);
}

TEST(Film, splats_that_are_not_finite_or_too_large_are_refused_and_counted) {
  Film film(0, 0, 1, 1, {"Combined"});
  film.enable_splats();
  for (float bad : {std::nanf(""), kInfinity, 5e15f}) film.add_splat(0, 0, Color(bad, 0.0f, 0.0f), false);
  film.end_splats(1.0);
  EXPECT_EQ(film.refused(), 3u);
  EXPECT_EQ(film.resolve("Combined", 1.0f)[0], 0.0f);
}

TEST(Film, pixels_of_splats_follow_the_pixel_filters) {
  // Splats of uniform points must give a pixel the same mean as samples from its filter.
  for (const FilterKind kind : {FilterKind::Box, FilterKind::Gaussian, FilterKind::BlackmanHarris}) {
    const PixelFilter filter(kind, 1.5f);
    RunningMoments splatted;
    double expected = 0.0;
    const auto radiance = [](float film) { return std::sin(1.3 * double(film)) + 1.0; };
    Pcg32 rng(9);
    for (int i = 0; i < 200000; ++i) {
      const float film = 20.0f * (float(i) + rng.next_float()) / 200000.0f;
      const auto place = filter.place(film, 0, 20, rng.next_float());
      splatted.add(place.pixel == 7 ? 20.0 * double(place.weight) * radiance(film) : 0.0);
      expected += radiance(7.5f + filter.sample({(float(i) + 0.5f) / 200000.0f, 0.5f}).x) / 200000.0;
    }
    EXPECT_NEAR(splatted.mean(), expected, 4.0 * std::sqrt(splatted.variance_of_mean()) + 1e-3);
  }
}

TEST(Film, thresholds_of_vision_are_continuous_and_have_the_known_end_values) {
  EXPECT_NEAR(std::log10(tvi(1e-6)), -2.86, 1e-9);
  EXPECT_NEAR(std::log10(tvi(1e4)), 4.0 - 1.255, 1e-9);
  for (double joint : {-3.94, -1.44, -0.0184, 1.9})
    EXPECT_NEAR(std::log10(tvi(std::pow(10.0, joint - 1e-4))), std::log10(tvi(std::pow(10.0, joint + 1e-4))), 0.02)
        << joint;
}

TEST(Film, error_passes_and_estimates_are_the_standard_deviation_of_the_mean_in_their_units) {
  Film film(0, 0, 48, 48, {"Error", "Perceptual Error"});
  Pcg32 rng(5);
  const int samples = 100;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 48; ++x)
      for (int s = 0; s < samples; ++s) film.add_sample(x, y, Color(0.2f + 0.1f * rng.next_float()), 1.0f, nullptr);
  const double deviation = 0.1 / std::sqrt(12.0 * samples), mean = 0.25, threshold = tvi(25.0);
  const auto average = [&](const char* pass) {
    double sum = 0.0;
    for (float v : film.resolve(pass, 1.0f)) sum += double(v) / (48.0 * 48.0);
    return sum;
  };
  EXPECT_NEAR(average("Error") / (deviation / std::sqrt(mean * mean + 0.01)), 1.0, 0.02);
  EXPECT_NEAR(average("Perceptual Error") / (100.0 * deviation / threshold), 1.0, 0.02);
  EXPECT_NEAR(film.estimated_perceptual_error() / (1e4 * deviation * deviation / threshold), 1.0, 0.1);
}

TEST(Film, errors_are_relative_to_displayed_light) {
  constexpr float kTimes = 64.0f;
  const std::vector<std::string> passes = {"Error", "Perceptual Error"};
  Film plain(0, 0, 16, 16, passes), bright(0, 0, 16, 16, passes), not_told(0, 0, 16, 16, passes);
  bright.set_shown_exposure(1.0 / double(kTimes));
  for (const auto& [film, times] : {std::pair(&plain, 1.0f), {&bright, kTimes}, {&not_told, kTimes}}) {
    for (const uint32_t end : {8u, 16u, 32u}) {
      for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x)
          for (uint32_t i = film->samples_of(x, y); i < end; ++i)
            film->add_sample(x, y, Color(times * 0.1f * to_unit_float(hash_combine(uint32_t(16 * y + x), i))), 1.0f,
                             nullptr);
      if (end < 32) film->remember(end);
    }
  }
  const Film::ErrorEstimate a = plain.estimated_error(32), b = bright.estimated_error(32);
  EXPECT_NEAR(b.relmse / a.relmse, 1.0, 1e-5);
  EXPECT_NEAR(b.perceptual / a.perceptual, 1.0, 1e-5);
  EXPECT_NEAR(bright.estimated_relmse() / plain.estimated_relmse(), 1.0, 1e-5);
  for (const std::string& pass : passes) {
    const std::vector<float> of_plain = plain.resolve(pass, 1.0f), of_bright = bright.resolve(pass, 1.0f);
    for (size_t i = 0; i < of_plain.size(); ++i) ASSERT_NEAR(of_bright[i], of_plain[i], 1e-4f * of_plain[i]) << pass;
  }
  EXPECT_GT(not_told.estimated_error(32).relmse, 3.0 * a.relmse) << "darkness counts if it is not known to be dark";
}

TEST(Film, the_error_pass_of_splats_is_their_standard_deviation) {
  // Poisson splats of value 1, on average eight of each half in a pixel. The variance of the sum is the number of
  // splats.
  Film film(0, 0, 64, 64, {"Error"});
  film.enable_splats();
  Pcg32 rng(6);
  const int splats = 16 * 64 * 64;
  for (int i = 0; i < splats; ++i) film.add_splat(int(rng.next() % 64), int(rng.next() % 64), Color(1.0f), i & 1);
  film.end_splats(1.0);
  double sum = 0.0;
  for (float v : film.resolve("Error", 1.0f)) sum += double(v) * double(v) / (64.0 * 64.0);
  EXPECT_NEAR(sum, 16.0 * (1.0 + 3.0 / 16.0) / (16.0 * 16.0), 0.006);  // E 1/M^2 for Poisson M, to second order
}

TEST(Film, estimated_error_is_correct_for_independent_and_for_stratified_samples) {
  // Every pixel has an edge: a quarter disc of radius t covers pi t^2 / 4 of it. The error of stratified samples is
  // several times smaller.
  for (const Sampler::Kind kind : {Sampler::Kind::Independent, Sampler::Kind::Sobol}) {
    RunningMoments ratio, visible_ratio, scatter_ratio;
    for (uint32_t seed = 0; seed < 10; ++seed) {
      Film film(0, 0, 64, 64, {"Combined"});
      const auto radius = [&](int x, int y) {
        return 0.3f + 0.6f * to_unit_float(hash_combine(uint32_t(x) + 64 * seed, uint32_t(y)));
      };
      Sampler sampler(kind, seed);
      for (uint32_t end : {16u, 32u, 64u}) {
        for (int y = 0; y < 64; ++y) {
          for (int x = 0; x < 64; ++x) {
            for (uint32_t i = film.samples_of(x, y); i < end; ++i) {
              sampler.start(uint32_t(y * 64 + x), i);
              const Vec2 u = sampler.get_2d();
              film.add_sample(x, y, Color(glm::dot(u, u) < radius(x, y) * radius(x, y) ? 1.2f : 0.2f), 1.0f, nullptr);
            }
          }
        }
        if (end < 64) film.remember(end);
      }
      const auto image = film.resolve("Combined", 1.0f);
      double truth = 0.0, visible = 0.0;
      for (int i = 0; i < 64 * 64; ++i) {
        const double t = double(radius(i % 64, i / 64)), right = 0.2 + kPi * t * t / 4.0,
                     e = double(image[size_t(i) * 4]) - right;
        truth += e * e / (right * right + 0.01) / 4096.0;
        visible += 1e4 * e * e / tvi(100.0 * right) / 4096.0;
      }
      const Film::ErrorEstimate estimate = film.estimated_error(64);
      ratio.add(estimate.relmse / truth);
      visible_ratio.add(estimate.perceptual / visible);
      scatter_ratio.add(film.estimated_relmse() / truth);
    }
    EXPECT_NEAR(ratio.mean(), 1.0, 0.15) << int(kind);
    EXPECT_NEAR(visible_ratio.mean(), 1.0, 0.15) << int(kind);
    if (kind == Sampler::Kind::Sobol) {
      EXPECT_GT(scatter_ratio.mean(), 2.0);
    }
  }
}

TEST(Film, estimated_error_is_correct_where_few_bright_samples_cause_it) {
  // One sample in fifty is 10, the others are 0.2. Pixels with more bright samples than others have a larger mean,
  // which must not reduce their estimated error.
  RunningMoments ratio, visible_ratio;
  for (uint32_t seed = 0; seed < 20; ++seed) {
    Film film(0, 0, 48, 48, {"Combined"});
    for (uint32_t end : {8u, 16u, 32u}) {
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 48; ++x)
          for (uint32_t i = film.samples_of(x, y); i < end; ++i)
            film.add_sample(
                x, y,
                Color(to_unit_float(hash_combine(hash_combine(seed, uint32_t(y * 48 + x)), i)) < 0.02f ? 10.0f : 0.2f),
                1.0f, nullptr);
      if (end < 32) film.remember(end);
    }
    const auto image = film.resolve("Combined", 1.0f);
    const double right = 0.2 + 0.02 * 9.8;
    double truth = 0.0;
    for (size_t i = 0; i < 48 * 48; ++i)
      truth += (double(image[4 * i]) - right) * (double(image[4 * i]) - right) / 2304.0;
    const Film::ErrorEstimate estimate = film.estimated_error(32);
    ratio.add(estimate.relmse / (truth / (right * right + 0.01)));
    visible_ratio.add(estimate.perceptual / (1e4 * truth / tvi(100.0 * right)));
  }
  EXPECT_NEAR(ratio.mean(), 1.0, 0.15);
  EXPECT_NEAR(visible_ratio.mean(), 1.0, 0.15);
}

namespace {
/// Adds samples to each pixel until it has `end`. One sample in fifty is 10, the others are 0.2.
void add_rare_bright_samples(Film& film, uint32_t seed, uint32_t end) {
  for (int y = 0; y < film.height(); ++y)
    for (int x = 0; x < film.width(); ++x)
      for (uint32_t i = film.samples_of(x, y); i < end; ++i)
        film.add_sample(
            x, y,
            Color(to_unit_float(hash_combine(hash_combine(seed, uint32_t(y * film.width() + x)), i)) < 0.02f ? 10.0f
                                                                                                             : 0.2f),
            1.0f, nullptr);
}
}  // namespace

TEST(Film, estimated_error_does_not_jump_where_another_stored_image_is_used) {
  RunningMoments jump;
  for (uint32_t seed = 0; seed < 10; ++seed) {
    Film film(0, 0, 48, 48, {"Combined"});
    for (uint32_t end : {8u, 16u, 32u}) {
      add_rare_bright_samples(film, seed, end);
      film.remember(end);
    }
    add_rare_bright_samples(film, seed, 42);
    const double before = film.estimated_error(42).relmse;
    add_rare_bright_samples(film, seed, 43);  // 32 is less than three quarters of 43
    jump.add(std::abs(std::log(film.estimated_error(43).relmse * 43.0 / (before * 42.0))));
  }
  EXPECT_LT(jump.mean(), 0.02);
}

TEST(Film, estimated_error_of_few_samples_is_not_far_too_small_where_counts_differ) {
  // In an adaptive render, the first samples have no learned distribution, and most pixels have no bright sample yet.
  RunningMoments ratio;
  for (uint32_t seed = 0; seed < 10; ++seed) {
    Film film(0, 0, 48, 48, {"Combined"});
    film.set_goals(std::vector<uint32_t>(48 * 48, 16));
    for (uint32_t end : {2u, 4u, 8u}) {
      add_rare_bright_samples(film, seed, end);
      film.remember(end);
    }
    add_rare_bright_samples(film, seed, 16);
    const double right = 0.2 + 0.02 * 9.8, variance = 0.02 * 0.98 * 9.8 * 9.8;
    ratio.add(film.estimated_error(16).relmse / (variance / 16.0 / (right * right + 0.01)));
  }
  EXPECT_GT(ratio.mean(), 0.8);
  EXPECT_LT(ratio.mean(), 1.6);
}

}  // namespace ajar::test_film
