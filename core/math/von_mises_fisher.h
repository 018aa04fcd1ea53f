// The von Mises-Fisher distribution over directions: kappa / (2 pi (1 - exp(-2 kappa))) exp(kappa (mu.w - 1)).
//
// Directions are given as the squared chord |w - mu|^2 = 2 (1 - mu.w), which does not cancel for large kappa. No
// expression overflows. Sampling follows Jakob 2012, "Numerically stable sampling of the von Mises-Fisher distribution
// on S2 (and other tricks)".
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>

#include "math/types.h"

namespace ajar {

/// Minimum kappa that is distinguished from the uniform distribution, and maximum kappa that the floats of a unit
/// vector resolve.
constexpr float kMinKappa = 1e-2f, kMaxKappa = 1e5f;

/// exp(x) for x <= 0, with a relative error of 2e-7 and never below 1e-38. It has no branches, so that loops over lobes
/// are vectorized.
inline float exp_of_negative(float x) {
  const float t = std::max(x * 1.44269504f, -126.0f), whole = std::floor(t), r = t - whole;
  // 2^r on [0, 1]: a least-squares fit of the relative error, exact at both ends.
  const float p = 1.0f + r * (0.69315173f +
                              r * (0.240159691f + r * (0.0558167208f + r * (0.00899391647f + r * 0.00187794124f))));
  return p * std::bit_cast<float>((int32_t(whole) + 127) << 23);
}

namespace von_mises_fisher {

/// Density at the mean direction.
inline float peak_pdf_solid_angle(float kappa) { return kappa * (0.5f * kInvPi) / -std::expm1(-2.0f * kappa); }

inline float pdf_solid_angle(float kappa, float chord_squared) {
  return peak_pdf_solid_angle(kappa) * exp_of_negative(-0.5f * kappa * chord_squared);
}

/// A direction around +z.
inline Vec3 square_to_lobe(Vec2 u, float kappa) {
  // 1 - cos theta by inversion of the cumulative distribution function.
  const float h = std::clamp(-std::log(std::max(1.0f + u.x * std::expm1(-2.0f * kappa), 1e-38f)) / kappa, 0.0f, 2.0f);
  const float r = safe_sqrt(h * (2.0f - h)), phi = 2.0f * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1.0f - h};
}

/// The kappa whose mean resultant has this length, accurate to a few per cent [Banerjee et al. 2005, eq. 4.4].
inline float kappa_of_mean_length(float length) {
  const float r = std::min(length, 0.9999999f);
  return std::clamp(r * (3.0f - r * r) / (1.0f - r * r), kMinKappa, kMaxKappa);
}

}  // namespace von_mises_fisher

}  // namespace ajar
