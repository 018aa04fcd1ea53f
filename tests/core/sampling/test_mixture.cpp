#include <gtest/gtest.h>

#include "sampling/mixture.h"
#include "statistical.h"
#include "toy_mixture.h"

namespace ajar::test_mixture {

TEST(Mixture, counts_have_the_expectation_of_their_shares_and_differ_from_it_by_less_than_one) {
  const std::vector<std::vector<float>> cases{
      {0.5f, 0.25f, 0.25f}, {0.013f, 0.3f, 0.687f}, {0.2f, 0.2f, 0.2f, 0.2f, 0.2f}, {1.0f}};
  for (const auto& shares : cases) {
    for (int n : {1, 2, 3, 7, 16}) {
      constexpr int kOffsets = 20000;
      std::vector<double> mean(shares.size(), 0.0);
      for (int o = 0; o < kOffsets; ++o) {
        std::vector<int> counts(shares.size());
        deterministic_counts(shares, n, (float(o) + 0.5f) / kOffsets, counts);
        EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), 0), n);
        for (size_t k = 0; k < shares.size(); ++k) {
          EXPECT_LT(std::abs(float(counts[k]) - float(n) * shares[k]), 1.0f + 1e-5f);
          mean[k] += double(counts[k]) / kOffsets;
        }
      }
      // The offsets are on a grid, and the error of the mean is at most that of the grid.
      for (size_t k = 0; k < shares.size(); ++k) EXPECT_NEAR(mean[k], n * double(shares[k]), 2.0 / kOffsets + 1e-5);
    }
  }
}

TEST(Mixture, shares_never_fall_below_the_floor) {
  Pcg32 rng(7);
  for (int trial = 0; trial < 2000; ++trial) {
    const size_t m = 1 + rng.next() % 8;
    std::vector<float> shares(m);
    for (float& s : shares) s = rng.next() % 3 == 0 ? 0.0f : std::exp(40.0f * rng.next_float() - 20.0f);
    const float floor = 0.5f * rng.next_float() / float(m);
    apply_floor(shares, floor);
    float sum = 0.0f;
    for (float s : shares) {
      EXPECT_GE(s, floor);
      sum += s;
    }
    EXPECT_NEAR(sum, 1.0f, 1e-5f);
  }
}

TEST(Mixture, shares_that_are_not_finite_or_all_zero_become_equal) {
  for (float bad : {0.0f, std::nanf(""), HUGE_VALF}) {
    std::vector<float> shares{bad, 0.0f};
    apply_floor(shares, 0.01f);
    EXPECT_FLOAT_EQ(shares[0], 0.5f);
    EXPECT_FLOAT_EQ(shares[1], 0.5f);
  }
}

TEST(Mixture, one_sample_of_unequal_shares_is_already_unbiased) {
  auto mixture = toy::mixture();
  mixture.set_shares({0.81f, 0.02f, 0.17f}, 0.01f);
  for (int n : {1, 2, 5}) {
    RunningMoments estimates;
    Pcg32 rng(11, uint64_t(n));
    for (int r = 0; r < 40000; ++r) estimates.add(toy::plain_estimate(mixture, n, rng));
    EXPECT_TRUE(statistical::mean_agrees(estimates, toy::kIntegral, {0.001}));
  }
}

TEST(Mixture, shares_learned_in_earlier_iterations_keep_the_mean_and_lower_the_variance) {
  // The second light is dark, so that equal shares waste a third of the samples.
  RunningMoments adapted, equal;
  for (int r = 0; r < 20000; ++r) {
    Pcg32 rng(5, uint64_t(r));
    auto mixture = toy::mixture();
    equal.add(toy::plain_estimate(mixture, 18, rng, nullptr, 0.0f));
    // Three iterations of six samples. Each uses the shares from the iterations before it.
    double sum = 0.0;
    for (int iteration = 0; iteration < 3; ++iteration) {
      std::vector<double> sums(mixture.size(), 0.0);
      sum += toy::plain_estimate(mixture, 6, rng, &sums, 0.0f) / 3.0;
      // The previous shares are a prior with the weight of three samples.
      const double total = sums[0] + sums[1] + sums[2];
      std::vector<float> shares(mixture.shares().begin(), mixture.shares().end());
      for (size_t k = 0; total > 0.0 && k < shares.size(); ++k)
        shares[k] = (6.0f * float(sums[k] / total) + 3.0f * shares[k]) / 9.0f;
      mixture.set_shares(shares, 0.05f);
    }
    adapted.add(sum);
  }
  EXPECT_TRUE(statistical::mean_agrees(adapted, toy::integral(0.0), {0.001}));
  EXPECT_TRUE(statistical::mean_agrees(equal, toy::integral(0.0), {0.001}));
  EXPECT_LT(adapted.variance(), 0.95 * equal.variance());
}

}  // namespace ajar::test_mixture
