// Texture patterns, and projections from points to image coordinates. The definitions are Blender's, as in Cycles.
#pragma once

#include <cmath>

#include "math/types.h"
#include "shading/images/texture.h"

namespace ajar::nodes {

enum class GradientKind : uint8_t { Linear, Quadratic, Easing, Diagonal, Spherical, QuadraticSphere, Radial };
enum class EnvironmentProjection : uint8_t { Equirectangular, MirrorBall };

/// 1 in the cells of the first colour. The small offset keeps faces that lie on cell borders in one cell.
inline float checker(Vec3 p) {
  p = (p + 1e-6f) * 0.999999f;
  const auto odd = [](float x) { return std::fmod(std::abs(std::floor(x)), 2.0f) == 1.0f; };
  return (odd(p.x) == odd(p.y)) == odd(p.z) ? 1.0f : 0.0f;
}

inline float gradient(GradientKind kind, Vec3 p) {
  const auto sphere = [&] { return std::max(0.999999f - std::sqrt(length_squared(p)), 0.0f); };
  float f = 0.0f;
  switch (kind) {
    case GradientKind::Linear: f = p.x; break;
    case GradientKind::Quadratic: f = sqr(std::max(p.x, 0.0f)); break;
    case GradientKind::Easing: f = sqr(saturate(p.x)), f *= 3.0f - 2.0f * saturate(p.x); break;
    case GradientKind::Diagonal: f = 0.5f * (p.x + p.y); break;
    case GradientKind::Spherical: f = sphere(); break;
    case GradientKind::QuadraticSphere: f = sqr(sphere()); break;
    case GradientKind::Radial: f = std::atan2(p.y, p.x) / (2.0f * kPi) + 0.5f; break;
  }
  return saturate(f);
}

/// Texture coordinates in [0, 1]^3, projected to a sphere or to a tube about z.
inline Vec2 project_sphere(Vec3 coordinate) {
  const Vec3 p = (coordinate - 0.5f) * 2.0f;
  const float length = std::sqrt(length_squared(p));
  if (!(length > 0.0f)) return Vec2(0.0f);
  const float u = p.x == 0.0f && p.y == 0.0f ? 0.0f : 0.5f - std::atan2(p.x, p.y) / (2.0f * kPi);
  return {u, 1.0f - std::acos(glm::clamp(p.z / length, -1.0f, 1.0f)) * kInvPi};
}
inline Vec2 project_tube(Vec3 coordinate) {
  const Vec3 p = (coordinate - 0.5f) * 2.0f;
  if (p.x == 0.0f && p.y == 0.0f) return Vec2(0.0f);
  return {0.5f * (1.0f - std::atan2(p.x, p.y) * kInvPi), 0.5f * (p.z + 1.0f)};
}

/// Maps a direction to image coordinates: u = 1/2 is +x, and with growing u the direction turns towards -y. v grows
/// with z.
inline Vec2 equirectangular(Vec3 d) {
  const float length = std::sqrt(length_squared(d));
  if (!(length > 0.0f)) return Vec2(0.0f);
  return {0.5f - std::atan2(d.y, d.x) / (2.0f * kPi), 1.0f - std::acos(glm::clamp(d.z / length, -1.0f, 1.0f)) * kInvPi};
}
/// The image of a mirror ball that was photographed from -y.
inline Vec2 mirror_ball(Vec3 unit_direction) {
  Vec3 half = unit_direction - Vec3(0.0f, 1.0f, 0.0f);
  const float length = 2.0f * safe_sqrt(-0.5f * half.y);
  if (length > 0.0f) half /= length;
  return {0.5f * (half.x + 1.0f), 0.5f * (half.z + 1.0f)};
}

Vec4 image(const ImageLookup& lookup, Vec2 uv);
/// Three images, projected along the axes of the object and weighted by its normal.
Vec4 image_box(const ImageLookup& lookup, Vec3 coordinate, Vec3 object_normal);
/// Coordinates at a point, and at two points beside it that are `step` pixels away.
struct CoordinatesBeside {
  Vec3 here, x, y;
};
/// The same for images with levels: the mean over a pixel.
Vec4 image_over(const ImageLookup& lookup, const CoordinatesBeside& at, float step);
Vec4 image_box_over(const ImageLookup& lookup, const CoordinatesBeside& at, float step, Vec3 object_normal);
/// The weights of the images along x, y and z, which sum to 1. `blend` is in [0, 1]: 0 gives sharp borders, 1 mixes all
/// images whose component of the normal is not 0.
Vec3 box_weights(Vec3 object_normal, float blend);

}  // namespace ajar::nodes
