// Uniform sampling of the solid angle of a rectangle seen from a point.
//
// Problem and two-step scheme: Ureña, Fajardo, King 2013, "An Area-Preserving Parametrization for Spherical
// Rectangles". First a column of the rectangle is drawn, then a point in it. The inversion for the column is derived
// here from quadrants.
//
// Frame: the point is the origin, the plane of the rectangle is at distance h, and (x, y) are the coordinates in the
// plane, measured from the foot of the perpendicular. beta(y) = atan(y / h) is the angle of a row.
//
// The quadrant [0, x] x [0, y] has the signed solid angle Q(x, y) = atan(x y / (h sqrt(x^2 + y^2 + h^2))), for which
// sin Q = sin(atan(x / h)) sin(beta(y)). The strip [0, x] x [y0, y1] therefore has
//   T(x) = Q(x, y1) - Q(x, y0).
// Solved for x, with D = beta(y1) - beta(y0) and S = beta(y1) + beta(y0), this is
//   x = h sin T / sqrt((cos T - cos D) (cos T + cos S))
//     = h sin(T/2) cos(T/2) / sqrt((sin^2(D/2) - sin^2(T/2)) (cos^2(T/2) - sin^2(S/2))).
// T is drawn uniformly between T(x0) and T(x1). In a column, solid angle is proportional to the sine of the elevation
// (Archimedes).
//
// Below kMinSolidAngle, floats do not resolve the map, and the caller samples the area instead.
#pragma once

#include <algorithm>
#include <cmath>

#include "math/types.h"

namespace ajar {

class SphericalRectangle {
 public:
  static constexpr float kMinSolidAngle = 1e-3f;

  /// Rectangle `corner` + [0, length_x] x + [0, length_y] y, seen from p; x and y orthonormal.
  SphericalRectangle(Vec3 p, Vec3 corner, Vec3 x, Vec3 y, float length_x, float length_y) : axis_x_(x), axis_y_(y) {
    const Vec3 normal = glm::cross(x, y), to_corner = corner - p;
    const float side = glm::dot(to_corner, normal);
    height_ = std::abs(side);
    foot_ = side * normal;
    left_ = glm::dot(to_corner, x);
    right_ = left_ + length_x;
    bottom_ = glm::dot(to_corner, y);
    top_ = bottom_ + length_y;
    // Nothing is visible from a point in the plane, or so near it that h^2 underflows.
    if (!(sqr(height_) > 0.0f)) return;
    strip_left_ = quadrant(left_, top_) - quadrant(left_, bottom_);
    solid_angle_ = std::max(quadrant(right_, top_) - quadrant(right_, bottom_) - strip_left_, 0.0f);
    if (!usable()) return;
    const float h2 = sqr(height_), scale = 1.0f / std::sqrt((h2 + sqr(bottom_)) * (h2 + sqr(top_)));
    half_difference_sin2_ = half_angle_sin2((h2 + bottom_ * top_) * scale, height_ * length_y * scale);
    half_sum_sin2_ = half_angle_sin2((h2 - bottom_ * top_) * scale, height_ * (bottom_ + top_) * scale);
  }

  float solid_angle() const { return solid_angle_; }
  bool usable() const { return solid_angle_ >= kMinSolidAngle; }

  /// Vector from p to a point of the rectangle, uniform in solid angle.
  Vec3 sample(Vec2 u) const {
    const float x = column(strip_left_ + u.x * solid_angle_);
    const float distance2 = sqr(x) + sqr(height_);
    const float sin_bottom = bottom_ / std::sqrt(distance2 + sqr(bottom_)),
                sin_top = top_ / std::sqrt(distance2 + sqr(top_));
    const float sin_elevation = sin_bottom + u.y * (sin_top - sin_bottom);
    const float y = sin_elevation *
                    std::sqrt(distance2 / std::max((1.0f - sin_elevation) * (1.0f + sin_elevation), kTiny));
    return foot_ + x * axis_x_ + std::clamp(y, bottom_, top_) * axis_y_;
  }

 private:
  static constexpr float kTiny = 1e-20f;

  /// Q(x, y).
  float quadrant(float x, float y) const {
    return std::atan(x * y / (height_ * std::sqrt(sqr(x) + sqr(y) + sqr(height_))));
  }

  /// sin^2 of half of an angle; the first form keeps the digits of small angles.
  static float half_angle_sin2(float cosine, float sine) {
    return cosine > 0.0f ? 0.5f * sqr(sine) / (1.0f + cosine) : 0.5f * (1.0f - cosine);
  }

  /// The x at which the strip has the solid angle T.
  float column(float strip) const {
    const float s = std::sin(0.5f * strip), c = std::cos(0.5f * strip);
    const float product = (half_difference_sin2_ - s * s) * (c * c - half_sum_sin2_);
    return std::clamp(height_ * s * c / std::sqrt(std::max(product, kTiny)), left_, right_);
  }

  Vec3 axis_x_, axis_y_, foot_;
  float height_, left_, right_, bottom_, top_;
  float strip_left_ = 0.0f, solid_angle_ = 0.0f;
  float half_difference_sin2_ = 0.0f, half_sum_sin2_ = 0.0f;
};

}  // namespace ajar
