// The hypothesis tests of statistical.h must accept correct densities and refuse slightly wrong ones.
#include "statistical.h"

#include "math/warps.h"

namespace ajar::test_statistical {

namespace {

using namespace statistical;

TEST(Statistical, distribution_functions_match_tables) {
  EXPECT_NEAR(chi_square_p_value(18.307, 10), 0.05, 1e-5);
  EXPECT_NEAR(chi_square_p_value(2.0, 10), 0.99634, 1e-5);
  EXPECT_NEAR(student_p_value(2.228, 10), 0.05, 1e-4);
  EXPECT_NEAR(student_p_value(0.5, 3), 0.6514, 1e-4);
  EXPECT_NEAR(sidak_threshold(0.05, 2), 0.025321, 1e-6);
}

Sample cone(float one_minus_cos) {
  return from_square([=](Vec2 u) { return std::optional(warp::square_to_cone(u, one_minus_cos)); });
}
Density cone_density(float one_minus_cos, float factor) {
  // Near the pole, z has a rounding error and the sine has none.
  return [=](Vec3 w) {
    const float h = w.z > 0.0f ? (w.x * w.x + w.y * w.y) / (1.0f + w.z) : 1.0f - w.z;
    return h <= one_minus_cos * 1.00001f ? factor * warp::cone_pdf_solid_angle(one_minus_cos) : 0.0f;
  };
}

TEST(Statistical, chi_square_accepts_the_correct_density_and_refuses_slightly_wrong_ones) {
  for (float size : {1.5f, 0.1f, 1e-4f, 1e-8f}) {
    DensityTest test{.level = {.test_count = 4}};
    EXPECT_TRUE(chi_square_agrees(cone(size), cone_density(size, 1.0f), test)) << size;
    EXPECT_FALSE(chi_square_agrees(cone(size), cone_density(size, 1.03f), test)) << size;
    EXPECT_FALSE(chi_square_agrees(cone(size), cone_density(size, 0.97f), test)) << size;
    EXPECT_FALSE(chi_square_agrees(cone(size * 0.98f), cone_density(size, 1.0f), test)) << size;
  }
}

TEST(Statistical, chi_square_counts_refused_samples_as_missing_mass) {
  const Sample half = from_square([](Vec2 u) -> std::optional<Vec3> {
    const Vec3 w = warp::square_to_sphere(u);
    if (w.z < 0.0f) return std::nullopt;
    return w;
  });
  const Density density = [](Vec3 w) { return w.z >= 0.0f ? warp::sphere_pdf_solid_angle() : 0.0f; };
  EXPECT_TRUE(chi_square_agrees(half, density, {}));
  EXPECT_FALSE(chi_square_agrees(half, [&](Vec3 w) { return 2.0 * density(w); }, {}));
}

TEST(Statistical, jacobian_refuses_a_wrong_measure) {
  const Map map = [](Vec2 u) { return std::optional(warp::square_to_cosine_hemisphere(u)); };
  EXPECT_TRUE(jacobian_agrees(map, [](Vec3 w) { return w.z * kInvPi; }));
  EXPECT_FALSE(jacobian_agrees(map, [](Vec3) { return kInvPi; }));
}

TEST(Statistical, t_tests_separate_different_means) {
  Pcg32 rng(7);
  RunningMoments a, b, c;
  for (int i = 0; i < 20000; ++i) {
    a.add(rng.next_float());
    b.add(0.5 + 3.0 * (rng.next_float() - 0.5));
    c.add(rng.next_float() + 0.02);
  }
  EXPECT_TRUE(means_agree(a, b));
  EXPECT_FALSE(means_agree(a, c));
  EXPECT_TRUE(mean_agrees(a, 0.5));
  EXPECT_FALSE(mean_agrees(c, 0.5));
}

}  // namespace

}  // namespace ajar::test_statistical
