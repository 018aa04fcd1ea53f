// Directions around a fibre, and the distribution of the inclination of scattered light (hair.h).
#pragma once

#include <algorithm>
#include <cmath>

#include "math/frame.h"

namespace ajar::hair {

/// exp(-x) I0(x) for x >= 0 (Abramowitz and Stegun 1964, 9.8.1 and 9.8.2).
inline float scaled_bessel_i0(float x) {
  if (x < 3.75f) {
    const float t = sqr(x / 3.75f);
    const float i0 = 1.0f +
                     t * (3.5156229f +
                          t * (3.0899424f + t * (1.2067492f + t * (0.2659732f + t * (0.0360768f + t * 0.0045813f)))));
    return std::exp(-x) * i0;
  }
  const float t = 3.75f / x;
  const float sum = 0.39894228f +
                    t * (0.01328592f +
                         t * (0.00225319f + t * (-0.00157565f +
                                                 t * (0.00916281f + t * (-0.02057706f +
                                                                         t * (0.02635537f + t * (-0.01647633f +
                                                                                                 t * 0.00392377f)))))));
  return sum / std::sqrt(x);
}

/// Sine and cosine of an inclination.
struct Inclination {
  float sine, cosine;
  static Inclination of(float sine) {
    sine = glm::clamp(sine, -1.0f, 1.0f);
    return {sine, safe_sqrt(1.0f - sqr(sine))};
  }
  /// Turned by an angle, kept between the poles.
  Inclination turned(float angle) const {
    const float s = std::sin(angle), c = std::cos(angle);
    return {sine * c + cosine * s, std::abs(cosine * c - sine * s)};
  }
};

/// Density of the inclination of the light per sine, for the variance v (d'Eon et al. 2011, eq. 7). Its integral over
/// the sphere is 2 pi.
inline float longitudinal(Inclination light, Inclination eye, float v) {
  const float a = light.cosine * eye.cosine / v, b = light.sine * eye.sine / v;
  return scaled_bessel_i0(a) * std::exp(a - b - 1.0f / v) / (v * (1.0f - std::exp(-2.0f / v)));
}
inline float sample_longitudinal(Inclination eye, float v, float u, float u_around) {
  const float x = std::max(u, 1e-5f);
  const float cosine = 1.0f + v * std::log(x + (1.0f - x) * std::exp(-2.0f / v));
  return -cosine * eye.sine + safe_sqrt(1.0f - sqr(cosine)) * std::cos(2.0f * kPi * u_around) * eye.cosine;
}

/// An orthonormal basis around a fibre: the tangent, the eye's direction across it, and the third direction.
struct Around {
  Vec3 tangent, towards, aside;
  Around(Vec3 tangent, Vec3 eye) : tangent(tangent) {
    towards = eye - tangent * glm::dot(tangent, eye);
    const float length = glm::length(towards);
    towards = length > 1e-6f ? towards / length : Frame(tangent).s;
    aside = glm::cross(tangent, towards);
  }
  float azimuth(Vec3 w) const { return std::atan2(glm::dot(w, aside), glm::dot(w, towards)); }
  Vec3 direction(float sine, float phi) const {
    const Inclination theta = Inclination::of(sine);
    return glm::normalize(tangent * theta.sine + (towards * std::cos(phi) + aside * std::sin(phi)) * theta.cosine);
  }
};

}  // namespace ajar::hair
