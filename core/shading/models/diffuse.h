// Diffuse reflection: values of f, and the factor on bumped surfaces. Cosines are to the normal of the lobe;
// `cos_between` is the cosine of the angle between both directions.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "description/bump_terminator.h"
#include "math/types.h"
#include "shading/models/fresnel.h"

namespace ajar {

/// The Oren-Nayar model in the form of Fujii 2012 ("A tiny improvement of Oren-Nayar reflectance model"), with the light
/// that bounces more than once between facets of colour `albedo` (OpenPBR 1.1, "Glossy-diffuse slab"). A black albedo
/// gives single scattering alone.
struct OrenNayar {
  float sigma, scale;

  explicit OrenNayar(float roughness)
      : sigma(roughness), scale(1.0f / (kPi + ((3.0f * kPi - 4.0f) / 6.0f) * roughness)) {}

  float single(float cos_o, float cos_i, float cos_between) const {
    float t = cos_between - cos_o * cos_i;
    if (t > 0.0f) t /= std::max({cos_o, cos_i, std::numeric_limits<float>::min()});
    return scale * (1.0f + sigma * t);
  }
  /// The fraction of white light that single scattering reflects.
  float reflected(float cosine) const {
    const float sine = safe_sqrt(1.0f - cosine * cosine), angle = std::acos(std::min(cosine, 1.0f));
    // (1 - sin^3) / cos, by its series where the difference cancels.
    const float grazing = cosine < 1e-3f ? 1.5f * cosine : (1.0f - sine * sine * sine) / cosine;
    const float g = sine * (angle - 2.0f / 3.0f - sine * cosine) + (2.0f / 3.0f) * sine * grazing;
    return scale * (kPi + sigma * g);
  }
  Color multiple(Color albedo, float cos_o, float cos_i) const {
    const float mean = scale * (kPi + sigma * (2.0f * kPi - 5.6f) / 3.0f);
    const float lost = (1.0f - reflected(cos_o)) * (1.0f - reflected(cos_i));
    return albedo * albedo * (kInvPi * mean / (1.0f - mean) * lost) / (1.0f - albedo * (1.0f - mean));
  }
};

/// Burley 2015, sections 2.2 (Lambert with Fresnel) and 2.3 (retro-reflection).
inline float principled_diffuse(float roughness, float cos_o, float cos_i, float cos_between) {
  const float fo = fresnel::schlick(cos_o), fi = fresnel::schlick(cos_i);
  const float rr = roughness * (cos_between + 1.0f);
  return kInvPi * ((1.0f - 0.5f * fo) * (1.0f - 0.5f * fi) + rr * (fo + fi + fo * fi * (rr - 1.0f)));
}

/// The second summand of principled_diffuse (retro-reflection) alone.
inline float principled_retro(float roughness, float cos_o, float cos_i, float cos_between) {
  const float fo = fresnel::schlick(cos_o), fi = fresnel::schlick(cos_i);
  const float rr = roughness * (cos_between + 1.0f);
  return kInvPi * rr * (fo + fi + fo * fi * (rr - 1.0f));
}

/// [Conty Estevez, Lecocq and Stein 2019, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem",
/// section 12.3]: the light is shadowed by a GGX distribution whose width makes the bumped normal one in eight.
inline float microfacet_bump_shadowing(Vec3 n, Vec3 bumped, Vec3 light) {
  const float cos_light = glm::dot(n, light), cos_bump = glm::dot(n, bumped);
  // Without this test, light from the other side of the smooth surface would pass through it.
  if (cos_light * cos_bump * glm::dot(bumped, light) < 0.0f) return 0.0f;
  const float c2 = sqr(cos_light), d2 = sqr(cos_bump);
  if (c2 >= 1.0f || d2 >= 1.0f) return 1.0f;
  if (c2 < 1e-12f || d2 < 1e-12f) return 0.0f;
  const float alpha2 = saturate(0.125f * (1.0f / d2 - 1.0f));
  return 2.0f / (1.0f + std::sqrt(1.0f + alpha2 * (1.0f / c2 - 1.0f)));
}

/// Factor on a diffuse lobe whose normal `bumped` differs from the surface's normal `n`. `light` is the direction
/// towards the light.
inline float bump_shadowing(BumpTerminator terminator, Vec3 n, Vec3 bumped, Vec3 light) {
  if (terminator == BumpTerminator::None) return 1.0f;
  if (terminator == BumpTerminator::Microfacet) return microfacet_bump_shadowing(n, bumped, light);
  const float cos_light = glm::dot(bumped, light);
  if (cos_light < 0.0f) n = -n;
  const float denominator = cos_light * glm::dot(n, bumped);
  const float g = denominator != 0.0f ? glm::dot(n, light) / denominator : 0.0f;
  if (g >= 1.0f) return 1.0f;
  if (g < 0.0f) return 0.0f;
  return g * (1.0f + g - g * g);
}

}  // namespace ajar
