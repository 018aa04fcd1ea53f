#include "lights/sources/spherical_rectangle.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ajar::test_spherical_rectangle {

namespace {

/// Rectangles in the plane at `height` above the point. The origin of their coordinates is the foot of the
/// perpendicular.
struct Case {
  const char* name;
  double left, right, bottom, top, height;
};
constexpr Case kCases[] = {{"overhead", -1.0, 1.0, -1.0, 1.0, 1.0},     {"aside", 0.5, 2.0, -0.3, 1.0, 0.7},
                           {"far corner", -4.0, -2.0, 1.0, 4.0, 1.5},   {"near its plane", -1.0, 2.0, 0.2, 1.0, 0.05},
                           {"huge", -300.0, 200.0, -100.0, 500.0, 1.0}, {"small", 0.1, 0.16, 0.2, 0.25, 1.0},
                           {"narrow", -3.0, 3.0, 0.4, 0.42, 1.0},       {"under a corner", 0.0, 1.0, 0.0, 1.0, 0.5}};

/// Solid angle of [0, x] x [0, y] at this height.
double quadrant(double x, double y, double height) {
  return std::atan2(x * y, height * std::sqrt(x * x + y * y + height * height));
}
double solid_angle(double left, double right, double bottom, double top, double height) {
  return quadrant(right, top, height) - quadrant(left, top, height) - quadrant(right, bottom, height) +
         quadrant(left, bottom, height);
}

/// The rectangle on one side of its plane. Its axes are coordinate axes, so that the coordinates of a vector have no
/// additional rounding error.
struct Placed {
  Vec3 x{0.0f, 0.0f, 1.0f}, y{1.0f, 0.0f, 0.0f}, normal;
  SphericalRectangle rectangle;
  Placed(const Case& c, float side)
      : normal(0.0f, side, 0.0f),
        rectangle(Vec3(0.0f), float(c.height) * normal + float(c.left) * x + float(c.bottom) * y, x, y,
                  float(c.right - c.left), float(c.top - c.bottom)) {}
};

}  // namespace

TEST(SphericalRectangle, solid_angle_is_the_sum_of_its_quadrants) {
  for (const Case& c : kCases)
    for (const float side : {1.0f, -1.0f}) {
      const double expected = solid_angle(c.left, c.right, c.bottom, c.top, c.height);
      EXPECT_NEAR(Placed(c, side).rectangle.solid_angle(), expected, 3e-6 + 1e-5 * expected) << c.name;
    }
  // From the centre of a cube, each face has a sixth of the sphere.
  EXPECT_NEAR(Placed(kCases[0], 1.0f).rectangle.solid_angle(), 2.0 * M_PI / 3.0, 1e-5);
}

// The map preserves area: the part of the rectangle to the left of the sample has the fraction u.x of the solid angle,
// and the sine of the elevation in its column is linear in u.y.
TEST(SphericalRectangle, samples_divide_the_solid_angle_in_proportion_to_their_random_numbers) {
  for (const Case& c : kCases)
    for (const float side : {1.0f, -1.0f}) {
      const Placed placed(c, side);
      ASSERT_TRUE(placed.rectangle.usable()) << c.name;
      const double whole = solid_angle(c.left, c.right, c.bottom, c.top, c.height);
      for (int i = 0; i <= 16; ++i)
        for (int j = 0; j <= 16; ++j) {
          const Vec2 u(float(i) / 16.0f, float(j) / 16.0f);
          const Vec3 v = placed.rectangle.sample(u);
          const double x = glm::dot(v, placed.x), y = glm::dot(v, placed.y), h = glm::dot(v, placed.normal);
          const double size = 1e-5 *
                              (std::abs(c.left) + std::abs(c.right) + std::abs(c.bottom) + std::abs(c.top) + c.height);
          EXPECT_NEAR(h, c.height, size) << c.name;
          EXPECT_GE(x, c.left - size);
          EXPECT_LE(x, c.right + size);
          EXPECT_GE(y, c.bottom - size);
          EXPECT_LE(y, c.top + size);
          // The errors are absolute, in steradians, since the relative error of floats is larger for small rectangles.
          EXPECT_NEAR(solid_angle(c.left, x, c.bottom, c.top, c.height), u.x * whole, 1e-5)
              << c.name << " at " << u.x << ", " << u.y;
          const auto sine = [&](double at) { return at / std::sqrt(x * x + at * at + c.height * c.height); };
          EXPECT_NEAR(sine(y), sine(c.bottom) + u.y * (sine(c.top) - sine(c.bottom)), 1e-5)
              << c.name << " at " << u.x << ", " << u.y;
        }
    }
}

TEST(SphericalRectangle, a_rectangle_is_invisible_from_its_plane) {
  const SphericalRectangle rectangle(Vec3(0), Vec3(1, 1, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), 2.0f, 3.0f);
  EXPECT_EQ(rectangle.solid_angle(), 0.0f);
  EXPECT_FALSE(rectangle.usable());
}

}  // namespace ajar::test_spherical_rectangle
