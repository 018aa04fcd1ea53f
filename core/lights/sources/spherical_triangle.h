// Uniform sampling of the solid angle of a triangle seen from a point.
//
// Sources: Arvo 1995, "Stratified Sampling of Spherical Triangles". The solid angle follows van Oosterom and Strackee
// 1983, which does not cancel for small triangles. Below kMinSolidAngle, the caller samples the area, which is as good
// and cheaper.
#pragma once

#include <algorithm>

#include "math/types.h"

namespace ajar {

class SphericalTriangle {
 public:
  static constexpr float kMinSolidAngle = 5e-3f;

  /// Vertices relative to the point that sees them.
  SphericalTriangle(Vec3 a, Vec3 b, Vec3 c) : a_(glm::normalize(a)), b_(glm::normalize(b)), c_(glm::normalize(c)) {
    const float volume = std::abs(glm::dot(a_, glm::cross(b_, c_)));
    const float solid_angle = 2.0f * std::atan2(volume, 1.0f + glm::dot(a_, b_) + glm::dot(b_, c_) + glm::dot(c_, a_));
    solid_angle_ = std::isfinite(solid_angle) ? solid_angle : 0.0f;
  }

  float solid_angle() const { return solid_angle_; }
  bool usable() const { return solid_angle_ >= kMinSolidAngle; }

  /// Direction uniform in the triangle; can be non-finite at degenerate corners.
  Vec3 sample(Vec2 u) const {
    // Angle at a between the planes ab and ac.
    const Vec3 n_ab = glm::normalize(glm::cross(a_, b_)), n_ac = glm::normalize(glm::cross(a_, c_));
    const float cos_alpha = glm::dot(n_ab, n_ac), sin_alpha = glm::length(glm::cross(n_ab, n_ac));
    const float alpha = std::atan2(sin_alpha, cos_alpha);
    // The triangle a, b, c' of area u.x * solid angle.
    const float phi = u.x * solid_angle_ - alpha, s = std::sin(phi), t = std::cos(phi);
    const float x = t - cos_alpha, y = s + sin_alpha * glm::dot(a_, b_);
    const float q = std::clamp(((y * t - x * s) * cos_alpha - y) / ((y * s + x * t) * sin_alpha), -1.0f, 1.0f);
    const Vec3 c = q * a_ + safe_sqrt(1.0f - q * q) * glm::normalize(c_ - glm::dot(c_, a_) * a_);
    // A point of the arc from b to c', uniform in 1 - cos of its distance from b.
    const float z = 1.0f - u.y * (1.0f - glm::dot(c, b_));
    return glm::normalize(z * b_ + safe_sqrt((1.0f - z) * (1.0f + z)) * glm::normalize(c - glm::dot(c, b_) * b_));
  }

 private:
  Vec3 a_, b_, c_;
  float solid_angle_;
};

}  // namespace ajar
