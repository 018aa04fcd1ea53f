// The basis around a normal is orthonormal and right-handed. It is the same for normals that differ by rounding only.
#include <gtest/gtest.h>

#include <cmath>

#include "math/frame.h"
#include "math/random.h"
#include "math/warps.h"

namespace ajar::test_frame {

namespace {

void expect_basis(const Frame& f, Vec3 normal) {
  EXPECT_EQ(f.n, normal);
  for (const Vec3 axis : {f.s, f.t}) {
    EXPECT_NEAR(glm::length(axis), 1.0f, 1e-6f);
    EXPECT_NEAR(glm::dot(axis, normal), 0.0f, 1e-6f);
  }
  EXPECT_NEAR(glm::dot(f.s, f.t), 0.0f, 1e-6f);
  EXPECT_NEAR(glm::dot(glm::cross(f.s, f.t), f.n), 1.0f, 1e-6f);
}

TEST(Frame, is_orthonormal_and_right_handed_around_every_normal) {
  for (const float z :
       {0.0f, -0.0f, 1e-30f, -1e-30f, 1e-8f, -1e-8f, -0.59f, -0.6f, -0.60000002f, -0.61f, 1.0f, -1.0f}) {
    for (int i = 0; i < 64; ++i) {
      const float phi = float(i) * (kPi / 32.0f), r = safe_sqrt(1.0f - z * z);
      const Vec3 n(r * std::cos(phi), r * std::sin(phi), z);
      expect_basis(Frame(n), n);
    }
  }
  Pcg32 rng(1);
  for (int i = 0; i < 10000; ++i) {
    const Vec3 n = warp::square_to_sphere({rng.next_float(), rng.next_float()});
    expect_basis(Frame(n), n);
  }
}

/// The normals of upright walls have z = 0 up to rounding. Rounding must not rotate the frame, since sampled directions
/// would rotate with it.
TEST(Frame, of_upright_walls_does_not_depend_on_the_sign_of_zero) {
  for (int i = 0; i < 64; ++i) {
    const float phi = float(i) * (kPi / 32.0f);
    const Frame upright(Vec3(std::cos(phi), std::sin(phi), 0.0f));
    for (const float z : {-0.0f, 1e-8f, -1e-8f, 1e-6f, -1e-6f}) {
      const Frame askew(Vec3(std::cos(phi), std::sin(phi), z));
      EXPECT_LT(glm::length(askew.s - upright.s), 4e-6f) << phi << " " << z;
      EXPECT_LT(glm::length(askew.t - upright.t), 4e-6f) << phi << " " << z;
    }
  }
}

/// If the tangent is nearly the normal, its part perpendicular to the normal has few correct digits. The frame must
/// still be perpendicular to the normal.
TEST(Frame, along_a_tangent_is_orthonormal_for_tangents_near_the_normal_and_of_any_length) {
  Pcg32 rng(2);
  for (const float apart : {1.0f, 1e-2f, 1e-4f, 1e-5f, 2e-6f, 1e-7f, 0.0f}) {
    for (const float length : {1.0f, 1e-10f, 1e10f}) {
      for (int i = 0; i < 200; ++i) {
        const Vec3 n = glm::normalize(warp::square_to_sphere({rng.next_float(), rng.next_float()}));
        const Vec3 across = Frame(n).to_world(Vec3(warp::square_to_disk({rng.next_float(), rng.next_float()}), 0.0f));
        const Frame f(n, length * glm::normalize(n + apart * across));
        expect_basis(f, n);
        // s points along the tangent.
        if (apart == 1.0f && glm::length(across) > 0.1f) {
          EXPECT_GT(glm::dot(f.s, glm::normalize(across)), 0.9999f);
        }
      }
    }
  }
  expect_basis(Frame(Vec3(0, 0, 1), Vec3(0.0f)), Vec3(0, 0, 1));
}

}  // namespace

}  // namespace ajar::test_frame
