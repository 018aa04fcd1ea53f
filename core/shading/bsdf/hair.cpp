#include "shading/bsdf/hair.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "shading/bsdf/huang.h"
#include "shading/models/fresnel.h"

namespace ajar::hair {
namespace {

// Members of Lobe that hair uses for something else: f0 is the absorption, alpha_x and alpha_y are v and s (or the
// roughnesses of a part of the Hair BSDF), roughness is v of R, f90.x is the tilt (or the offset), f90.y says whether
// the tilt turns the light, frame.s is the tangent. The frame is not orthonormal.

Fiber fiber_of(const Lobe& lobe, bool flipped) {
  return {lobe.f0,           lobe.eta, lobe.alpha_x, lobe.roughness, lobe.alpha_y, flipped ? -lobe.f90.x : lobe.f90.x,
          lobe.f90.y != 0.0f};
}

float power(float x, int n) {
  float result = 1.0f;
  for (; n > 0; n >>= 1, x *= x)
    if (n & 1) result *= x;
  return result;
}

float logistic_cdf(float x, float s) { return 1.0f / (1.0f + std::exp(std::min(-x / s, 80.0f))); }

/// Logistic distribution of an angle, cut off at +-pi.
float azimuthal(float phi, float s) {
  const float e = std::exp(-std::abs(phi) / s);
  return e / (s * sqr(1.0f + e) * (1.0f - 2.0f * logistic_cdf(-kPi, s)));
}
float sample_azimuthal(float u, float s) {
  const float low = logistic_cdf(-kPi, s), p = std::max(low + u * (1.0f - 2.0f * low), 1e-30f);
  return glm::clamp(-s * std::log(std::max(1.0f / p - 1.0f, 1e-30f)), -kPi, kPi);
}

float wrapped(float angle) { return angle - 2.0f * kPi * std::floor((angle + kPi) / (2.0f * kPi)); }

/// The model of Chiang et al. for one direction of the eye.
class Chiang {
 public:
  static constexpr int kLobes = 4;  // R, TT, TRT and the remainder

  Chiang(const Fiber& fiber, Vec3 tangent, Vec3 ng, Vec3 eye) : fiber_(fiber), around_(tangent, eye) {
    eye_ = Inclination::of(glm::dot(tangent, eye));
    // The point on the side of the eye.
    if (glm::dot(ng, eye) < 0.0f) ng = -ng;
    const float h = glm::clamp(-glm::dot(ng, around_.aside), -1.0f, 1.0f), cos_gamma = safe_sqrt(1.0f - sqr(h));
    gamma_ = std::asin(h);
    const float modified = std::sqrt(std::max(sqr(fiber.eta) - sqr(eye_.sine), 1e-12f));
    gamma_inside_ = std::asin(glm::clamp(h * eye_.cosine / modified, -1.0f, 1.0f));
    const float cos_inside = std::max(Inclination::of(eye_.sine / fiber.eta).cosine, 1e-4f);
    const Color through = glm::exp(-fiber.absorption * (2.0f * std::max(std::cos(gamma_inside_), 0.0f) / cos_inside));
    const float f = fresnel::dielectric(eye_.cosine * cos_gamma, fiber.eta);
    attenuation_[0] = Color(f);
    attenuation_[1] = sqr(1.0f - f) * through;
    attenuation_[2] = attenuation_[1] * through * f;
    const Color left = 1.0f - through * f;
    for (int i = 0; i < 3; ++i)
      attenuation_[3][i] = left[i] > 1e-6f ? attenuation_[2][i] * through[i] * f / left[i] : 0.0f;
    float sum = 0.0f;
    for (int p = 0; p < kLobes; ++p) sum += share_[p] = luminance(attenuation_[p]);
    for (float& share : share_) share = sum > 0.0f ? share / sum : 0.0f;
  }

  struct Value {
    Color value{0.0f};
    float pdf = 0.0f, pdf_reflected = 0.0f;
  };
  Value evaluate(Vec3 light) const {
    const Inclination theta = Inclination::of(glm::dot(around_.tangent, light));
    const float phi = around_.azimuth(light);
    Value sum;
    for (int p = 0; p < kLobes; ++p) {
      const float around = p < 3 ? azimuthal(wrapped(phi - exit(p)), fiber_.azimuthal) : 0.5f * kInvPi;
      const float density = longitudinal(theta, tilted(eye_, p), variance(p)) * around;
      sum.pdf += share_[p] * density;
      sum.value += attenuation_[p] *
                   (fiber_.turns_light ? longitudinal(tilted(theta, p), eye_, variance(p)) * around : density);
      if (p == 0) sum.pdf_reflected = sum.pdf;
    }
    return sum;
  }
  Vec3 sample(float u_branch, Vec2 u, bool& reflected) const {
    int p = 0;
    while (p + 1 < kLobes && u_branch >= share_[p]) u_branch -= share_[p++];
    u_branch = share_[p] > 0.0f ? std::min(u_branch / share_[p], kOneMinusEpsilon) : 0.0f;
    reflected = p == 0;
    const float sine = sample_longitudinal(tilted(eye_, p), variance(p), u_branch, u.y);
    return around_.direction(sine, p < 3 ? exit(p) + sample_azimuthal(u.x, fiber_.azimuthal) : 2.0f * kPi * u.x);
  }

