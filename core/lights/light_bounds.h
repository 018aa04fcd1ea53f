// Bounds of the positions and directions of lights. They can be joined; the nodes of the light tree use them.
#pragma once

#include "lights/sources/light.h"
#include "lights/sources/triangle_light.h"

namespace ajar {

/// Bounds of one light or of several.
struct LightBounds {
  Vec3 lower{kInfinity}, upper{-kInfinity};  ///< box of the positions, world space
  Vec3 axis{0, 0, 1};                        ///< unit; axis of the cone of normals
  float cos_normals = 1.0f;                  ///< cosine of the half-angle of that cone
  /// cosine of the angle to a normal up to which light is emitted: 0 for a flat diffuse light
  float cos_beyond = 0.0f;
  bool two_sided = false;
  /// one flat lamp that emits up to 90 degrees: all of it is seen from the same side
  bool flat = false;
  float intensity = 0.0f;  ///< luminance in W/sr, in the direction of maximum emission
  /// The part of the intensity that grows with the distance of the lit point, and what it is there: a coefficient of the
  /// distance and one of its square.
  float grown = 0.0f;
  Vec2 growing{0.0f};
};
/// The same without the cone, for which a two-sided sum has no use in the cost of a split.
void widen(LightBounds& sum, const LightBounds& other);
/// Bounds of both.
LightBounds join(const LightBounds& a, const LightBounds& b);
/// Bounds of a local lamp that emits `watts` (luminance), which can differ from its own power by a factor of a shader.
LightBounds lamp_bounds(const Light& lamp, float watts);
/// Bounds of a triangle that emits `watts` from both sides.
LightBounds triangle_bounds(const WorldTriangle& triangle, float watts);
/// Lets the intensity, which is that at this distance, grow with a power of the distance: 0, 1 or 2.
void let_grow(LightBounds& bounds, int power, float distance);
/// Measure of the directions of emission [Conty Estevez and Kulla 2018, eq. 1].
float orientation_measure(const LightBounds& bounds);

}  // namespace ajar
