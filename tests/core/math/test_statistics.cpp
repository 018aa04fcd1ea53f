#include "statistical.h"

#include "math/statistics.h"

namespace ajar::test_statistics {

namespace {

TEST(CompensatedSum, keeps_what_a_plain_sum_loses) {
  CompensatedSum sum;
  double plain = 0.0;
  for (double x : {1.0, 1e100, 1.0, -1e100}) {
    sum.add(x);
    plain += x;
  }
  EXPECT_EQ(sum.value(), 2.0);
  EXPECT_NE(plain, 2.0);
}

TEST(CompensatedSum, a_million_tenths_are_exact_to_the_last_digits) {
  CompensatedSum sum;
  for (int i = 0; i < 1000000; ++i) sum.add(0.1);
  EXPECT_NEAR(sum.value(), 100000.0, 1e-10);
}

TEST(RunningMoments, agree_with_a_two_pass_computation_far_from_zero) {
  Pcg32 rng(1);
  std::vector<double> values(1000);
  RunningMoments moments;
  for (double& v : values) moments.add(v = 1e9 + rng.next_float());
  double mean = 0.0, m2 = 0.0;
  for (double v : values) mean += (v - 1e9) / 1000.0;
  for (double v : values) m2 += (v - 1e9 - mean) * (v - 1e9 - mean);
  EXPECT_NEAR(moments.mean() - 1e9, mean, 1e-6);
  EXPECT_NEAR(moments.variance(), m2 / 999.0, 1e-7);
  EXPECT_NEAR(moments.variance_of_mean(), m2 / 999.0 / 1000.0, 1e-10);
}

TEST(RunningMoments, one_sample_has_no_variance) {
  RunningMoments moments;
  EXPECT_EQ(moments.variance(), 0.0);
  moments.add(3.0);
  EXPECT_EQ(moments.mean(), 3.0);
  EXPECT_EQ(moments.variance(), 0.0);
  EXPECT_EQ(moments.count(), 1u);
}

}  // namespace

}  // namespace ajar::test_statistics
