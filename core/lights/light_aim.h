// Where lights are and where they shine, and the estimate of the irradiance that they send: for one node of the light
// tree, or for many lamps at once.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lights/light_bounds.h"

namespace ajar {

/// Three numbers. Compilers do not compute with several Vec3 at once, because it is a union.
struct Triple {
  float x, y, z;
  Triple() = default;
  Triple(float x, float y, float z) : x(x), y(y), z(z) {}
  explicit Triple(const Vec3& v) : x(v.x), y(v.y), z(v.z) {}
  explicit operator Vec3() const { return {x, y, z}; }
  friend Triple operator+(Triple a, Triple b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Triple operator-(Triple a, Triple b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Triple operator*(float a, Triple b) { return {a * b.x, a * b.y, a * b.z}; }
};
inline float dot(Triple a, Triple b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// The bounds of lights as the estimates need them.
struct LightAim {
  Triple center, half;   // of the box of the lights; half its size
  float radius_squared;  // of the sphere around the box
  Triple axis;
  float cos_normals, sin_normals, cos_beyond;
  float intensity;                 // LightBounds::intensity without the part that grows
  float growing, growing_squared;  // with the distance, and with its square
  float angle_squared;             // of the sphere by which the angle of emission is uncertain: tiny for a flat light

  /// The intensity for a point at this squared distance.
  float strength(float distance2) const {
    const float grown = growing * std::sqrt(distance2) + growing_squared * distance2;
    return intensity + (grown > 0.0f ? grown : 0.0f);  // not a number if nothing grows and the distance is infinite
  }
};
LightAim aim_of(const LightBounds& bounds);

/// Minimum cosine at the receiver: shading normals differ from geometric ones, and coats have normals of their own.
inline constexpr float kMinReceiverCosine = 0.02f;
/// For stretches: rounding of the cosine at the edge of a cone, and the minimum factor of lights that may reach one.
inline constexpr float kConeRounding = 1e-4f, kMinEmitterCosine = 1e-3f;

/// Cosine of max(0, a - b) from the cosines of a and b and the sine of b; a is at most 180 degrees.
inline float cos_of_rest(float cos_a, float cos_b, float sin_b) {
  const float sin_a = std::sqrt(std::abs(1.0f - cos_a * cos_a));  // rounding at 180 degrees can make this negative
  return cos_a >= cos_b ? 1.0f : cos_a * cos_b + sin_a * sin_b;
}

/// About the mean of the positive cosine over angles that differ from one with the cosine `center` by up to `size`, whose
/// largest cosine is `nearest`. For small sizes it is exact in the first order. 0 only if `nearest` is not positive.
inline float mean_cosine(float center, float nearest, float sin_size) {
  const float partly = nearest * nearest / (4.0f * sin_size + 1e-6f);
  const float least = center > partly ? center : partly, mean = center >= sin_size ? center : least;
  return mean < nearest ? mean : nearest;
}

/// atan2(y, x) for y >= 0, within 0.005. An importance need not be exact.
inline float angle_of(float y, float x) {
  const float across = std::abs(x), most = y > across ? y : across, least = y > across ? across : y;
  const float z = least / (most > 1e-30f ? most : 1e-30f), octant = z / (1.0f + 0.28f * z * z);
  const float quadrant = y > across ? 0.5f * kPi - octant : octant;
  return x < 0.0f ? kPi - quadrant : quadrant;
}

// The estimates have two forms. Without branches the compiler computes several at once; with them, a single estimate is
// faster.

/// Estimate of the irradiance at p with the normal n (0: light from all sides counts): intensity cos cos / distance^2,
/// with the most favourable normals that the bounds allow. The cosines are means over the extent of lamps, and the most
/// favourable ones of nodes. With those, two large lamps that graze a wall got 80 % of its samples for a third of its
/// light (docs/research/speed.md). 0 only if nothing can reach p.
template <bool kBranches>
[[gnu::always_inline]] inline float irradiance_estimate(const LightAim& a, bool two_sided, Triple p, Triple n) {
  const Triple d = a.center - p;
  const float distance2 = dot(d, d);
  const bool inside = !(distance2 > a.radius_squared);
  const auto there = [&] {
    return a.strength(a.radius_squared) / (a.radius_squared > 1e-30f ? a.radius_squared : 1e-30f);
  };
  if (kBranches && inside) return there();
  const float inverse = 1.0f / std::sqrt(distance2);
  // `size` is the half-angle of the sphere around the lights, seen from p.
  const float sin2_size = a.radius_squared / distance2;
  const float cos_size = std::sqrt(std::abs(1.0f - sin2_size)), sin_size = std::sqrt(sin2_size);
  float result = a.strength(distance2) / distance2;
  // If there are normals in all directions, one of them points to p.
  if (!kBranches || a.cos_normals > -1.0f) {
    float cos_axis = -dot(a.axis, d) * inverse;
    if (two_sided) cos_axis = std::abs(cos_axis);
    if (!kBranches || cos_axis < a.cos_normals) {
      const float sin2_angle = a.angle_squared / distance2, sin_angle = std::sqrt(sin2_angle);
      const float cos_center = cos_of_rest(cos_axis, a.cos_normals, a.sin_normals),
                  cos_out = cos_of_rest(cos_center, std::sqrt(std::abs(1.0f - sin2_angle)), sin_angle);
      if (kBranches && cos_out < a.cos_beyond) return 0.0f;
      const float mean = kBranches ? cos_out : mean_cosine(cos_center, cos_out, sin_angle);
      const float emitted = !(cos_axis < a.cos_normals) ? 1.0f : (cos_out < a.cos_beyond ? 0.0f : mean);
      result = emitted > 0.0f ? result * emitted : 0.0f;
    }
  }
  const bool from_all_sides = dot(n, n) == 0.0f;
  if (!kBranches || !from_all_sides) {
    const float cos_center = dot(n, d) * inverse, nearest = cos_of_rest(cos_center, cos_size, sin_size),
                cosine = kBranches ? nearest : mean_cosine(cos_center, nearest, sin_size);
    const float received = cosine > kMinReceiverCosine ? cosine : kMinReceiverCosine;
    result *= from_all_sides ? 1.0f : received;
  }
  return inside ? there() : result;
}

/// A LightStretch that is not a point.
struct PlainStretch {
  Triple origin, direction;
  float begin, end, reach;
};

/// Estimate of the mean of intensity / distance^2 along the part of a stretch that counts, with the most favourable angle
/// of all points of the stretch.
template <bool kBranches>
[[gnu::always_inline]] inline float fluence_estimate(const LightAim& a, bool two_sided, const PlainStretch& s) {
  const auto larger = [](float x, float y) { return x > y ? x : y; };
  const auto smaller = [](float x, float y) { return x < y ? x : y; };
  // v: from the centre of the lights to the origin of the ray. The ray is nearest at the distance `nearest`.
  const Triple v = s.origin - a.center;
  const float nearest = -dot(v, s.direction);
  // Where a ray goes through the box, the mean of 1 / distance is that at half of its size across the ray.
  const Triple across(a.half.x * a.half.x * (1.0f - s.direction.x * s.direction.x),
                      a.half.y * a.half.y * (1.0f - s.direction.y * s.direction.y),
                      a.half.z * a.half.z * (1.0f - s.direction.z * s.direction.z));
  const Triple beside = v + nearest * s.direction;
  const float apart2 = larger(dot(beside, beside), larger(0.25f * (across.x + across.y + across.z), 0.0f));
  const float apart = larger(std::sqrt(apart2), 1e-15f);
  const float before = s.begin - nearest, after = before + s.reach;
  const float angle = angle_of(apart * s.reach, apart2 + before * after);  // between both ends, seen from there
  const float in_front = before > 0.0f ? before : smaller(after, 0.0f);
  const float mean = a.strength(apart2 + in_front * in_front) * angle / (apart * s.reach);
  if (kBranches && !(a.cos_normals > -1.0f)) return mean;
  // The nearest point of the whole stretch, and the point that is seen from there in the direction nearest to the axis.
  const Triple near = v + smaller(larger(nearest, s.begin), s.end) * s.direction;
  const float distance2 = dot(near, near);
  const bool inside = !(distance2 > a.radius_squared);
  if (kBranches && inside) return mean;
  const auto cosine_at = [&](float t) {
    const Triple to_point = v + t * s.direction;
    const float length = std::sqrt(dot(to_point, to_point));
    const float cosine = length > 0.0f ? dot(a.axis, to_point) / length : 1.0f;
    return two_sided ? std::abs(cosine) : cosine;
  };
  const float last = smaller(s.end, 1e15f);
  const float at_ends = larger(cosine_at(s.begin), cosine_at(last));
  const float from = dot(a.axis, v), along = dot(a.axis, s.direction);
  const float extreme = (along * dot(v, v) + from * nearest) / (from + along * nearest);  // where the derivative is 0
  const bool between = (extreme > s.begin) & (extreme < last);
  const float cos_axis = larger(at_ends, between ? cosine_at(between ? extreme : last) : -1.0f);
  if (kBranches && cos_axis >= a.cos_normals) return mean;
  const float sin2_size = smaller(a.radius_squared / distance2, 1.0f);
  const float cos_out = cos_of_rest(cos_of_rest(cos_axis, a.cos_normals, a.sin_normals), std::sqrt(1.0f - sin2_size),
                                    std::sqrt(sin2_size));
  const float emitted = cos_out < a.cos_beyond - kConeRounding ? 0.0f : larger(cos_out, kMinEmitterCosine);
  return (inside | (cos_axis >= a.cos_normals)) ? mean : mean * emitted;
}

/// Nodes of a light tree, stored by component.
class LightLanes {
 public:
  static constexpr size_t kAtOnce = 8;
  struct Lane {
    LightAim aim;
    uint32_t node;
  };
  LightLanes() = default;
  explicit LightLanes(const std::vector<Lane>& lanes);
  uint32_t node(size_t lane) const { return nodes_[lane]; }
  /// Estimates for the lanes first to first + count - 1, none of which is two-sided. `values` has room for count + kAtOnce.
  void estimate(size_t first, size_t count, const Vec3& p, const Vec3& n, float* values) const;
  void estimate(size_t first, size_t count, const PlainStretch& stretch, float* values) const;
  size_t memory_bytes() const { return values_.size() * sizeof(float) + nodes_.size() * sizeof(uint32_t); }

 private:
  template <class Estimate>
  void fill(size_t first, size_t count, float* values, const Estimate& estimate) const;
  static constexpr size_t kComponents = sizeof(LightAim) / sizeof(float);
  std::vector<float> values_;  // for each component of LightAim, those of all lanes and kAtOnce more
  std::vector<uint32_t> nodes_;
};

}  // namespace ajar
