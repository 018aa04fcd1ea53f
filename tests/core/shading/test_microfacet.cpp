#include "shading/models/microfacet.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bsdf_fixtures.h"
#include "statistical.h"

namespace ajar::test_microfacet {

using namespace fixtures;
using namespace microfacet;
using namespace statistical;

namespace {

struct Distribution {
  const char* name;
  float (*density)(Vec3, float, float);
  float (*masking_over_cos)(Vec3, float, float);
  Vec3 (*sample_visible)(Vec3, float, float, Vec2);
};
const Distribution kVisible[] = {{"ggx", ggx_density, ggx_masking_over_cos, ggx_sample_visible},
                                 {"beckmann", beckmann_density, beckmann_masking_over_cos, beckmann_sample_visible}};
constexpr std::pair<float, float> kAlphas[] = {{0.01f, 0.01f}, {0.3f, 0.3f}, {1.0f, 1.0f}, {0.1f, 0.6f}};

}  // namespace

TEST(Microfacet, the_projected_area_of_the_facets_is_that_of_the_surface) {
  // The integral of G1(w) max(0, w.m) D(m) dm is cos(w), by quadrature over slopes (Heitz 2014, eq. 23). For w = z it
  // tests D alone.
  for (const auto& d : kVisible)
    for (const auto& [ax, ay] : kAlphas)
      for (float c : {1.0f, 0.5f, 0.1f}) {
        const Vec3 w = direction(c);
        double sum = 0.0;
        constexpr int kRadii = 2000, kAngles = 64;
        for (int i = 0; i < kRadii; ++i)
          for (int j = 0; j < kAngles; ++j) {
            // tan maps to the radius of the stretched slope on (0, inf). The area element of slopes is r dr dphi ax ay;
            // dm = cos^3 dslope.
            const double t = (i + 0.5) / kRadii * M_PI_2, r = std::tan(t), phi = 2.0 * M_PI * (j + 0.5) / kAngles;
            const double sx = ax * r * std::cos(phi), sy = ay * r * std::sin(phi),
                         length = std::sqrt(1.0 + sx * sx + sy * sy);
            const Vec3 m(float(-sx / length), float(-sy / length), float(1.0 / length));
            const double dm = r * ax * ay / (length * length * length) * (1.0 + r * r) * (M_PI_2 / kRadii) *
                              (2.0 * M_PI / kAngles);
            sum += std::max(0.0f, glm::dot(w, m)) * double(d.density(m, ax, ay)) * dm;
          }
        EXPECT_NEAR(sum * d.masking_over_cos(w, ax, ay), 1.0, 4e-3) << d.name << " " << ax << " " << ay << " " << c;
      }
}

TEST(Microfacet, visible_normals_are_sampled_with_their_density) {
  for (const auto& d : kVisible)
    for (const auto& [ax, ay] : {std::pair(0.3f, 0.3f), {0.1f, 0.6f}})
      for (float c : {0.95f, 0.3f, 0.02f}) {
        const Vec3 w = direction(c);
        const Density pdf = [&, ax = ax, ay = ay](Vec3 m) {
          return m.z > 0.0f
                     ? double(d.masking_over_cos(w, ax, ay)) * std::max(0.0f, glm::dot(w, m)) * d.density(m, ax, ay)
                     : 0.0;
        };
        const Map map = [&, ax = ax, ay = ay](Vec2 u) { return std::optional(d.sample_visible(w, ax, ay, u)); };
        DensityTest test;
        test.domain = SampleDomain::Hemisphere;
        test.sample_count = 40000;
        test.bin_count = 128;
        test.integral_tolerance = 0.01;
        test.level = {0.01, 24};
        EXPECT_TRUE(chi_square_agrees(from_square(map), pdf, test)) << d.name << " " << ax << " " << ay << " " << c;
        JacobianTest jacobian;
        jacobian.tolerance = 0.05;
        jacobian.smooth_fraction = 0.3;
        EXPECT_TRUE(jacobian_agrees(map, pdf, jacobian)) << d.name << " " << ax << " " << ay << " " << c;
      }
}

// At alpha = 1, the slope perpendicular to the direction of view has the density exp(-y^2) / sqrt(pi) for all
// directions of view, so that sampling inverts erf. Along a grazing direction of view, the visible slopes have the
// cumulative distribution of Heitz and d'Eon 2014.
TEST(Microfacet, slopes_of_beckmann_invert_their_cumulative_distributions) {
  const float c = 0.6f, s = 0.8f;
  const double cot = double(c) / double(s), k = 1.0 / (cot * std::sqrt(M_PI));
  const auto cumulative = [&](double x) { return 1.0 + std::erf(x) + k * std::exp(-x * x); };
  for (int i = 1; i < 2000; ++i) {
    const float u = float(i) / 2000.0f;
    const Vec3 m = beckmann_sample_visible(Vec3(s, 0.0f, c), 1.0f, 1.0f, Vec2(u, 1.0f - u));
    const double along = -double(m.x) / double(m.z), across = -double(m.y) / double(m.z);
    EXPECT_NEAR(std::erf(across), 1.0 - 2.0 * double(u), 4e-7) << u;
    EXPECT_NEAR(cumulative(along) / cumulative(cot), double(u), 2e-6) << u;
  }
  // At the ends, erf is flat; erfc is precise there.
  for (int exponent = 8; exponent <= 23; ++exponent) {
    const float v = 1.0f - std::ldexp(1.0f, -exponent);
    const Vec3 m = beckmann_sample_visible(Vec3(s, 0.0f, c), 1.0f, 1.0f, Vec2(0.5f, v));
    EXPECT_NEAR(std::erfc(-double(m.y) / double(m.z)) * std::ldexp(1.0, exponent - 1), 1.0, 2e-5) << exponent;
  }
}

TEST(Microfacet, distributions_of_all_normals_are_sampled_with_their_density) {
  const auto check = [](const Map& map, const Density& pdf, const std::string& what) {
    DensityTest test;
    test.domain = SampleDomain::Hemisphere;
    test.sample_count = 40000;
    test.bin_count = 128;
    test.integral_tolerance = 0.01;
    test.level = {0.01, 12};
    EXPECT_TRUE(chi_square_agrees(from_square(map), pdf, test)) << what;
    EXPECT_TRUE(jacobian_agrees(map, pdf, {.tolerance = 0.05, .smooth_fraction = 0.5})) << what;
  };
  for (float alpha : {0.02f, 0.3f, 0.9f})
    check([=](Vec2 u) { return std::optional(gtr1_sample(alpha, u)); },
          [=](Vec3 m) { return gtr1_density(m, alpha) * m.z; }, "gtr1 " + std::to_string(alpha));
  for (const auto& [ax, ay] : {std::pair(0.2f, 0.2f), {0.1f, 0.5f}, {1.0f, 1.0f}})
    check([ax = ax, ay = ay](Vec2 u) { return std::optional(ashikhmin_shirley_sample(ax, ay, u)); },
          [ax = ax, ay = ay](Vec3 m) { return ashikhmin_shirley_density(m, ax, ay); },
          "ashikhmin_shirley " + std::to_string(ax));
}

TEST(Microfacet, correlated_masking_masks_less_than_independent_masking) {
  for (float c : {0.9f, 0.3f, 0.05f}) {
    const Vec3 wo = direction(c), wi = direction(0.5f, 3.0f);
    const float independent = ggx_masking_over_cos(wo, 0.5f, 0.5f) * ggx_masking_over_cos(wi, 0.5f, 0.5f);
    const float correlated = ggx_correlated_over_cosines(wo, wi, 0.5f, 0.5f);
    EXPECT_GT(correlated, independent);
    EXPECT_LT(correlated * wo.z, ggx_masking_over_cos(wi, 0.5f, 0.5f) + 1e-6f);
  }
}

}  // namespace ajar::test_microfacet
