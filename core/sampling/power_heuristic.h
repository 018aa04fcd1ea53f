// The weight of a sample that another method could have drawn, too.
#pragma once

namespace ajar {

/// Power heuristic with exponent 2 for two densities of the same measure [Veach 1997, eq. 9.13].
inline float power_heuristic(float pdf_a, float pdf_b) {
  // Compute the ratio first, because squares of large densities overflow.
  if (!(pdf_a > 0.0f)) return 0.0f;
  const float ratio = pdf_b / pdf_a;
  return 1.0f / (1.0f + ratio * ratio);
}

}  // namespace ajar
