// Properties that the points of Sampler must have.
#include "statistical.h"

#include "sampling/sampler.h"

namespace ajar::test_sampler {

namespace {

using namespace statistical;

constexpr uint32_t kSeeds[] = {0u, 1u, 0xdeadbeefu};

/// True if every elementary interval of area 2^-k, in all k + 1 shapes, contains exactly one of the 2^k points.
bool is_net(const std::vector<Vec2>& points, int k) {
  for (int a = 0; a <= k; ++a) {
    std::vector<bool> taken(points.size(), false);
    for (Vec2 p : points) {
      const size_t cell = size_t(p.x * float(1 << a)) << (k - a) | size_t(p.y * float(1 << (k - a)));
      if (taken[cell]) return false;
      taken[cell] = true;
    }
  }
  return true;
}

std::vector<Vec2> pairs_of(uint32_t seed, uint32_t unit, uint32_t dimension, uint32_t first, uint32_t count) {
  Sampler sampler(Sampler::Kind::Sobol, seed);
  std::vector<Vec2> points;
  for (uint32_t i = first; i < first + count; ++i) {
    sampler.start(unit, i);
    sampler.set_dimension(dimension);
    points.push_back(sampler.get_2d());
  }
  return points;
}

TEST(Sampler, every_pair_is_a_02_sequence) {
  for (uint32_t seed : kSeeds)
    for (uint32_t unit : {0u, 1u, 640u * 480u})
      for (uint32_t dimension : {0u, 2u, 3u, 100u})
        for (int k = 0; k <= 12; ++k) {
          const uint32_t n = 1u << k;
          for (uint32_t block : {0u, 1u, 5u})  // not only the first aligned block
            EXPECT_TRUE(is_net(pairs_of(seed, unit, dimension, block * n, n), k))
                << "seed " << seed << " unit " << unit << " dimension " << dimension << " block " << block << " of 2^"
                << k;
        }
}

// A (1,3)-net: of 2^k points, every box of volume 2^(1 - k), in all shapes, contains exactly two. Its first two numbers
// are a (0,2)-net.
TEST(Sampler, every_triple_is_a_13_sequence) {
  for (uint32_t seed : kSeeds)
    for (uint32_t dimension : {0u, 3u, 100u})
      for (int k = 1; k <= 10; ++k)
        for (uint32_t block : {0u, 1u, 5u}) {
          const uint32_t n = 1u << k;
          Sampler sampler(Sampler::Kind::Sobol, seed);
          std::vector<Vec3> points;
          std::vector<Vec2> pairs;
          for (uint32_t i = block * n; i < (block + 1) * n; ++i) {
            sampler.start(640u * 480u, i);
            sampler.set_dimension(dimension);
            points.push_back(sampler.get_3d());
            pairs.emplace_back(points.back());
          }
          EXPECT_TRUE(is_net(pairs, k));
          for (int a = 0; a < k; ++a)
            for (int b = 0; a + b < k; ++b) {
              const int c = k - 1 - a - b;
              std::vector<int> count(size_t(n / 2), 0);
              for (Vec3 p : points)
                ++count[(size_t(p.x * float(1 << a)) << b | size_t(p.y * float(1 << b))) << c |
                        size_t(p.z * float(1 << c))];
              EXPECT_EQ(std::count(count.begin(), count.end(), 2), n / 2)
                  << "seed " << seed << " dimension " << dimension << " block " << block << " of 2^" << k << ", shape "
                  << a << " " << b << " " << c;
            }
        }
}

TEST(Sampler, single_numbers_are_stratified) {
  for (uint32_t seed : kSeeds)
    for (uint32_t dimension : {0u, 1u, 7u})
      for (int k = 0; k <= 12; ++k) {
        Sampler sampler(Sampler::Kind::Sobol, seed);
        std::vector<bool> taken(size_t(1) << k, false);
        for (uint32_t i = 0; i < (1u << k); ++i) {
          sampler.start(3, i);
          sampler.set_dimension(dimension);
          const size_t cell = size_t(sampler.get_1d() * float(1 << k));
          EXPECT_FALSE(taken[cell]);
          taken[cell] = true;
        }
      }
}

TEST(Sampler, numbers_are_below_one_and_have_uniform_moments) {
  for (auto kind : {Sampler::Kind::Sobol, Sampler::Kind::Independent}) {
    Sampler sampler(kind, 9);
    RunningMoments moments;
    for (uint32_t i = 0; i < 4096; ++i) {
      sampler.start(17, i);
      for (int d = 0; d < 16; ++d) {
        const Vec2 u = sampler.get_2d();
        const float v = sampler.get_1d();
        ASSERT_TRUE(u.x >= 0.0f && u.x < 1.0f && u.y >= 0.0f && u.y < 1.0f && v >= 0.0f && v < 1.0f);
        moments.add(v);
      }
    }
    EXPECT_NEAR(moments.mean(), 0.5, 0.01);
    EXPECT_NEAR(moments.variance(), 1.0 / 12.0, 0.005);
  }
}

/// The p-value of a chi-square test on an 8 x 8 grid that pairs of numbers are uniform over many units.
double pair_p_value(const std::function<Vec2(uint32_t)>& pair_of) {
  const uint32_t count = 1u << 16;
  std::vector<int> counts(64, 0);
  for (uint32_t i = 0; i < count; ++i) {
    const Vec2 u = pair_of(i);
    ++counts[size_t(u.x * 8.0f) * 8 + size_t(u.y * 8.0f)];
  }
  double statistic = 0.0;
  for (int c : counts) statistic += (c - count / 64.0) * (c - count / 64.0) / (count / 64.0);
  return chi_square_p_value(statistic, 63.0);
}

TEST(Sampler, dimensions_are_independent_over_pixels) {
  // Samples 0, 1 and 6 of every pixel, with dimensions of different pairs and of one pair.
  const double threshold = sidak_threshold(0.01, 24);
  for (auto kind : {Sampler::Kind::Sobol, Sampler::Kind::Independent})
    for (uint32_t index : {0u, 1u, 6u})
      for (uint32_t other : {2u, 4u, 40u, 1u}) {
        const double p = pair_p_value([&](uint32_t unit) {
          Sampler sampler(kind, 5);
          sampler.start(unit, index);
          if (other == 1u) return sampler.get_2d();
          const float x = sampler.get_2d().x;
          for (uint32_t d = 2; d < other; d += 2) sampler.get_2d();
          return Vec2(x, sampler.get_2d().y);
        });
        EXPECT_GT(p, threshold) << index << " " << other;
      }
}

TEST(Sampler, neighbouring_pixels_and_seeds_are_independent) {
  const double threshold = sidak_threshold(0.01, 8);
  for (uint32_t step : {1u, 2u, 640u, 65536u})
    for (bool seeds : {false, true}) {
      const double p = pair_p_value([&](uint32_t i) {
        Sampler a(Sampler::Kind::Sobol, seeds ? i : 0u), b(Sampler::Kind::Sobol, seeds ? i + step : 0u);
        a.start(seeds ? 0u : i, 3);
        b.start(seeds ? 0u : i + step, 3);
        return Vec2(a.get_1d(), b.get_1d());
      });
      EXPECT_GT(p, threshold) << step << (seeds ? " seeds" : " pixels");
    }
}

TEST(Sampler, samples_of_different_pairs_are_uncorrelated) {
  // The correlation of numbers of two pairs over 2^14 samples of one pixel.
  for (uint32_t other = 2; other <= 32; other += 2) {
    double sum = 0.0;
    const uint32_t count = 1u << 14;
    Sampler sampler(Sampler::Kind::Sobol, 11);
    for (uint32_t i = 0; i < count; ++i) {
      sampler.start(99, i);
      const float x = sampler.get_2d().x - 0.5f;
      sampler.set_dimension(other);
      sum += double(x) * (sampler.get_2d().x - 0.5f) * 12.0;
    }
    EXPECT_LT(std::abs(sum / count), 5.0 / std::sqrt(double(count))) << other;
  }
}

TEST(Sampler, means_over_pixels_are_unbiased_and_have_less_variance_than_independent_samples) {
  // The area of a disk, from 16 samples per pixel.
  RunningMoments sobol, independent;
  for (auto kind : {Sampler::Kind::Sobol, Sampler::Kind::Independent})
    for (uint32_t unit = 0; unit < 20000; ++unit) {
      Sampler sampler(kind, 1);
      int inside = 0;
      for (uint32_t i = 0; i < 16; ++i) {
        sampler.start(unit, i);
        const Vec2 u = sampler.get_2d() * 2.0f - 1.0f;
        inside += glm::dot(u, u) < 1.0f;
      }
      (kind == Sampler::Kind::Sobol ? sobol : independent).add(inside / 16.0);
    }
  EXPECT_TRUE(mean_agrees(sobol, M_PI / 4.0, {.test_count = 2}));
  EXPECT_TRUE(mean_agrees(independent, M_PI / 4.0, {.test_count = 2}));
  EXPECT_LT(sobol.variance(), 0.45 * independent.variance());
}

TEST(Sampler, restarts_repeat_the_same_numbers) {
  for (auto kind : {Sampler::Kind::Sobol, Sampler::Kind::Independent}) {
    Sampler a(kind, 7), b(kind, 7);
    a.start(1, 1);
    a.get_2d();
    for (uint32_t i : {5u, 0u, 1000000u}) {
      a.start(12, i);
      b.start(12, i);
      for (int d = 0; d < 8; ++d) {
        EXPECT_EQ(a.get_1d(), b.get_1d());
        EXPECT_EQ(a.get_2d(), b.get_2d());
      }
    }
  }
}

}  // namespace

}  // namespace ajar::test_sampler
