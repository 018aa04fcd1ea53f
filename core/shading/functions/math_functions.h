// The functions of the nodes Math, Vector Math, Clamp, Map Range, Mapping and Vector Rotate. The definitions are
// Blender's (manual, "Converter Nodes"). As in Cycles, division by zero and arguments outside a function's domain give
// 0.
#pragma once

#include <cmath>

#include "math/types.h"

namespace ajar::nodes {

enum class MathOperation : uint8_t {
  Add,
  Subtract,
  Multiply,
  Divide,
  MultiplyAdd,
  Power,
  Logarithm,
  Sqrt,
  InverseSqrt,
  Absolute,
  Exponent,
  Minimum,
  Maximum,
  LessThan,
  GreaterThan,
  Sign,
  Compare,
  SmoothMin,
  SmoothMax,
  Round,
  Floor,
  Ceil,
  Trunc,
  Fract,
  Modulo,
  FlooredModulo,
  Wrap,
  Snap,
  PingPong,
  Sine,
  Cosine,
  Tangent,
  ArcSine,
  ArcCosine,
  ArcTangent,
  ArcTan2,
  Sinh,
  Cosh,
  Tanh,
  Radians,
  Degrees
};

inline float divide(float a, float b) { return b != 0.0f ? a / b : 0.0f; }
inline Vec3 divide(Vec3 a, Vec3 b) { return {divide(a.x, b.x), divide(a.y, b.y), divide(a.z, b.z)}; }
inline float modulo(float a, float b) { return b != 0.0f ? std::fmod(a, b) : 0.0f; }
inline float floored_modulo(float a, float b) { return b != 0.0f ? a - std::floor(a / b) * b : 0.0f; }
inline float wrap(float value, float max, float min) {
  const float range = max - min;
  return range != 0.0f ? value - range * std::floor((value - min) / range) : min;
}
inline float ping_pong(float a, float b) {
  if (b == 0.0f) return 0.0f;
  const float x = (a - b) / (2.0f * b);
  return std::abs((x - std::floor(x)) * 2.0f * b - b);
}
inline float smooth_min(float a, float b, float k) {
  if (k == 0.0f) return std::min(a, b);
  const float h = std::max(k - std::abs(a - b), 0.0f) / k;
  return std::min(a, b) - h * h * h * k * (1.0f / 6.0f);
}
inline Vec3 normalize_or_zero(Vec3 v) {
  const float length = std::sqrt(length_squared(v));
  return length > 0.0f ? v / length : Vec3(0.0f);
}

inline float math(MathOperation operation, float a, float b, float c) {
  using O = MathOperation;
  switch (operation) {
    case O::Add: return a + b;
    case O::Subtract: return a - b;
    case O::Multiply: return a * b;
    case O::Divide: return divide(a, b);
    case O::MultiplyAdd: return a * b + c;
    case O::Power: return a < 0.0f && b != std::trunc(b) ? 0.0f : std::pow(a, b);
    case O::Logarithm: return a <= 0.0f || b <= 0.0f ? 0.0f : divide(std::log(a), std::log(b));
    case O::Sqrt: return safe_sqrt(a);
    case O::InverseSqrt: return a > 0.0f ? 1.0f / std::sqrt(a) : 0.0f;
    case O::Absolute: return std::abs(a);
    case O::Exponent: return std::exp(a);
    case O::Minimum: return std::min(a, b);
    case O::Maximum: return std::max(a, b);
    case O::LessThan: return a < b ? 1.0f : 0.0f;
    case O::GreaterThan: return a > b ? 1.0f : 0.0f;
    case O::Sign: return float(a > 0.0f) - float(a < 0.0f);
    case O::Compare:
      return a == b || std::abs(a - b) <= std::max(c, std::numeric_limits<float>::epsilon()) ? 1.0f : 0.0f;
    case O::SmoothMin: return smooth_min(a, b, c);
    case O::SmoothMax: return -smooth_min(-a, -b, c);
    case O::Round: return std::floor(a + 0.5f);
    case O::Floor: return std::floor(a);
    case O::Ceil: return std::ceil(a);
    case O::Trunc: return std::trunc(a);
    case O::Fract: return a - std::floor(a);
    case O::Modulo: return modulo(a, b);
    case O::FlooredModulo: return floored_modulo(a, b);
    case O::Wrap: return wrap(a, b, c);
    case O::Snap: return std::floor(divide(a, b)) * b;
    case O::PingPong: return ping_pong(a, b);
    case O::Sine: return std::sin(a);
    case O::Cosine: return std::cos(a);
    case O::Tangent: return std::tan(a);
    case O::ArcSine: return std::asin(glm::clamp(a, -1.0f, 1.0f));
    case O::ArcCosine: return std::acos(glm::clamp(a, -1.0f, 1.0f));
    case O::ArcTangent: return std::atan(a);
    case O::ArcTan2: return std::atan2(a, b);
    case O::Sinh: return std::sinh(a);
    case O::Cosh: return std::cosh(a);
    case O::Tanh: return std::tanh(a);
    case O::Radians: return a * (kPi / 180.0f);
    case O::Degrees: return a * (180.0f / kPi);
  }
  return 0.0f;
}

enum class VectorOperation : uint8_t {
  Add,
  Subtract,
  Multiply,
  Divide,
  MultiplyAdd,
  CrossProduct,
  Project,
  Reflect,
  Refract,
  FaceForward,
  DotProduct,
  Distance,
  Length,
  Scale,
  Normalize,
  Absolute,
  Minimum,
  Maximum,
  Floor,
  Ceil,
  Fraction,
  Modulo,
  Wrap,
  Snap,
  Sine,
  Cosine,
  Tangent,
  Power,
  Sign,
  Round
};

inline Vec3 refract(Vec3 incident, Vec3 normal, float eta) {
  const float cosine = glm::dot(normal, incident);
  const float k = 1.0f - eta * eta * (1.0f - cosine * cosine);
  return k < 0.0f ? Vec3(0.0f) : eta * incident - (eta * cosine + std::sqrt(k)) * normal;
}

/// Operations whose result is a vector; `scale` is the fourth socket.
inline Vec3 vector_math(VectorOperation operation, Vec3 a, Vec3 b, Vec3 c, float scale) {
  using O = VectorOperation;
  const auto each = [&](MathOperation one) {
    return Vec3(math(one, a.x, b.x, c.x), math(one, a.y, b.y, c.y), math(one, a.z, b.z, c.z));
  };
  switch (operation) {
    case O::Add: return a + b;
    case O::Subtract: return a - b;
    case O::Multiply: return a * b;
    case O::Divide: return divide(a, b);
    case O::MultiplyAdd: return a * b + c;
    case O::CrossProduct: return glm::cross(a, b);
    case O::Project: {
      const float length2 = length_squared(b);
      return length2 != 0.0f ? glm::dot(a, b) / length2 * b : Vec3(0.0f);
    }
    case O::Reflect: {
      const Vec3 n = normalize_or_zero(b);
      return a - 2.0f * n * glm::dot(a, n);
    }
    case O::Refract: return refract(a, normalize_or_zero(b), scale);
    case O::FaceForward: return glm::dot(c, b) < 0.0f ? a : -a;
    case O::Scale: return a * scale;
    case O::Normalize: return normalize_or_zero(a);
    case O::Absolute: return glm::abs(a);
    case O::Minimum: return glm::min(a, b);
    case O::Maximum: return glm::max(a, b);
    case O::Floor: return glm::floor(a);
    case O::Ceil: return glm::ceil(a);
    case O::Fraction: return a - glm::floor(a);
    case O::Modulo: return each(MathOperation::Modulo);
    case O::Wrap: return each(MathOperation::Wrap);
    case O::Snap: return each(MathOperation::Snap);
    case O::Sine: return each(MathOperation::Sine);
    case O::Cosine: return each(MathOperation::Cosine);
    case O::Tangent: return each(MathOperation::Tangent);
    case O::Power: return each(MathOperation::Power);
    case O::Sign: return each(MathOperation::Sign);
    case O::Round: return each(MathOperation::Round);
    default: return Vec3(0.0f);
  }
}

/// Operations whose result is a number.
inline float vector_math_value(VectorOperation operation, Vec3 a, Vec3 b) {
  switch (operation) {
    case VectorOperation::DotProduct: return glm::dot(a, b);
    case VectorOperation::Distance: return std::sqrt(length_squared(a - b));
    case VectorOperation::Length: return std::sqrt(length_squared(a));
    default: return 0.0f;
  }
}

/// If `sorted`, min and max are swapped if min is greater than max (Clamp Type: Range).
inline float clamp_between(float value, float min, float max, bool sorted) {
  if (sorted && min > max) std::swap(min, max);
  return std::min(std::max(value, min), max);
}

enum class RangeInterpolation : uint8_t { Linear, Stepped, SmoothStep, SmootherStep };

inline float map_range(RangeInterpolation kind, float value, float from_min, float from_max, float to_min, float to_max,
                       float steps) {
  if (from_max == from_min) return 0.0f;
  float t = (value - from_min) / (from_max - from_min);
  switch (kind) {
    case RangeInterpolation::Linear: break;
    case RangeInterpolation::Stepped: t = steps > 0.0f ? std::floor(t * (steps + 1.0f)) / steps : 0.0f; break;
    case RangeInterpolation::SmoothStep: t = saturate(t), t = (3.0f - 2.0f * t) * t * t; break;
    case RangeInterpolation::SmootherStep: t = saturate(t), t = t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); break;
  }
  return to_min + t * (to_max - to_min);
}
/// A component of a vector for which from_min equals from_max is mapped to to_min.
inline float map_range_component(RangeInterpolation kind, float value, float from_min, float from_max, float to_min,
                                 float to_max, float steps) {
  return from_max == from_min ? to_min : map_range(kind, value, from_min, from_max, to_min, to_max, steps);
}

