#include "statistical.h"

#include "math/distribution.h"

namespace ajar::test_distribution {

namespace {

using namespace statistical;

/// For each entry, how many of the 2^24 numbers that a generator can return choose it.
std::vector<uint32_t> counts_over_all_floats(const DiscreteDistribution& distribution) {
  std::vector<uint32_t> counts(distribution.size(), 0);
  for (uint32_t i = 0; i < (1u << 24); ++i) ++counts[distribution.sample(float(i) * 0x1p-24f).index];
  return counts;
}

TEST(DiscreteDistribution, pmf_is_exactly_the_probability_of_every_entry) {
  // Weights over ten orders of magnitude, with zeros at the ends and inside.
  const std::vector<double> weights{0.0, 1.0, 1e-10, 0.0, 5.0, 3e-4, 1e-3, 0.0};
  const DiscreteDistribution distribution(weights);
  const auto counts = counts_over_all_floats(distribution);
  for (uint32_t i = 0; i < weights.size(); ++i) {
    EXPECT_EQ(double(counts[i]) * 0x1p-24, double(distribution.pmf(i))) << i;
    EXPECT_EQ(weights[i] > 0.0, counts[i] > 0) << i;
    EXPECT_NEAR(distribution.pmf(i), weights[i] / distribution.total(), 5e-7) << i;
  }
}

TEST(DiscreteDistribution, a_million_entries_keep_their_probabilities) {
  const size_t count = 1000003;
  std::vector<double> weights(count);
  Pcg32 rng(3);
  for (double& w : weights) w = rng.next_float() < 0.1f ? 0.0 : std::exp(8.0 * rng.next_float());
  const DiscreteDistribution distribution(weights);
  const auto counts = counts_over_all_floats(distribution);
  double sum = 0.0;
  for (uint32_t i = 0; i < count; ++i) {
    ASSERT_EQ(double(counts[i]) * 0x1p-24, double(distribution.pmf(i))) << i;
    ASSERT_EQ(weights[i] > 0.0, counts[i] > 0) << i;
    sum += distribution.pmf(i);
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
}

TEST(DiscreteDistribution, many_small_entries_do_not_change_the_probabilities_of_large_ones) {
  // 250,000 entries with one hundredth of the total weight, after and before ten large ones.
  for (bool last : {false, true}) {
    std::vector<double> weights(250010, 0.01 / 250000.0);
    for (int i = 0; i < 10; ++i) weights[size_t(last ? 250000 + i : i)] = 0.099;
    const DiscreteDistribution distribution(weights);
    for (int i = 0; i < 10; ++i) EXPECT_NEAR(distribution.pmf(uint32_t(last ? 250000 + i : i)), 0.099, 0.002);
  }
}

TEST(DiscreteDistribution, remapped_number_is_uniform_within_each_entry) {
  const DiscreteDistribution distribution({0.3, 0.0, 0.5, 0.2});
  RunningMoments moments[4];
  for (int i = 0; i < 100000; ++i) {
    const auto choice = distribution.sample((float(i) + 0.5f) / 100000.0f);
    ASSERT_GE(choice.u_remapped, 0.0f);
    ASSERT_LT(choice.u_remapped, 1.0f);
    moments[choice.index].add(choice.u_remapped);
  }
  for (int i : {0, 2, 3}) {
    EXPECT_NEAR(moments[i].mean(), 0.5, 1e-3);
    EXPECT_NEAR(moments[i].variance(), 1.0 / 12.0, 1e-3);
  }
}

TEST(DiscreteDistribution, a_distribution_without_weight_is_empty) {
  EXPECT_TRUE(DiscreteDistribution().empty());
  EXPECT_TRUE(DiscreteDistribution(std::vector<double>{}).empty());
  EXPECT_TRUE(DiscreteDistribution({0.0, 0.0}).empty());
}

std::vector<float> uneven_image(int width, int height) {
  std::vector<float> values(size_t(width) * height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      values[size_t(y) * width + x] = y == 2 ? 0.0f : float((x * 7 + y * 3) % 5) + (x == 4 && y == 5 ? 500.0f : 0.0f);
  return values;
}

TEST(Distribution2D, samples_follow_their_density) {
  const Distribution2D distribution(uneven_image(9, 8), 9, 8);
  const Map map = [&](Vec2 u) {
    float pdf;
    return Vec3(distribution.sample(u, pdf), 0.0f);
  };
  const Density pdf = [&](Vec3 p) { return distribution.pdf_square(Vec2(p)); };
  const DensityTest test{.domain = SampleDomain::Square, .bin_count = 400};
  EXPECT_TRUE(chi_square_agrees(from_square(map), pdf, test));
  EXPECT_TRUE(integral_agrees(from_square(map), pdf, 1.0, test));
  EXPECT_TRUE(jacobian_agrees(map, pdf, {.step = 1.0 / 4096.0}));
}

TEST(Distribution2D, sample_returns_the_density_of_its_point) {
  const Distribution2D distribution(uneven_image(9, 8), 9, 8);
  Pcg32 rng(5);
  int at_edges = 0;
  for (int i = 0; i < 100000; ++i) {
    float pdf;
    const float x = rng.next_float();
    const Vec2 p = distribution.sample({x, rng.next_float()}, pdf);
    ASSERT_GT(pdf, 0.0f);
    ASSERT_TRUE(p.x < 1.0f && p.y < 1.0f);
    if (distribution.pdf_square(p) != pdf) ++at_edges;  // a point that was rounded into the next cell
  }
  EXPECT_LE(at_edges, 2);
}

}  // namespace

}  // namespace ajar::test_distribution
