#include <gtest/gtest.h>

#include "render/remaining_time.h"

namespace ajar::test_remaining_time {

/// A render that starts after `start` seconds and takes `pace` seconds for each sample, after `samples` samples of one
/// iteration each.
RemainingTime after(double samples, double pace, double start) {
  RemainingTime time;
  time.begin(start);
  for (double n = 1.0; n <= samples; n += 1.0) time.add(start + pace * n, n);
  return time;
}

TEST(RemainingTime, is_unknown_before_the_first_iteration) {
  RemainingTime time;
  EXPECT_LT(time.until_samples(100), 0.0);
  time.begin(3.0);
  EXPECT_LT(time.seconds_per_sample(), 0.0);
  EXPECT_LT(time.until_samples(100), 0.0);
  EXPECT_LT(time.until_error(1e-2, 1e-3), 0.0);
  time.add(5.0, 4.0);
  EXPECT_DOUBLE_EQ(time.until_samples(100), 48.0);
}

TEST(RemainingTime, remaining_samples_take_as_long_as_the_latest_ones) {
  EXPECT_NEAR(after(25, 2.0, 0.0).until_samples(100), 150.0, 1e-9);
  EXPECT_EQ(after(25, 2.0, 0.0).until_samples(25), 0.0);
  EXPECT_EQ(after(25, 2.0, 0.0).until_samples(10), 0.0);
}

TEST(RemainingTime, time_before_the_first_sample_is_not_extrapolated) {
  for (const double samples : {1.0, 10.0, 64.0})
    EXPECT_NEAR(after(samples, 0.5, 1000.0).until_samples(100), 0.5 * (100 - samples), 1e-9);
}

TEST(RemainingTime, slow_first_samples_are_ignored_later) {
  RemainingTime time;
  time.begin(0.0);
  double seconds = 0.0;
  for (double n = 1.0; n <= 64.0; n += 1.0) time.add(seconds += n <= 16.0 ? 10.0 : 1.0, n);
  EXPECT_NEAR(time.until_samples(100), 36.0, 1e-9);
}

TEST(RemainingTime, an_error_with_the_expected_exponent_gives_the_correct_time) {
  for (const double exponent : {1.0, RemainingTime::kErrorExponent, 1.3}) {
    const double end = 1000.0, target = 1e-3;
    for (const double part : {0.1, 0.25, 0.5, 0.75}) {
      const double n = end * part, error = target * std::pow(part, -exponent);
      const double ratio = after(n, 0.01, 7.0).until_error(error, target) / (0.01 * (end - n));
      if (exponent == RemainingTime::kErrorExponent)
        EXPECT_NEAR(ratio, 1.0, 1e-9) << part;
      else if (exponent < RemainingTime::kErrorExponent)
        EXPECT_TRUE(ratio > 0.75 && ratio < 1.0) << part << ": " << ratio;
      else
        EXPECT_TRUE(ratio > 1.0 && ratio < 1.55) << part << ": " << ratio;
    }
  }
}

TEST(RemainingTime, an_error_target_does_not_stop_renders_of_few_samples) {
  EXPECT_NEAR(after(4, 1.0, 0.0).until_error(1e-6, 1e-3), 12.0, 1e-9);
  EXPECT_EQ(after(20, 1.0, 0.0).until_error(1e-6, 1e-3), 0.0);
  EXPECT_LT(after(20, 1.0, 0.0).until_error(-1.0, 1e-3), 0.0);
}

TEST(RemainingTime, a_long_render_stores_few_times_and_keeps_its_pace) {
  RemainingTime time;
  time.begin(0.0);
  for (double n = 1.0; n < 1e6; n *= 1.001) time.add(3.0 * n, n);
  EXPECT_NEAR(time.seconds_per_sample(), 3.0, 1e-9);
}

}  // namespace ajar::test_remaining_time
