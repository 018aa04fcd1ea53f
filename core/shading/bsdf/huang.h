// The microfacet model of hair of Huang, Hullin and Hanika 2022, "A Microfacet-based Hair Scattering Model".
//
// A fibre is an elliptic cylinder of dielectric whose surface has GGX facets around normals that the scales of the
// cuticle tilt. Light is reflected (R), passes through two boundaries (TT), or is reflected once inside (TRT); what
// takes longer ways leaves with the longitudinal distribution of Chiang et al. 2016. Each boundary is compensated for
// the light that single scattering loses there.
//
// The eye sees the fibre at one offset h (near field). For it, TT and TRT are integrals over the facets of all
// boundaries but the last. A lobe replaces them by means over kNodes facets, which a hash of the position chooses: a
// mixture of refraction lobes, whose density is exact. The mean over positions is the model.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "shading/bsdf/lobe.h"

namespace ajar::hair {

// ---- Directions around a fibre, and the distribution of the inclination of scattered light, also for hair.cpp ----

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

// ---- The model ----

struct RoughFiber {
  Color absorption{0.0f};  ///< per major radius
  float eta = 1.55f;       ///< index of refraction
  float alpha = 0.3f;      ///< of the GGX facets
  float aspect = 1.0f;     ///< minor over major radius, 0 to 1
  float tilt = 0.0f;       ///< of the scales towards the root, in radians
  Vec3 factors{1.0f};      ///< of R, TT and TRT
  Vec3 major{0.0f};        ///< direction of the major axis; only used if aspect < 1
  uint32_t seed = 0;       ///< hash of the position
};
Lobe huang_lobe(Color weight, Vec3 ng, Vec3 tangent, const RoughFiber& fiber);
/// Whether rays along `w` miss the ellipse at a point of the round fibre around it.
bool misses_ellipse(Vec3 ng, Vec3 tangent, Vec3 major, float aspect, Vec3 w);

/// The lobe for one direction of the eye.
class Huang {
 public:
  Huang(const Lobe& lobe, Vec3 eye);

  struct Value {
    Color value{0.0f};
    float pdf = 0.0f;
  };
  Value evaluate(Vec3 light) const;
  /// Returns false if there is no direction for these random numbers.
  bool sample(float u_branch, Vec2 u, Vec3& light) const;

 private:
  static constexpr int kNodes = 4;

  /// A rough boundary, and light that arrives at it from direction `from`. Normals are on its side.
  struct Boundary {
    Vec3 from, normal, flat;  ///< flat: the normal without the tilt
    float cosine = 0.0f;      ///< between from and normal
    Color weight{0.0f};       ///< of the light that leaves here
    float share = 0.0f;       ///< of the samples
  };
  struct Node {
    Boundary second, third;  ///< where TT and TRT leave
    Color remainder{0.0f};   ///< weight of longer ways
    float remainder_share = 0.0f;
  };

  Vec3 to_local(Vec3 w) const { return {glm::dot(w, x_), glm::dot(w, y_), glm::dot(w, z_)}; }
  Vec3 normal_at(float gamma, float tilt) const;
  float gamma_of_chord(float azimuth) const;
  Color absorbed(float gamma_a, float gamma_b, Vec3 way) const;
  Vec3 sample_facet(Vec3 from, Vec3 normal, Vec2 u) const;
  float facets(float cosine) const;
  float masking_ratio(float cos_in, float cos_out) const;
  float compensation(float cosine, float eta) const;
  float leave(const Boundary& boundary, Vec3 light, float& passed) const;
  void trace(Node& node, const float* u) const;
  void place(Vec3 ng, Vec3 eye);

  const Lobe& lobe_;
  float alpha_, eta_, aspect_, tilt_;
  Vec3 x_, y_, z_, eye_;  // the local axes (y along the fibre, x along the major axis), the eye in them
  float gamma_ = 0.0f;    // where the eye meets the ellipse
  bool missed_ = false;   // it does not
  Vec3 normal_, flat_;    // at the first boundary
  float cosine_ = 0.0f, compensation_ = 1.0f, share_reflected_ = 0.0f;
  std::array<Node, kNodes> nodes_;
};

}  // namespace ajar::hair
