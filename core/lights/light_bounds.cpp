#include "lights/light_bounds.h"

#include <algorithm>
#include <cmath>

#include "lights/sources/lamp.h"

namespace ajar {

namespace {

float angle_of(float cosine) { return std::acos(std::clamp(cosine, -1.0f, 1.0f)); }

}  // namespace

float orientation_measure(const LightBounds& b) {
  if (b.two_sided) return 4.0f * kPi;
  const float o = angle_of(b.cos_normals), w = std::min(o + angle_of(b.cos_beyond), kPi);
  return 2.0f * kPi * (1.0f - b.cos_normals) +
         0.5f * kPi * (2.0f * w * std::sin(o) - std::cos(o - 2.0f * w) - 2.0f * o * std::sin(o) + b.cos_normals);
}

void widen(LightBounds& sum, const LightBounds& other) {
  sum.lower = glm::min(sum.lower, other.lower);
  sum.upper = glm::max(sum.upper, other.upper);
  sum.two_sided |= other.two_sided;
  sum.flat = false;
  sum.intensity += other.intensity;
  sum.grown += other.grown;
  sum.growing += other.growing;
  sum.cos_beyond = std::min(sum.cos_beyond, other.cos_beyond);
}

LightBounds join(const LightBounds& a, const LightBounds& b) {
  if (!(a.intensity > 0.0f)) return b;
  if (!(b.intensity > 0.0f)) return a;
  LightBounds sum = a;
  widen(sum, b);
  const LightBounds& wide = a.cos_normals <= b.cos_normals ? a : b;
  const LightBounds& narrow = a.cos_normals <= b.cos_normals ? b : a;
  sum.axis = wide.axis;
  sum.cos_normals = wide.cos_normals;
  if (!(wide.cos_normals > -1.0f)) return sum;
  // For two-sided emission, a normal may be reversed.
  float cosine = std::clamp(glm::dot(wide.axis, narrow.axis), -1.0f, 1.0f);
  Vec3 other = narrow.axis;
  if (sum.two_sided && cosine < 0.0f) {
    cosine = -cosine;
    other = -other;
  }
  const float between = angle_of(cosine), o = angle_of(wide.cos_normals), o_narrow = angle_of(narrow.cos_normals);
  if (std::min(between + o_narrow, kPi) <= o) return sum;
  const float half = 0.5f * (o + between + o_narrow);
  const Vec3 across = other - cosine * wide.axis;
  const float length2 = glm::dot(across, across);
  if (half >= kPi || !(length2 > 1e-12f)) {
    sum.cos_normals = -1.0f;
    return sum;
  }
  const float turn = half - o;
  sum.axis = glm::normalize(std::cos(turn) * wide.axis + std::sin(turn) / std::sqrt(length2) * across);
  sum.cos_normals = std::cos(half);
  return sum;
}

void let_grow(LightBounds& bounds, int power, float distance) {
  if (power < 1) return;
  bounds.grown = bounds.intensity;
  bounds.growing[power - 1] = bounds.intensity / (power == 1 ? distance : sqr(distance));
}

LightBounds lamp_bounds(const Light& lamp, float watts) {
  LightBounds b;
  Vec3 half(0.0f);
  float peak = 1.0f;  // intensity of the lamp without its shader, in the direction of maximum emission
  switch (lamp.type) {
    case LightType::Rectangle:
    case LightType::Ellipse:
      half = glm::abs(lamp.edge1) + glm::abs(lamp.edge2);
      b.axis = lamp.frame.n;
      // The edge of the beam by the spread.
      b.cos_beyond = lamp.spread_tan > 0.0f ? 0.999f * lamp.spread_tan / std::sqrt(1.0f + sqr(lamp.spread_tan)) : 0.0f;
      b.flat = !(b.cos_beyond > 0.0f);
      peak = lamp.area * lamp_profile(lamp, lamp.frame.n);
      break;
    case LightType::Spot:
    case LightType::SpotSphere:
      b.axis = lamp.frame.n;
      b.cos_beyond = lamp.cos_widest - 1e-4f;
      peak = lamp.type == LightType::Spot ? 1.0f : kPi * sqr(lamp.radius);
      break;
    default: b.cos_normals = -1.0f; peak = lamp.type == LightType::Point ? 1.0f : kPi * sqr(lamp.radius);
  }
  if (lamp.type == LightType::Sphere || lamp.type == LightType::SpotSphere) half = Vec3(lamp.radius);
  b.lower = lamp.position - half;
  b.upper = lamp.position + half;
  const float flux = luminance(glm::abs(lamp_flux(lamp, 1.0f)));
  b.intensity = flux > 0.0f ? watts * peak * (luminance(glm::abs(lamp.radiance)) / flux) : watts * (0.25f * kInvPi);
  return b;
}

LightBounds triangle_bounds(const WorldTriangle& t, float watts) {
  LightBounds b;
  const Vec3 p1 = t.p0 + t.e1, p2 = t.p0 + t.e2;
  b.lower = glm::min(t.p0, glm::min(p1, p2));
  b.upper = glm::max(t.p0, glm::max(p1, p2));
  b.axis = t.normal;
  b.two_sided = true;
  b.intensity = watts * (0.5f * kInvPi);
  return b;
}

}  // namespace ajar