 private:
  float variance(int p) const {
    return p == 0 ? fiber_.longitudinal_first : p == 1 ? 0.25f * fiber_.longitudinal : 4.0f * fiber_.longitudinal;
  }
  /// An inclination, turned by the tilt of the scales.
  Inclination tilted(Inclination theta, int p) const {
    constexpr float kTurns[] = {2.0f, -1.0f, -4.0f, 0.0f};
    return p == 3 || fiber_.tilt == 0.0f ? theta : theta.turned(kTurns[p] * fiber_.tilt);
  }
  /// The azimuth at which light leaves that takes p ways inside a smooth fibre.
  float exit(int p) const { return 2.0f * float(p) * gamma_inside_ - 2.0f * gamma_ + float(p) * kPi; }

  const Fiber& fiber_;
  Around around_;
  Inclination eye_;
  float gamma_, gamma_inside_;
  std::array<Color, kLobes> attenuation_;
  std::array<float, kLobes> share_;
};

/// One of the parts of the Hair BSDF for one direction of the eye. The inclination halfway between light and eye has a
/// Cauchy distribution around the offset.
class Part {
 public:
  Part(const Lobe& lobe, bool flipped, Vec3 eye)
      : transmission_(lobe.kind == LobeKind::HairTransmission),
        width_(lobe.alpha_x),
        width_around_(lobe.alpha_y),
        offset_(flipped ? -lobe.f90.x : lobe.f90.x),
        around_(lobe.frame.s, eye) {
    eye_ = std::asin(glm::clamp(glm::dot(lobe.frame.s, eye), -1.0f, 1.0f));
    low_ = std::atan((0.5f * (eye_ - 0.5f * kPi) - offset_) / width_);
    high_ = std::atan((0.5f * (eye_ + 0.5f * kPi) - offset_) / width_);
    high_ = std::max(high_, low_ + 1e-6f);  // far offsets leave no difference in floating point
    range_ = 2.0f * std::atan(0.5f * kPi / width_around_);
  }

  float density(Vec3 light) const {
    const float theta = std::asin(glm::clamp(glm::dot(around_.tangent, light), -1.0f, 1.0f));
    const float phi = std::abs(around_.azimuth(light));
    if (0.5f * kPi - std::abs(theta) < 0.001f || (transmission_ && phi < 0.5f * kPi)) return 0.0f;
    const float from_offset = 0.5f * (theta + eye_) - offset_;
    const float longitudinal = width_ / (2.0f * (sqr(from_offset) + sqr(width_)) * (high_ - low_) * std::cos(theta));
    if (transmission_) return longitudinal * width_around_ / (range_ * (sqr(kPi - phi) + sqr(width_around_)));
    if (phi >= kPi * width_around_) return 0.0f;
    return longitudinal * std::cos(0.5f * phi / width_around_) * 0.25f / width_around_;
  }
  Vec3 sample(Vec2 u) const {
    const float theta = 2.0f * (width_ * std::tan(low_ + u.x * (high_ - low_)) + offset_) - eye_;
    const float phi = transmission_ ? kPi + width_around_ * std::tan(range_ * (u.y - 0.5f))
                                    : 2.0f * width_around_ * std::asin(glm::clamp(1.0f - 2.0f * u.y, -1.0f, 1.0f));
    return around_.direction(std::sin(theta), phi);
  }

