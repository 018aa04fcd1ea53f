// Sums over a long render: ten million terms are added without drift, in any order of threads.
#include <gtest/gtest.h>

#include <cmath>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "film/film.h"
#include "math/random.h"
#include "math/statistics.h"
#include "transport/direct/share_cache.h"

namespace ajar::test_drift {

namespace {

constexpr int kTerms = 10'000'000;

/// Renders one pixel for each size. Each pixel gets splats of its size, all in one iteration.
std::vector<float> splatted(const std::vector<float>& sizes, int threads, int terms) {
  Film film(0, 0, int(sizes.size()), 1, {"Combined"});
  film.enable_splats();
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_for(0, threads, [&](int t) {
      for (int i = t; i < terms; i += threads)
        for (size_t x = 0; x < sizes.size(); ++x) film.add_splat(int(x), 0, Color(sizes[x], 0.0f, -sizes[x]), i & 1);
    });
  });
  film.end_splats(1.0 / terms);
  EXPECT_EQ(film.refused(), 0u);
  return film.resolve("Combined", 1.0f);
}

TEST(Drift, ten_million_splats_in_a_pixel_are_their_mean) {
  const std::vector<float> sizes{0.1f, 7e5f, 3e-7f, 1e12f};  // one of each range; some would overflow a plain sum
  const std::vector<float> rgba = splatted(sizes, 2, kTerms);
  for (size_t x = 0; x < sizes.size(); ++x) {
    EXPECT_FLOAT_EQ(rgba[4 * x], sizes[x]);
    EXPECT_FLOAT_EQ(rgba[4 * x + 2], -sizes[x]);
  }
}

TEST(Drift, splats_beyond_an_integer_sum_do_not_depend_on_the_number_of_threads) {
  const std::vector<float> sizes{1.0471e6f, 4.4e15f};  // nearly the maximum of their range
  EXPECT_EQ(splatted(sizes, 1, 100'001), splatted(sizes, 2, 100'001));
}

TEST(Drift, moments_of_ten_million_values_far_from_zero_are_accurate) {
  RunningMoments moments;
  CompensatedSum sum;
  Pcg32 rng(1);
  for (int i = 0; i < kTerms; ++i) {
    const double x = 12345.678 + double(rng.next_float());  // variance 1/12
    moments.add(x);
    sum.add(x);
  }
  EXPECT_NEAR(moments.mean(), sum.value() / kTerms, 1e-9);
  EXPECT_NEAR(moments.mean(), 12346.178, 4.0 * std::sqrt(1.0 / 12.0 / kTerms));
  EXPECT_NEAR(moments.variance(), 1.0 / 12.0, 1e-4);
}

TEST(Drift, shares_after_ten_million_samples_in_a_cell_are_those_of_a_thousand) {
  for (const int samples : {1'000, kTerms}) {
    ShareCache cache(4, 2, 8.0f, 1.0f);
    for (int i = 0; i < samples; ++i) {
      cache.count(3);
      cache.add_square(3, 10.0f);
      cache.add_moment(3, 0, 9.0f);  // its root mean square is three times that of the other
      cache.add_moment(3, 1, 1.0f);
    }
    cache.publish();
    std::array<float, 2> shares;
    cache.shares(3, std::array{0.5f, 0.5f}, std::array{0.05f, 0.05f}, shares);
    EXPECT_NEAR(shares[0], 0.05f + 0.9f * 0.75f, 0.005f) << samples;
    EXPECT_NEAR(shares[0] + shares[1], 1.0f, 1e-6f);
  }
}

}  // namespace

}  // namespace ajar::test_drift
