// Lobes for cartoons, as Blender defines them: constant inside a cone, falling linearly over `smooth` beyond it. Angles
// in radians.
#pragma once

#include <algorithm>

#include "math/types.h"
#include "math/warps.h"

namespace ajar::toon {

inline float intensity(float angle, float size, float smooth) {
  if (angle < size) return 1.0f;
  return angle < size + smooth ? 1.0f - (angle - size) / smooth : 0.0f;
}

/// 1 - cos of the cone that holds all light.
inline float cone(float size, float smooth) { return warp::one_minus_cos(std::min(size + smooth, 0.5f * kPi)); }

/// f |cos| where the light is at this cosine from the cone's axis.
inline float value(float cosine, float size, float smooth) {
  return intensity(std::acos(std::clamp(cosine, 0.0f, 1.0f)), size, smooth) *
         warp::cone_pdf_solid_angle(cone(size, smooth));
}

/// Density of a direction in the cone.
inline float pdf_solid_angle(float cosine, float size, float smooth) {
  const float whole = cone(size, smooth);
  return 1.0f - cosine < whole ? warp::cone_pdf_solid_angle(whole) : 0.0f;
}

}  // namespace ajar::toon
