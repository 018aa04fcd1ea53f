// Everything that emits, one at a time: lamps with and without extent, emissive triangles,
// the sun, and the environment.
//
// Conventions: `p` is the point lit, `wi` points from p to the light, `wo` from the light to p.
// Densities of directions are per solid angle at p; `sample_le` gives rays leaving the light with a density per
// area times solid angle (for the sun and the environment: area of the disk around the scene).
// Units and shapes mean what they mean in Cycles 3.4 (lamp.h has the formulas).
// Delta lights (radius or angle 0) cannot be hit, and their pdf in `pdf_li` is 0.
#pragma once

#include <optional>

#include "math/frame.h"
#include "math/types.h"

namespace ajar {

enum class LightType : uint8_t {
  Point,
  Sphere,
  Spot,
  SpotSphere,
  Rectangle,
  Ellipse,
  DistantDelta,
  DistantDisk,
  Triangle,
  Environment
};

inline bool is_delta(LightType type) {
  return type == LightType::Point || type == LightType::Spot || type == LightType::DistantDelta;
}
inline bool is_sphere(LightType type) { return type == LightType::Sphere || type == LightType::SpotSphere; }
inline bool is_distant(LightType type) {
  return type == LightType::DistantDelta || type == LightType::DistantDisk || type == LightType::Environment;
}

/// Where a lamp's shader asks how far its light goes and nobody knows yet: metres.
constexpr float kUsualDistance = 1.0f;

/// A place that is looked at from p, on a light or another surface.
struct LightPlace {
  Vec3 wi;                      ///< from p
  float distance;               ///< kInfinity for distant light
  Vec3 position, normal;        ///< for distant lights and those without extent the normal is -wi
  float position_error = 0.0f;  ///< by which rounding may have moved it off its surface, besides a part of the distance
};

struct LightSample : LightPlace {
  /// emitted towards p; for delta lights radiance * geometry, so that contribution = f_cos * radiance / pdf
  Color radiance;
  float pdf_solid_angle;  ///< given this light; 1 for delta lights
  bool delta;
};

/// Of a place on a lamp.
inline float lamp_position_error(Vec3 position) { return gamma_bound(8) * max_component(glm::abs(position)); }

struct LightRay {
  Ray ray;
  Color radiance;         ///< intensity for delta positions, irradiance for the delta sun
  Vec3 normal;            ///< on the light; direction of travel for delta positions and distant lights
  float pdf_area;         ///< of the origin (1 for delta positions)
  float pdf_solid_angle;  ///< of the direction (1 for the delta sun)
};

/// What an integrator asks of a light at every sample.
struct LightFlags {
  LightType type = LightType::Point;
  uint32_t visibility = 63;
  bool cast_shadow = true;
  bool mis = true;  ///< may also be found by BSDF sampling
  /// Does it shine on some kinds of lobes only (VisibilityBits of diffuse, glossy and transmission)? Then rough lobes
  /// are lit by light sampling alone, which tells them apart, and the rays of sharp ones see it or not.
  bool partial() const { return (visibility & 14u) != 14u; }
};

/// One light as data; only what its type needs is set.
struct Light {
  LightType type = LightType::Point;
  uint32_t visibility = 63;
  bool cast_shadow = true;
  bool mis = true;                              ///< may also be found by BSDF sampling
  Vec3 position{0.0f};                          ///< centre; first vertex of a triangle
  Frame frame;                                  ///< n: where it shines; s, t: local x and y
  Vec3 edge1{0.0f}, edge2{0.0f};                ///< triangle edges; half axes of rectangle and ellipse
  Color radiance{0.0f};                         ///< emitted (intensity for delta positions, irradiance for the suns)
  float radius = 0.0f;                          ///< of the sphere; of the sun's disk at distance 1
  float area = 0.0f;                            ///< one side; of the sun's disk at distance 1
  float cos_outer = -1.0f, spot_smooth = 0.0f;  ///< spot: edge of the cone, width of the blend in cosine
  float spread_tan = 0.0f, spread_norm = 1.0f;  ///< area: slope and scale of the attenuation
  int shader = -1;                              ///< program that multiplies `radiance` at the light point; -1: none
  uint32_t instance = 0, primitive = 0;         ///< of a triangle
  float power = 0.0f;                           ///< luminance of emitted watts, for choosing lights
};

}  // namespace ajar