/// Rotation by Euler angles in radians in Blender's order XYZ: x is applied first.
inline Mat3 euler_rotation(Vec3 angles) {
  const float cx = std::cos(angles.x), cy = std::cos(angles.y), cz = std::cos(angles.z);
  const float sx = std::sin(angles.x), sy = std::sin(angles.y), sz = std::sin(angles.z);
  return Mat3(Vec3(cy * cz, cy * sz, -sy), Vec3(sy * sx * cz - cx * sz, sy * sx * sz + cx * cz, cy * sx),
              Vec3(sy * cx * cz + sx * sz, sy * cx * sz - sx * cz, cy * cx));
}

enum class MappingKind : uint8_t { Point, Texture, Vector, Normal };

inline Vec3 mapping(MappingKind kind, Vec3 vector, Vec3 location, Vec3 rotation, Vec3 scale) {
  const Mat3 rotate = euler_rotation(rotation);
  switch (kind) {
    case MappingKind::Point: return rotate * (vector * scale) + location;
    case MappingKind::Texture: return divide((vector - location) * rotate, scale);
    case MappingKind::Vector: return rotate * (vector * scale);
    case MappingKind::Normal: return normalize_or_zero(rotate * divide(vector, scale));
  }
  return vector;
}

inline Vec3 rotate_around(Vec3 v, Vec3 unit_axis, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return v * c + glm::cross(unit_axis, v) * s + unit_axis * (glm::dot(unit_axis, v) * (1.0f - c));
}

}  // namespace ajar::nodes
