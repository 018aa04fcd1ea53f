// Where a light is and where it shines to, as bounds that can be joined: what a tree of lights knows of its nodes.
#pragma once

#include "lights/light.h"
#include "lights/triangle_light.h"

namespace ajar {

/// What the tree knows of a light, or of many.
struct LightBounds {
  Vec3 lower{kInfinity}, upper{-kInfinity};  ///< where it is, world space
  Vec3 axis{0, 0, 1};                        ///< unit; of the cone of normals
  float cos_normals = 1.0f;                  ///< half-angle of that cone
  float cos_beyond = 0.0f;                   ///< how far from a normal light still goes: 0 for a flat diffuse light
  bool two_sided = false;
  float intensity = 0.0f;  ///< luminance, W/sr, where it shines most
};
/// Bounds of both together.
LightBounds join(const LightBounds& a, const LightBounds& b);
/// Of a lamp near by that emits `watts` (luminance), which may differ from its own by a shader's factor.
LightBounds lamp_bounds(const Light& lamp, float watts);
/// Of a triangle that emits `watts` from both sides.
LightBounds triangle_bounds(const WorldTriangle& triangle, float watts);
/// Measure of the directions it shines to [Conty Estevez and Kulla 2018, eq. 1].
float orientation_measure(const LightBounds& bounds);

}  // namespace ajar
