// Uniform sampling of the solid angle of a rectangle seen from a point.
//
// Source: Ureña, Fajardo, King 2013, "An Area-Preserving Parametrization for Spherical
// Rectangles". The internal angles are written as pi/2 + asin(...) so that the solid angle of a small rectangle is a
// sum of small numbers; below kMinSolidAngle floats no longer resolve the map and the caller samples the area instead.
#pragma once

#include <algorithm>

#include "math/types.h"

namespace ajar {

class SphericalRectangle {
 public:
  static constexpr float kMinSolidAngle = 1e-3f;

  /// Rectangle `corner` + [0, length_x] x + [0, length_y] y, seen from p; x and y orthonormal.
  SphericalRectangle(Vec3 p, Vec3 corner, Vec3 x, Vec3 y, float length_x, float length_y) : x_(x), y_(y), z_(glm::cross(x, y)) {
    const Vec3 d = corner - p;
    z0_ = glm::dot(d, z_);
    if (z0_ > 0.0f) {
      z_ = -z_;
      z0_ = -z0_;
    }
    x0_ = glm::dot(d, x);
    y0_ = glm::dot(d, y);
    x1_ = x0_ + length_x;
    y1_ = y0_ + length_y;
    const float z2 = z0_ * z0_;
    // z components of the normals of the four edge planes.
    const float n0 = -y0_ / std::sqrt(z2 + y0_ * y0_), n1 = x1_ / std::sqrt(z2 + x1_ * x1_);
    const float n2 = y1_ / std::sqrt(z2 + y1_ * y1_), n3 = -x0_ / std::sqrt(z2 + x0_ * x0_);
    const auto arc = [](float s) { return std::asin(std::clamp(s, -1.0f, 1.0f)); };
    const float a0 = arc(n0 * n1), a1 = arc(n1 * n2), a2 = arc(n2 * n3), a3 = arc(n3 * n0);
    b0_ = n0;
    b1_ = n2;
    offset_ = a2 + a3;
    solid_angle_ = a0 + a1 + a2 + a3;
    // The plane of the rectangle, seen edge on: nothing is visible, and 0/0 above.
    if (!(z0_ < 0.0f) || !(solid_angle_ > 0.0f)) solid_angle_ = 0.0f;
  }

  float solid_angle() const { return solid_angle_; }
  bool usable() const { return solid_angle_ >= kMinSolidAngle; }

  /// Vector from p to a point of the rectangle, uniform in solid angle.
  Vec3 sample(Vec2 u) const {
    // With au = pi + tau of the paper, tau = u S - asin(..) - asin(..).
    const float tau = u.x * solid_angle_ - offset_;
    const float fu = (std::cos(tau) * b0_ + b1_) / std::sin(tau);
    const float cu = std::clamp(std::copysign(1.0f / std::sqrt(fu * fu + b0_ * b0_), fu), -1.0f, 1.0f);
    const float xu = std::clamp(-(cu * z0_) / std::max(safe_sqrt(1.0f - cu * cu), 1e-7f), x0_, x1_);
    const float d2 = xu * xu + z0_ * z0_;
    const float h0 = y0_ / std::sqrt(d2 + y0_ * y0_), h1 = y1_ / std::sqrt(d2 + y1_ * y1_);
    const float hv = h0 + u.y * (h1 - h0), hv2 = hv * hv;
    const float yv = hv2 < 1.0f - 1e-6f ? hv * std::sqrt(d2 / (1.0f - hv2)) : (hv > 0.0f ? y1_ : y0_);
    return xu * x_ + std::clamp(yv, y0_, y1_) * y_ + z0_ * z_;
  }

 private:
  Vec3 x_, y_, z_;
  float x0_, x1_, y0_, y1_, z0_;
  float b0_, b1_, offset_, solid_angle_;
};

}  // namespace ajar
