// Lobes for cartoons, as Blender defines them: constant inside a cone, with a linear falloff over `smooth` beyond it.
// Angles are in radians.
#pragma once

#include <algorithm>

#include "math/types.h"
#include "math/warps.h"

namespace ajar::toon {

inline float intensity(float angle, float size, float smooth) {
  if (angle < size) return 1.0f;
  return angle < size + smooth ? 1.0f - (angle - size) / smooth : 0.0f;
}

/// 1 - cos of the cone that contains all light.
inline float cone(float size, float smooth) { return warp::one_minus_cos(std::min(size + smooth, 0.5f * kPi)); }

/// f |cos| for light at this cosine from the axis of the cone.
inline float value(float cosine, float size, float smooth) {
  return intensity(std::acos(std::clamp(cosine, 0.0f, 1.0f)), size, smooth) *
         warp::cone_pdf_solid_angle(cone(size, smooth));
}

/// Density of a direction inside the cone.
inline float pdf_solid_angle(float cosine, float size, float smooth) {
  const float whole = cone(size, smooth);
  return 1.0f - cosine < whole ? warp::cone_pdf_solid_angle(whole) : 0.0f;
}

}  // namespace ajar::toon
