#include "shading/bsdf/huang.h"

#include <algorithm>
#include <cmath>

#include "math/random.h"
#include "shading/models/albedo_table.h"
#include "shading/models/fresnel.h"
#include "shading/models/microfacet.h"

namespace ajar::hair {
namespace {

// Members of Lobe that this model uses for something else: f0 is the absorption, alpha_x is alpha, alpha_y is the ratio
// of the axes, f90.x is the tilt, f90.y the hash of the position in [0, 1), transmission_tint has the factors, frame.s is
// the tangent, frame.t the major axis. The frame is not orthonormal.

/// Powers of the root of x^7 = x + 1, whose multiples are well distributed in six dimensions (Roberts 2018).
constexpr int kDimensions = 6;
constexpr float kSteps[kDimensions] = {0.89865371f, 0.80757850f, 0.72573341f, 0.65218303f, 0.58608670f, 0.52668899f};
/// The least probability of passing a boundary in the shares of the samples.
constexpr float kLeastPassed = 0.05f;
/// The share of samples in all directions. For an eye where a walk from a light goes, the facets are others than those
/// that sampled the direction.
constexpr float kBroad = 0.15f;
/// Offsets nearer to the rim are moved there.
constexpr float kRim = 0.9999f;
/// Where samples start for an eye that misses the ellipse. The value is 0 there, but walks from lights ask for samples.
constexpr float kRimOfSamples = 0.9f;

float fraction(float x) { return std::min(x - std::floor(x), kOneMinusEpsilon); }

/// The azimuth of the normal at the parameter gamma of an ellipse (sin gamma, aspect cos gamma).
float azimuth_of(float gamma, float aspect) {
  return aspect == 1.0f ? gamma : std::atan2(aspect * std::sin(gamma), std::cos(gamma));
}
/// The offset of a ray along `w` (unit, local), as a fraction of the projected radius, at a point of the round fibre with
/// the normal `ng`.
float offset_over_radius(Vec3 w, Vec3 ng, float aspect) {
  const float across = std::sqrt(sqr(w.x) + sqr(w.z));
  if (!(across > 1e-6f)) return 0.0f;
  const float h = -(w.z * ng.x - w.x * ng.z) / across;
  return h / std::sqrt(std::max(1.0f - (1.0f - sqr(aspect)) * sqr(w.x / across), 1e-12f));
}

}  // namespace

Lobe huang_lobe(Color weight, Vec3 ng, Vec3 tangent, const RoughFiber& fiber) {
  Lobe lobe;
  lobe.kind = LobeKind::HairHuang;
  lobe.weight = weight;
  lobe.ignores_eye = true;
  lobe.frame.n = ng;
  const float length = glm::length(tangent);
  lobe.frame.s = length > 0.0f && std::isfinite(length) ? tangent / length : Frame(ng).s;
  lobe.f0 = glm::max(fiber.absorption, 0.0f);
  lobe.eta = fiber.eta;
  lobe.alpha_x = glm::clamp(fiber.alpha, 0.001f, 1.0f);
  lobe.alpha_y = glm::clamp(fiber.aspect, 0.001f, 1.0f);
  lobe.f90.x = fiber.tilt;
  lobe.f90.y = float(fiber.seed >> 8) * 0x1p-24f;
  lobe.transmission_tint = glm::max(fiber.factors, 0.0f);
  lobe.frame.t = fiber.major;
  return lobe;
}

bool misses_ellipse(Vec3 ng, Vec3 tangent, Vec3 major, float aspect, Vec3 w) {
  const Vec3 y = glm::normalize(tangent), x = glm::normalize(major - y * glm::dot(major, y)), z = glm::cross(x, y);
  const auto local = [&](Vec3 v) { return Vec3(glm::dot(v, x), glm::dot(v, y), glm::dot(v, z)); };
  return !(std::abs(offset_over_radius(local(w), local(ng), aspect)) < 1.0f);
}

Huang::Huang(const Lobe& lobe, Vec3 eye)
    : lobe_(lobe), alpha_(lobe.alpha_x), eta_(lobe.eta), aspect_(lobe.alpha_y), tilt_(-lobe.f90.x), y_(lobe.frame.s) {
  place(lobe.frame.n, eye);
  cosine_ = glm::dot(normal_, eye_);
  if (!(cosine_ > 0.0f) || !(glm::dot(flat_, eye_) > 0.0f)) {
    cosine_ = 0.0f;
    return;
  }
  compensation_ = compensation(cosine_, eta_);
  share_reflected_ = lobe.transmission_tint.x * fresnel::dielectric(std::min(cosine_, 1.0f), eta_);
  float sum = share_reflected_;
  const uint32_t seed = uint32_t(lobe.f90.y * 0x1p24f);
  float turn[kDimensions];
  for (uint32_t j = 0; j < uint32_t(kDimensions); ++j) turn[j] = float(hash_combine(seed, j) >> 8) * 0x1p-24f;
  for (int k = 0; k < kNodes; ++k) {
    float u[kDimensions];
    for (int j = 0; j < kDimensions; ++j) u[j] = fraction(turn[j] + float(k) * kSteps[j]);
    Node& node = nodes_[size_t(k)];
    trace(node, u);
    sum += node.second.share + node.third.share + node.remainder_share;
  }
  if (!(sum > 0.0f && std::isfinite(sum))) {
    cosine_ = 0.0f;
    return;
  }
  const float scale = (1.0f - kBroad) / sum;
  share_reflected_ *= scale;
  for (Node& node : nodes_) {
    for (float* share : {&node.second.share, &node.third.share, &node.remainder_share}) *share *= scale;
    node.remainder_share += kBroad / float(kNodes);
  }
}

/// The local axes, and the place that the eye sees. The axes of a round fibre follow that place.
void Huang::place(Vec3 ng, Vec3 eye) {
  if (glm::dot(ng, eye) < 0.0f) ng = -ng;
  if (aspect_ < 1.0f) {
    x_ = lobe_.frame.t - y_ * glm::dot(lobe_.frame.t, y_);
    const float length = glm::length(x_);
    x_ = length > 1e-6f ? x_ / length : Frame(y_).s;
    z_ = glm::cross(x_, y_);
    eye_ = to_local(eye);
    float offset = offset_over_radius(eye_, to_local(ng), aspect_);
    missed_ = !(std::abs(offset) < 1.0f);
    if (missed_) offset = std::copysign(kRimOfSamples, offset);
    gamma_ = std::atan2(eye_.z, -aspect_ * eye_.x) - std::acos(glm::clamp(-offset, -kRim, kRim));
  } else {
    z_ = ng - y_ * glm::dot(ng, y_);
    const float length = glm::length(z_);
    z_ = length > 1e-6f ? z_ / length : Frame(y_).s;
    x_ = glm::cross(y_, z_);
    eye_ = to_local(eye);
  }
  flat_ = normal_at(gamma_, 0.0f);
  normal_ = normal_at(gamma_, tilt_);
}

Vec3 Huang::normal_at(float gamma, float tilt) const {
  const float phi = azimuth_of(gamma, aspect_), s = std::sin(tilt), c = std::cos(tilt);
  return {std::sin(phi) * c, s, std::cos(phi) * c};
}

/// Half the sum of the parameters of the ends of a chord with this azimuth, up to a quarter turn.
float Huang::gamma_of_chord(float azimuth) const { return azimuth_of(azimuth, aspect_); }

/// The transmittance along a chord between two places of the ellipse, for light of this direction.
Color Huang::absorbed(float gamma_a, float gamma_b, Vec3 way) const {
  const float dx = std::sin(gamma_a) - std::sin(gamma_b), dz = aspect_ * (std::cos(gamma_a) - std::cos(gamma_b));
  const float across = std::max(std::sqrt(sqr(way.x) + sqr(way.z)), 1e-4f);
  return glm::exp(-lobe_.f0 * (std::sqrt(sqr(dx) + sqr(dz)) / across));
}

Vec3 Huang::sample_facet(Vec3 from, Vec3 normal, Vec2 u) const {
  const Frame frame(normal);
  return frame.to_world(microfacet::ggx_sample_visible(frame.to_local(from), alpha_, alpha_, u));
}

/// The distribution of facets, for the cosine to their normal.
float Huang::facets(float cosine) const {
  if (!(cosine > 0.0f)) return 0.0f;
  const float a2 = sqr(alpha_), sin2 = std::max(1.0f - sqr(cosine), 0.0f);
  return kInvPi * a2 / sqr(sin2 + a2 * sqr(cosine));
}

/// G(in, out) / G1(in) of correlated masking.
float Huang::masking_ratio(float cos_in, float cos_out) const {
  const auto slope = [&](float c) {
    const float c2 = std::max(sqr(c), 1e-12f);
    return std::sqrt(1.0f + sqr(alpha_) * std::max(1.0f / c2 - 1.0f, 0.0f));
  };
  const float in = slope(cos_in), out = slope(cos_out);
  return (1.0f + in) / (in + out);
}

float Huang::compensation(float cosine, float eta) const {
  return 1.0f / std::max(albedo_table::ggx_glass_correlated(saturate(cosine), alpha_, eta), 1e-3f);
}

/// The ways of light that enters at one facet: out through the second boundary, or reflected there and out at the third.
void Huang::trace(Node& node, const float* u) const {
  const Vec3 facet = sample_facet(eye_, normal_, {u[0], u[1]});
  const float cos_facet = glm::dot(eye_, facet), inverse = 1.0f / eta_;
  Vec3 into;
  if (!(cos_facet > 0.0f) || !fresnel::refract(eye_, facet, eta_, into)) return;
  Boundary& second = node.second;
  second.from = -into;
  const float cos_into = glm::dot(second.from, normal_), chord = gamma_of_chord(std::atan2(into.x, into.z));
  if (!(cos_into > 0.0f) || !(glm::dot(second.from, flat_) > 0.0f)) return;
  const float gamma_second = 2.0f * chord - gamma_;
  second.normal = normal_at(gamma_second, -tilt_);
  second.flat = normal_at(gamma_second, 0.0f);
  second.cosine = glm::dot(second.from, second.normal);
  if (!(second.cosine > 0.0f)) return;
  const Color through = absorbed(gamma_, gamma_second + kPi, into);
  const float entered = 1.0f - fresnel::dielectric(std::min(cos_facet, 1.0f), eta_);
  const Vec3 factors = lobe_.transmission_tint;
  const auto passed = [&](float cosine) {
    return std::max(1.0f - fresnel::dielectric(std::min(cosine, 1.0f), inverse), kLeastPassed);
  };
  constexpr float kEach = 1.0f / float(kNodes);
  const Color arrives = through * (kEach * entered * compensation_ * masking_ratio(cosine_, cos_into) *
                                   compensation(second.cosine, inverse));
  second.weight = arrives * factors.y;
  second.share = luminance(second.weight) * passed(second.cosine);

  if (!(factors.z > 0.0f)) return;
  const Vec3 inner = sample_facet(second.from, second.normal, {u[2], u[3]});
  const float cos_inner = glm::dot(second.from, inner);
  if (!(cos_inner > 0.0f)) return;
  const float reflected = fresnel::dielectric(std::min(cos_inner, 1.0f), inverse);
  Boundary& third = node.third;
  third.from = second.from - 2.0f * cos_inner * inner;  // against the way of the light
  const float cos_reflected = -glm::dot(third.from, second.normal);
  if (!(cos_reflected > 0.0f) || !(-glm::dot(third.from, second.flat) > 0.0f)) return;
  const float gamma_third = gamma_ - 2.0f * (chord - gamma_of_chord(std::atan2(third.from.x, third.from.z))) + kPi;
  third.normal = normal_at(gamma_third, -tilt_);
  third.flat = normal_at(gamma_third, 0.0f);
  third.cosine = glm::dot(third.from, third.normal);
  if (!(third.cosine > 0.0f)) return;
  const Color back = absorbed(gamma_second, gamma_third, third.from);
  const Color there = arrives * back *
                      (reflected * masking_ratio(second.cosine, cos_reflected) * compensation(third.cosine, inverse));
  third.weight = there * factors.z;
  third.share = luminance(third.weight) * passed(third.cosine);
  // All longer ways: a geometric series with the mean absorption and reflectance of the ways so far.
  const Color mean = glm::sqrt(through * back);
  const Vec3 last = sample_facet(third.from, third.normal, {u[4], u[5]});
  const float cos_last = glm::dot(third.from, last);
  if (!(cos_last > 0.0f)) return;
  const float again = fresnel::dielectric(std::min(cos_last, 1.0f), inverse);
  const float cos_again = glm::dot(2.0f * cos_last * last - third.from, third.normal);
  if (!(cos_again > 0.0f)) return;
  const float leaves = std::max(1.0f - 0.5f * (reflected + again), 1e-5f);
  node.remainder = there * mean * (again * leaves * masking_ratio(third.cosine, cos_again)) /
                   (1.0f - mean * (1.0f - leaves));
  node.remainder_share = luminance(node.remainder);
}

/// The density of light that leaves through facets of a boundary, and the fraction of it that passes.
float Huang::leave(const Boundary& boundary, Vec3 light, float& passed) const {
  const float inverse = 1.0f / eta_;
  const Vec3 sum = boundary.from + inverse * light;
  const float length2 = length_squared(sum);
  if (!(length2 > 1e-12f)) return 0.0f;
  Vec3 facet = sum / std::sqrt(length2);
  if (glm::dot(facet, boundary.normal) < 0.0f) facet = -facet;
  const float cos_in = glm::dot(boundary.from, facet), cos_out = -glm::dot(light, facet);
  const float cos_light = -glm::dot(light, boundary.normal);
  if (!(cos_in > 0.0f && cos_out > 0.0f && cos_light > 0.0f && glm::dot(light, boundary.flat) < 0.0f)) return 0.0f;
  const float masking = 2.0f / (boundary.cosine +
                                std::sqrt(sqr(boundary.cosine) + sqr(alpha_) * (1.0f - sqr(boundary.cosine))));
  passed = (1.0f - fresnel::dielectric(std::min(cos_in, 1.0f), inverse)) * masking_ratio(boundary.cosine, cos_light);
  return facets(glm::dot(facet, boundary.normal)) * masking * cos_in * sqr(inverse) * cos_out / length2;
}

Huang::Value Huang::evaluate(Vec3 light) const {
  Value sum;
  if (!(cosine_ > 0.0f)) return sum;
  light = to_local(light);
  const Vec3 half = eye_ + light;
  const float length = glm::length(half);
  if (share_reflected_ > 0.0f && length > 1e-6f && glm::dot(flat_, light) > 0.0f) {
    const Vec3 facet = half / length;
    const float cos_facet = glm::dot(eye_, facet), cos_normal = glm::dot(facet, normal_);
    if (cos_facet > 0.0f && cos_normal > 0.0f) {
      const float masking = 2.0f / (cosine_ + std::sqrt(sqr(cosine_) + sqr(alpha_) * (1.0f - sqr(cosine_))));
      const float density = 0.25f * facets(cos_normal) * masking;
      sum.pdf = share_reflected_ * density;
      sum.value = Color(lobe_.transmission_tint.x * fresnel::dielectric(std::min(cos_facet, 1.0f), eta_) *
                        compensation_ * masking_ratio(cosine_, glm::dot(normal_, light)) * density);
    }
  }
  const float around = 0.5f * kInvPi * longitudinal(Inclination::of(light.y), Inclination::of(eye_.y), 4.0f * alpha_);
  for (const Node& node : nodes_) {
    for (const Boundary* boundary : {&node.second, &node.third}) {
      if (!(boundary->share > 0.0f)) continue;
      float passed = 0.0f;
      const float density = leave(*boundary, light, passed);
      sum.pdf += boundary->share * density;
      sum.value += boundary->weight * (passed * density);
    }
    sum.pdf += node.remainder_share * around;
    sum.value += node.remainder * around;
  }
  if (missed_) sum.value = Color(0.0f);
  return sum;
}

bool Huang::sample(float u_branch, Vec2 u, Vec3& light) const {
  if (!(cosine_ > 0.0f)) return false;
  const auto takes = [&](float share) {
    if (u_branch < share) {
      u_branch = std::min(u_branch / share, kOneMinusEpsilon);
      return true;
    }
    u_branch -= share;
    return false;
  };
  const auto to_world = [&](Vec3 w) { return glm::normalize(w.x * x_ + w.y * y_ + w.z * z_); };
  if (takes(share_reflected_)) {
    const Vec3 facet = sample_facet(eye_, normal_, u), out = 2.0f * glm::dot(eye_, facet) * facet - eye_;
    light = to_world(out);
    return glm::dot(flat_, out) > 0.0f;
  }
  for (const Node& node : nodes_) {
    for (const Boundary* boundary : {&node.second, &node.third}) {
      if (!takes(boundary->share)) continue;
      Vec3 out;
      if (!fresnel::refract(boundary->from, sample_facet(boundary->from, boundary->normal, u), 1.0f / eta_, out))
        return false;
      light = to_world(out);
      float passed;
      return leave(*boundary, out, passed) > 0.0f;  // other ways may have a density there
    }
    if (!takes(node.remainder_share)) continue;
    const float sine = sample_longitudinal(Inclination::of(eye_.y), 4.0f * alpha_, u_branch, u.y);
    const float cosine = safe_sqrt(1.0f - sqr(sine)), phi = 2.0f * kPi * u.x;
    light = to_world({std::sin(phi) * cosine, sine, std::cos(phi) * cosine});
    return true;
  }
  return false;
}

}  // namespace ajar::hair
