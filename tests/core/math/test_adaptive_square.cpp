#include "math/adaptive_square.h"

#include "statistical.h"

namespace ajar::test_adaptive_square {

using namespace statistical;

namespace {

/// A narrow cluster, a wide one, and one point far from both.
AdaptiveSquare learned() {
  Pcg32 rng(3);
  std::vector<AdaptiveSquare::Point> points;
  for (int i = 0; i < 2000; ++i)
    points.push_back({Vec2(0.501f, 0.3f) + 0.004f * Vec2(rng.next_float(), rng.next_float()), 1.0f});
  for (int i = 0; i < 500; ++i)
    points.push_back({Vec2(0.1f, 0.6f) + 0.3f * Vec2(rng.next_float(), rng.next_float()), 2.0f});
  points.push_back({Vec2(0.9f, 0.9f), 5.0f});
  return AdaptiveSquare(std::move(points));
}

}  // namespace

TEST(AdaptiveSquare, samples_have_their_density) {
  const AdaptiveSquare square = learned();
  const auto density = [&](Vec3 p) { return double(square.density(Vec2(p))); };
  const DensityTest test{.domain = SampleDomain::Square};
  const auto sample = from_square([&](Vec2 u) { return std::optional(Vec3(square.sample(u), 0.0f)); });
  EXPECT_TRUE(chi_square_agrees(sample, density, test));
  EXPECT_TRUE(integral_agrees(sample, density, 1.0, test));
}

TEST(AdaptiveSquare, density_follows_the_points_and_falls_with_the_distance_from_them) {
  const AdaptiveSquare square = learned();
  const float inside = square.density(Vec2(0.503f, 0.302f)), wide = square.density(Vec2(0.25f, 0.75f));
  EXPECT_GT(inside, 4000.0f);  // two thirds of the weight in 1.6e-5 of the area: 40,000
  EXPECT_GT(wide, 2.0f);
  // On both sides of the edge between the halves of the square.
  const float near_right = square.density(Vec2(0.52f, 0.302f)), near_left = square.density(Vec2(0.48f, 0.302f)),
              far = square.density(Vec2(0.7f, 0.1f));
  EXPECT_GT(near_right, 3.0f * far);
  EXPECT_GT(near_left, 3.0f * far);
  EXPECT_GT(far, 0.0f);
}

TEST(AdaptiveSquare, points_outside_and_without_weight_are_left_out) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(AdaptiveSquare({{Vec2(1.5f, 0.5f), 1.0f},
                              {Vec2(nan, 0.5f), 1.0f},
                              {Vec2(0.5f), 0.0f},
                              {Vec2(0.5f), -1.0f},
                              {Vec2(0.5f), nan}})
                  .empty());
  const AdaptiveSquare one({{Vec2(0.25f), 1.0f}});
  EXPECT_FALSE(one.empty());
  EXPECT_EQ(one.density(Vec2(1.0f, 0.5f)), 0.0f);
  EXPECT_EQ(one.density(Vec2(-0.1f, 0.5f)), 0.0f);
  EXPECT_GT(one.density(Vec2(0.9f)), 0.0f);
}

}  // namespace ajar::test_adaptive_square
