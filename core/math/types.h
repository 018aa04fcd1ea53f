// Vector, colour and matrix types of the whole library: GLM under the names of the field.
//
// Conventions: right-handed, Z up, metres (the axes and units of Blender, never converted). Colours are linear RGB in
// the working space of the scene (Rec. 709 primaries unless Blender's configuration says otherwise). Transforms are
// named destination first: world_from_object * p_object = p_world.
#pragma once

#include <cstdint>
#include <limits>

#include <glm/glm.hpp>
#include <glm/gtc/matrix_inverse.hpp>

namespace ajar {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Vec4 = glm::vec4;
using UVec3 = glm::uvec3;
using Mat3 = glm::mat3;
using Mat4 = glm::mat4;
using Color = glm::vec3;

constexpr float kPi = 3.14159265358979323846f;
constexpr float kInvPi = 1.0f / kPi;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

/// Bound on the relative error of n rounded operations (Higham; pbrt-4, section 6.8).
constexpr float gamma_bound(int n) {
  constexpr float unit_roundoff = 0x1p-24f;
  return float(n) * unit_roundoff / (1.0f - float(n) * unit_roundoff);
}

inline float sqr(float x) { return x * x; }
inline float saturate(float x) { return x < 0.0f ? 0.0f : (x > 1.0f ? 1.0f : x); }
inline float safe_sqrt(float x) { return x > 0.0f ? std::sqrt(x) : 0.0f; }
inline float length_squared(Vec3 v) { return glm::dot(v, v); }
inline float max_component(Vec3 v) { return glm::max(v.x, glm::max(v.y, v.z)); }
inline float abs_dot(Vec3 a, Vec3 b) { return std::abs(glm::dot(a, b)); }
inline bool is_black(Color c) { return c.x == 0.0f && c.y == 0.0f && c.z == 0.0f; }
inline bool is_finite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// CIE Y of a linear Rec. 709 colour; code decides about colours by this scalar.
inline float luminance(Color c) { return 0.2126729f * c.x + 0.7151522f * c.y + 0.0721750f * c.z; }
inline const Color kRec709Luminance{0.2126729f, 0.7151522f, 0.0721750f};

inline Vec3 transform_point(const Mat4& m, Vec3 p) { return Vec3(m * Vec4(p, 1.0f)); }
inline Vec3 transform_vector(const Mat4& m, Vec3 v) { return Vec3(m * Vec4(v, 0.0f)); }

struct Ray {
  Vec3 origin{0.0f};
  Vec3 direction{0.0f, 0.0f, 1.0f};  ///< unit length
  float t_min = 0.0f;
  float t_max = kInfinity;
  float time = 0.0f;       ///< in [0, 1] over the shutter interval
  float travelled = 0.0f;  ///< before the origin, in the same direction, through surfaces that it has passed straight
  uint32_t strand = 0;     ///< Scene::spawn_ray: identifies the strand of hair that it leaves and does not hit; 0: none
  uint32_t blockers = 32;  ///< of a shadow ray: bits of BuiltInstance::visibility of what blocks it (kVisibleShadow)
};

}  // namespace ajar
