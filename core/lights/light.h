// Everything that emits, one at a time: lamps with and without extent, emissive triangles,
// the sun, and the environment.
//
// Conventions: `p` is the point lit, `wi` points from p to the light. Densities of
// directions are per solid angle at p; `sample_le` gives rays leaving the light with a density per area times solid angle
// (for the sun and the environment: area of the disk around the scene). Units and shapes mean what they mean in Cycles.
// Delta lights (radius or angle 0) cannot be hit, and their pdf in `pdf_li` is 0.
#pragma once

#include <optional>

#include "math/distribution.h"
#include "math/frame.h"
#include "math/types.h"

namespace ajar {

class Scene;

enum class LightType : uint8_t { Point, Sphere, Spot, SpotSphere, Rectangle, Ellipse, DistantDelta, DistantDisk, Triangle, Environment };

struct LightSample {
  Vec3 wi;
  float distance;            ///< kInfinity for distant light
  Color radiance;            ///< emitted towards p; for delta lights radiance * geometry, so that contribution = f_cos * radiance / pdf
  float pdf_solid_angle;     ///< given this light; 1 for delta lights
  bool delta;
  Vec3 position, normal;     ///< on the light; undefined for distant lights
};

struct LightRay {
  Ray ray;
  Color radiance;
  Vec3 normal;               ///< on the light; direction of travel for distant lights
  float pdf_area;            ///< of the origin (1 for delta positions)
  float pdf_solid_angle;     ///< of the direction
};

/// One light as data. `index` refers to its lamp, its emissive triangle or the environment.
struct Light {
  LightType type = LightType::Point;
  uint32_t visibility = 63;
  bool cast_shadow = true;
  bool mis = true;           ///< may also be found by BSDF sampling
  Vec3 position{0.0f};       ///< centre; first vertex of a triangle
  Frame frame;               ///< n: where it shines; s, t: local x and y
  Vec3 edge1{0.0f}, edge2{0.0f};  ///< triangle edges; half axes of rectangle and ellipse
  Color radiance{0.0f};      ///< emitted (intensity for delta positions, irradiance for the delta sun)
  float radius = 0.0f;
  float area = 0.0f;
  float cos_outer = -1.0f, spot_smooth = 1.0f;    ///< spot cone
  float one_minus_cos = 0.0f;                     ///< sun's cone
  float spread_tan = 0.0f, spread_norm = 1.0f;    ///< area spread
  int shader = -1;           ///< program evaluated at the light point; -1: constant
  uint32_t instance = 0, primitive = 0;           ///< of a triangle
  float power = 0.0f;        ///< luminance of emitted watts, for choosing lights
};

}  // namespace ajar
