#include "shading/models/fresnel.h"

#include <gtest/gtest.h>

namespace ajar::test_fresnel {

TEST(Fresnel, values_at_normal_incidence_brewsters_angle_and_beyond_the_critical_angle_are_correct) {
  EXPECT_NEAR(fresnel::dielectric(1.0f, 1.5f), 0.04f, 1e-6f);
  EXPECT_NEAR(fresnel::f0_from_eta(1.5f), 0.04f, 1e-6f);
  EXPECT_NEAR(fresnel::eta_from_f0(0.04f), 1.5f, 1e-5f);
  // At Brewster's angle only the perpendicular component is reflected: half of ((eta^2 - 1) / (eta^2 + 1))^2.
  EXPECT_NEAR(fresnel::dielectric(1.0f / std::sqrt(1.0f + 2.25f), 1.5f), 0.5f * sqr(1.25f / 3.25f), 1e-6f);
  EXPECT_EQ(fresnel::dielectric(0.7f, 1.0f / 1.5f), 1.0f);
  EXPECT_NEAR(fresnel::dielectric(0.0f, 1.5f), 1.0f, 1e-6f);
  EXPECT_NEAR(fresnel::dielectric(0.3f, 1.0f), 0.0f, 1e-12f);
}

TEST(Fresnel, extreme_indices_reflect_everything) {
  for (const float eta : {1e10f, 1e15f, 1e20f, 1e30f, 1e-20f, 0.0f})
    for (const float cosine : {0.0f, 0.5f, 1.0f}) EXPECT_NEAR(fresnel::dielectric(cosine, eta), 1.0f, 1e-5f) << eta;
}

TEST(Fresnel, both_sides_of_a_boundary_have_the_same_reflectance) {
  for (float eta : {1.1f, 1.5f, 2.4f})
    for (float c = 0.05f; c <= 1.0f; c += 0.05f) {
      const float cos_t = std::sqrt(1.0f - (1.0f - c * c) / (eta * eta));
      EXPECT_NEAR(fresnel::dielectric(c, eta), fresnel::dielectric(cos_t, 1.0f / eta), 2e-5f);
    }
}

TEST(Fresnel, refracted_directions_obey_snell_in_the_plane_of_incidence) {
  const Vec3 m = glm::normalize(Vec3(0.2f, -0.1f, 0.9f)), w = glm::normalize(Vec3(0.5f, 0.4f, 0.7f));
  for (float eta : {0.9f, 1.33f, 2.0f}) {
    Vec3 t;
    ASSERT_TRUE(fresnel::refract(w, m, eta, t));
    EXPECT_NEAR(glm::length(t), 1.0f, 1e-6f);
    EXPECT_NEAR(glm::length(glm::cross(w, m)), eta * glm::length(glm::cross(t, m)), 1e-5f);
    EXPECT_NEAR(glm::dot(glm::cross(w, m), t), 0.0f, 1e-6f);
    EXPECT_LT(glm::dot(t, m), 0.0f);
  }
  Vec3 t;
  EXPECT_FALSE(fresnel::refract(w, m, 0.5f, t));
}

TEST(Fresnel, mean_is_the_cosine_weighted_integral) {
  for (float eta : {1.0f / 2.0f, 1.0f / 1.33f, 1.1f, 1.5f, 2.5f}) {
    double sum = 0.0;
    constexpr int kSteps = 2000;
    for (int i = 0; i < kSteps; ++i) {
      const double c = (i + 0.5) / kSteps;
      sum += 2.0 * c * fresnel::dielectric(float(c), eta) / kSteps;
    }
    EXPECT_NEAR(fresnel::dielectric_mean(eta), sum, 0.006) << eta;
  }
}

TEST(Fresnel, f82_passes_through_its_two_colours) {
  const Color f0(0.9f, 0.5f, 0.2f), tint(0.7f, 0.8f, 1.0f), b = fresnel::f82_coefficient(f0, tint);
  const Color normal = fresnel::f82(1.0f, f0, b), edge = fresnel::f82(1.0f / 7.0f, f0, b),
              grazing = fresnel::f82(0.0f, f0, b);
  const float m5 = std::pow(6.0f / 7.0f, 5.0f);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(normal[i], f0[i], 1e-6f);
    EXPECT_NEAR(edge[i], tint[i] * (f0[i] + (1.0f - f0[i]) * m5), 1e-5f);
    EXPECT_NEAR(grazing[i], 1.0f, 1e-6f);
  }
}

}  // namespace ajar::test_fresnel
