// The weight of a sample that another method could have drawn, too.
#pragma once

#include <limits>

namespace ajar {

/// Power heuristic with exponent 2, without small weights, for two densities of the same measure [Veach 1997, eq. 9.12
/// and 9.13]. A density of less than a tenth of the other has the weight 0. Its weight would be below 1 %, but such
/// samples are rare. Their noise can be many times that of the well stratified samples of the other method.
inline float power_heuristic(float pdf_a, float pdf_b) {
  constexpr float kCutoff = 0.1f;
  // Compute the ratio first, because squares of large densities overflow.
  if (!(pdf_a > 0.0f)) return 0.0f;
  const float ratio = pdf_b / pdf_a;
  if (ratio < kCutoff) return 1.0f;
  if (ratio * kCutoff > 1.0f) return 0.0f;
  return 1.0f / (1.0f + ratio * ratio);
}

/// The density of light samples as it counts in the heuristic against BSDF samples. That of lamps counts twice: the
/// contribution varies little over a lamp, so that its stratified samples have less noise than hits, which are a matter
/// of chance. It is not so for the world (infinite `distance`), which can have any radiance. Where only one of the two
/// methods finds a light, its weights define how much of the light is seen, and lamps must count `once`.
inline float counted_light_pdf(float pdf, float distance, bool once) {
  return !once && distance < std::numeric_limits<float>::infinity() ? 2.0f * pdf : pdf;
}

}  // namespace ajar
