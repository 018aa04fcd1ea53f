// Maps from the unit square to the domains that a renderer samples, each with its density. The name of a density states
// its measure; zero means "cannot be sampled". The tests are chi-square, integration and the Jacobian of the map.
#pragma once

#include <algorithm>

#include "math/types.h"

namespace ajar::warp {

/// Concentric map onto the unit disk (Shirley and Chiu 1997).
inline Vec2 square_to_disk(Vec2 u) {
  const float x = 2.0f * u.x - 1.0f, y = 2.0f * u.y - 1.0f;
  if (x == 0.0f && y == 0.0f) return Vec2(0.0f);
  float r, phi;
  if (std::abs(x) > std::abs(y)) {
    r = x;
    phi = (kPi / 4.0f) * (y / x);
  } else {
    r = y;
    phi = (kPi / 2.0f) - (kPi / 4.0f) * (x / y);
  }
  return r * Vec2(std::cos(phi), std::sin(phi));
}
inline float disk_pdf_area() { return kInvPi; }

inline Vec3 square_to_cosine_hemisphere(Vec2 u) {
  const Vec2 d = square_to_disk(u);
  return {d.x, d.y, safe_sqrt(1.0f - d.x * d.x - d.y * d.y)};
}
inline float cosine_hemisphere_pdf_solid_angle(float cos_theta) { return cos_theta > 0.0f ? cos_theta * kInvPi : 0.0f; }

inline Vec3 square_to_sphere(Vec2 u) {
  const float z = 1.0f - 2.0f * u.x;
  const float r = safe_sqrt(1.0f - z * z), phi = 2.0f * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}
inline float sphere_pdf_solid_angle() { return 0.25f * kInvPi; }

inline Vec3 square_to_hemisphere(Vec2 u) {
  const float z = 1.0f - u.x;
  const float r = safe_sqrt(1.0f - z * z), phi = 2.0f * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}
inline float hemisphere_pdf_solid_angle() { return 0.5f * kInvPi; }

/// Uniform in solid angle inside the cone around +z. `one_minus_cos` is 1 - cos(half-angle), which does not cancel for
/// small cones.
inline Vec3 square_to_cone(Vec2 u, float one_minus_cos) {
  const float h = u.x * one_minus_cos;  // 1 - cos theta
  const float r = safe_sqrt(h * (2.0f - h)), phi = 2.0f * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1.0f - h};
}
inline float cone_pdf_solid_angle(float one_minus_cos) {
  return one_minus_cos > 0.0f ? 0.5f * kInvPi / one_minus_cos : 0.0f;
}
/// 1 - cos(angle) without cancellation.
inline float one_minus_cos(float angle) { return 2.0f * sqr(std::sin(0.5f * angle)); }

/// Barycentric coordinates (b1, b2) uniform over a triangle (Heitz 2019, low distortion).
inline Vec2 square_to_triangle(Vec2 u) {
  if (u.y > u.x) {
    const float b1 = 0.5f * u.x;
    return {b1, u.y - b1};
  }
  const float b2 = 0.5f * u.y;
  return {u.x - b2, b2};
}
inline float triangle_pdf_barycentric() { return 2.0f; }

}  // namespace ajar::warp