 private:
  bool transmission_;
  float width_, width_around_, offset_, eye_, low_, high_, range_;
  Around around_;
};

Lobe make(LobeKind kind, Color weight, Vec3 normal, Vec3 tangent) {
  Lobe lobe;
  lobe.kind = kind;
  lobe.weight = weight;
  lobe.ignores_eye = true;
  lobe.frame.n = normal;
  const float length = glm::length(tangent);
  lobe.frame.s = length > 0.0f && std::isfinite(length) ? tangent / length : Frame(normal).s;
  return lobe;
}

}  // namespace

float longitudinal_variance(float roughness) {
  return sqr(0.726f * roughness + 0.812f * sqr(roughness) + 3.7f * power(roughness, 20));
}

float azimuthal_scale(float roughness) {
  const float unit = std::sqrt(kPi / 8.0f);  // of a logistic distribution with the variance of a Gaussian one
  return unit * (0.265f * roughness + 1.194f * sqr(roughness) + 5.372f * power(roughness, 22));
}

namespace {
float albedo_exponent(float roughness) {
  const float x = roughness;
  return 5.969f + x * (-0.215f + x * (2.532f + x * (-10.73f + x * (5.574f + x * 0.245f))));
}
}  // namespace

Color absorption_of_color(Color color, float azimuthal_roughness) {
  const Color root = glm::log(glm::max(color, 1e-10f)) / albedo_exponent(azimuthal_roughness);
  return root * root;
}

Color absorption_of_melanin(float eumelanin, float pheomelanin) {
  return eumelanin * Color(0.506f, 0.841f, 1.653f) + pheomelanin * Color(0.343f, 0.733f, 1.924f);
}

Lobe chiang_lobe(Color weight, Vec3 ng, Vec3 tangent, const Fiber& fiber) {
  Lobe lobe = make(LobeKind::HairChiang, weight, ng, tangent);
  lobe.f0 = glm::max(fiber.absorption, 0.0f);
  lobe.eta = fiber.eta;
  lobe.alpha_x = fiber.longitudinal;
  lobe.alpha_y = fiber.azimuthal;
  lobe.roughness = fiber.longitudinal_first;
  lobe.f90.x = fiber.tilt;
  lobe.f90.y = fiber.turns_light ? 1.0f : 0.0f;
  return lobe;
}

Lobe part_lobe(bool transmission, Color weight, Vec3 normal, Vec3 tangent, float roughness_u, float roughness_v,
               float offset) {
  Lobe lobe = make(transmission ? LobeKind::HairTransmission : LobeKind::HairReflection, weight, normal, tangent);
  lobe.alpha_x = glm::clamp(roughness_u, 0.001f, 1.0f);
  lobe.alpha_y = glm::clamp(roughness_v, 0.001f, 1.0f);
  lobe.f90.x = offset;
  return lobe;
}

LobeValue evaluate(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode, bool flipped) {
  const bool radiance = mode == TransportMode::Radiance;
  const Vec3 n = lobe.frame.n, eye = radiance ? wo : wi, light = radiance ? wi : wo;
  LobeValue result;
  if (lobe.kind == LobeKind::HairChiang) {
    const Fiber fiber = fiber_of(lobe, flipped);
    const Chiang::Value value = Chiang(fiber, lobe.frame.s, n, eye).evaluate(light);
    result = {lobe.weight * value.value, radiance ? value.pdf : Chiang(fiber, lobe.frame.s, n, wo).evaluate(wi).pdf};
  } else if (lobe.kind == LobeKind::HairHuang) {
    const float turn = flipped ? -1.0f : 1.0f;
    const Huang::Value value = Huang(lobe, turn * eye).evaluate(turn * light);
    result = {lobe.weight * value.value, radiance ? value.pdf : Huang(lobe, turn * wo).evaluate(turn * wi).pdf};
  } else {
    const float density = Part(lobe, flipped, eye).density(light);
    result = {lobe.weight * density, radiance ? density : Part(lobe, flipped, wo).density(wi)};
  }
  if (!radiance) result.f_cos *= std::abs(glm::dot(n, wi)) / std::max(std::abs(glm::dot(n, wo)), 1e-6f);
  return result;
}

bool sample(const Lobe& lobe, Vec3 wo, float u_branch, Vec2 u, bool flipped, LobeSample& sample) {
  if (lobe.kind == LobeKind::HairChiang) {
    bool reflected;
    const Fiber fiber = fiber_of(lobe, flipped);
    sample.wi = Chiang(fiber, lobe.frame.s, lobe.frame.n, wo).sample(u_branch, u, reflected);
    sample.flags = kGlossy | (reflected ? kReflection : kTransmission);
  } else if (lobe.kind == LobeKind::HairHuang) {
    const float turn = flipped ? -1.0f : 1.0f;
    if (!Huang(lobe, turn * wo).sample(u_branch, u, sample.wi)) return false;
    sample.wi *= turn;
    sample.flags = kGlossy | kReflection;
  } else {
    sample.wi = Part(lobe, flipped, wo).sample(u);
    sample.flags = kGlossy | (lobe.kind == LobeKind::HairReflection ? kReflection : kTransmission);
  }
  sample.eta = 1.0f;
  const float alpha = std::max(lobe.alpha_x, 0.0f);
  sample.roughness = lobe.kind == LobeKind::HairHuang ? std::sqrt(alpha) : std::sqrt(std::sqrt(alpha));
  return is_finite(sample.wi);
}

Color albedo(const Lobe& lobe, float cos_wo) {
  if (lobe.kind != LobeKind::HairChiang && lobe.kind != LobeKind::HairHuang) return Color(1.0f);
  const float reflected = fresnel::dielectric(saturate(std::abs(cos_wo)), lobe.eta);
  return glm::min(glm::exp(-glm::sqrt(lobe.f0) * albedo_exponent(lobe.alpha_x)) + reflected, 1.0f);
}

float reflected_share(const Lobe& lobe, Vec3 wo, Vec3 wi, bool flipped) {
  if (lobe.kind != LobeKind::HairChiang) return lobe.kind == LobeKind::HairTransmission ? 0.0f : 1.0f;
  const Chiang::Value value = Chiang(fiber_of(lobe, flipped), lobe.frame.s, lobe.frame.n, wo).evaluate(wi);
  return value.pdf > 0.0f ? value.pdf_reflected / value.pdf : 1.0f;
}

}  // namespace ajar::hair
