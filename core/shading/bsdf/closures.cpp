#include "shading/bsdf/closures.h"

#include <algorithm>
#include <cmath>

#include "shading/bsdf/albedo_table.h"
#include "shading/bsdf/closure_parts.h"

namespace ajar::closures {

Lobe make_lobe(LobeKind kind, Color weight, Vec3 normal) {
  Lobe lobe;
  lobe.kind = kind;
  lobe.weight = weight;
  lobe.frame = Frame(normal);
  return lobe;
}

Vec3 rotate_about(Vec3 v, Vec3 axis, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return c * v + s * glm::cross(axis, v) + (1.0f - c) * glm::dot(axis, v) * axis;
}

void set_roughness(Lobe& lobe, float alpha_x, float alpha_y) {
  lobe.alpha_x = saturate(alpha_x);
  lobe.alpha_y = saturate(alpha_y);
}

void set_tangent(Lobe& lobe, Vec3 tangent, float rotation) {
  if (rotation != 0.0f) tangent = rotate_about(tangent, lobe.frame.n, rotation * 2.0f * kPi);
  lobe.frame = Frame(lobe.frame.n, tangent);
}

Microfacet microfacet_of(Distribution distribution) {
  switch (distribution) {
    case Distribution::Beckmann: return Microfacet::Beckmann;
    case Distribution::AshikhminShirley: return Microfacet::AshikhminShirley;
    default: return Microfacet::Ggx;
  }
}

void compensate(Lobe& lobe, Compensation compensation, Color mean_fresnel) {
  if (lobe.is_delta()) return;
  const float alpha = std::sqrt(lobe.alpha_x * lobe.alpha_y);
  // For glass, the mean for the outer side is used for both sides, so that light and eye see the same lobe.
  const float mean = lobe.kind == LobeKind::MicrofacetGlass
                         ? albedo_table::ggx_glass_mean(alpha, std::max(lobe.eta, 1.0f / lobe.eta))
                     : compensation == Compensation::Mixed ? albedo_table::ggx_correlated_mean(alpha)
                                                           : albedo_table::ggx_mean(alpha);
  mean_fresnel = glm::clamp(mean_fresnel, 0.0f, 1.0f);
  lobe.compensation = compensation;
  lobe.multiple_scattering = mean_fresnel * mean / (1.0f - mean_fresnel * (1.0f - mean));
  if (lobe.fresnel != FresnelKind::None) lobe.mean_fresnel = mean_fresnel;  // otherwise the weight contains it
}

float eta_from_ior(const Surface& surface, float ior) {
  const float eta = std::max(ior, 1e-5f);
  return surface.backfacing ? 1.0f / eta : eta;
}

void add_diffuse(Bsdf& bsdf, const Surface&, Color weight, Vec3 normal, float roughness) {
  Lobe lobe = make_lobe(LobeKind::Diffuse, weight, normal);
  lobe.roughness = saturate(roughness);
  bsdf.add(lobe);
}

void add_translucent(Bsdf& bsdf, const Surface&, Color weight, Vec3 normal) {
  bsdf.add(make_lobe(LobeKind::Translucent, weight, normal));
}

void add_velvet(Bsdf& bsdf, const Surface&, Color weight, Vec3 normal, float sigma) {
  Lobe lobe = make_lobe(LobeKind::Velvet, weight, normal);
  lobe.roughness = sigma;
  bsdf.add(lobe);
}

void add_toon(Bsdf& bsdf, const Surface&, Color weight, Vec3 normal, bool glossy, float size, float smooth) {
  Lobe lobe = make_lobe(glossy ? LobeKind::ToonGlossy : LobeKind::ToonDiffuse, weight, normal);
  lobe.alpha_x = saturate(size) * 0.5f * kPi;
  lobe.alpha_y = saturate(smooth) * 0.5f * kPi;
  if (lobe.alpha_x + lobe.alpha_y > 0.0f) bsdf.add(lobe);
}

void add_subsurface(Bsdf& bsdf, const Surface&, Color weight, Vec3 normal, const SubsurfaceMedium& medium) {
  constexpr float kMinRadius = 1e-8f;
  Color shallow(0.0f);
  for (int i = 0; i < 3; ++i) {
    if (medium.radius[i] >= kMinRadius && medium.albedo[i] > 0.0f) continue;
    shallow[i] = weight[i];
    weight[i] = 0.0f;
  }
  const LobeKind kind = medium.fresnel ? LobeKind::PrincipledDiffuse : LobeKind::Diffuse;
  bsdf.add(make_lobe(kind, shallow, normal));
  Lobe lobe = make_lobe(kind, weight, normal);
  lobe.subsurface = true;
  bsdf.add(lobe);
}

namespace {

/// The albedo of single scattering for which a dipole reflects `reflectance` [Jensen et al. 2001, eq. 15], by bisection
/// with as many steps as in Cycles.
float dipole_albedo(float reflectance, float boundary) {
  if (reflectance < 1e-4f) return 0.0f;
  if (reflectance >= 0.995f) return 0.999999f;
  float low = 0.0f, high = 1.0f, middle = 0.5f;
  for (int i = 0; i < 12; ++i) {
    middle = 0.5f * (low + high);
    const float s = std::sqrt(3.0f * (1.0f - middle));
    const float found = 0.5f * middle * (1.0f + std::exp(-boundary * s)) * std::exp(-s);
    (found < reflectance ? low : high) = middle;
  }
  return middle;
}

}  // namespace

SubsurfaceMedium make_medium(Color albedo, Color radius, float anisotropy, float ior, SubsurfaceMethod method) {
  SubsurfaceMedium medium;
  medium.albedo = albedo;
  medium.anisotropy = std::clamp(anisotropy, 0.0f, 0.9f);
  const float eta = std::clamp(ior, 1.01f, 3.8f), inside = 1.0f / eta;
  // Diffuse reflectance of the boundary from inside: the rational fit of Egan and Hilgeman.
  const float fdr = inside * (-1.440f * inside + 0.710f) + 0.668f + 0.0636f * eta;
  const float boundary = (4.0f / 3.0f) * (1.0f + fdr) / (1.0f - fdr);
  for (int i = 0; i < 3; ++i)
    medium.radius[i] = std::max(radius[i], 0.0f) *
                       (method == SubsurfaceMethod::FixedRadius
                            ? 0.25f * kInvPi
                            : std::sqrt(3.0f * (1.0f - dipole_albedo(albedo[i], boundary))));
  return medium;
}

void add_transparent(Bsdf& bsdf, Color weight) { bsdf.add(make_lobe(LobeKind::Transparent, weight, bsdf.n)); }

void add_glossy(Bsdf& bsdf, const Surface&, Color weight, Vec3 normal, Distribution distribution, float roughness,
                const Anisotropy& anisotropy) {
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, weight, normal);
  lobe.microfacet = microfacet_of(distribution);
  const float alpha = distribution == Distribution::Sharp ? 0.0f : sqr(roughness);
  const float amount = std::clamp(anisotropy.amount, -0.99f, 0.99f);
  if (amount < 0.0f)
    set_roughness(lobe, alpha / (1.0f + amount), alpha * (1.0f + amount));
  else
    set_roughness(lobe, alpha * (1.0f - amount), alpha / (1.0f - amount));
  if (lobe.alpha_x != lobe.alpha_y) set_tangent(lobe, anisotropy.tangent, anisotropy.rotation);
  if (distribution == Distribution::MultiGgx) compensate(lobe, Compensation::Mixed, weight);
  bsdf.add(lobe);
}

namespace {

void set_boundary(Lobe& lobe, const Surface& surface, const RoughBoundary& boundary) {
  lobe.microfacet = microfacet_of(boundary.distribution);
  const float alpha = boundary.distribution == Distribution::Sharp ? 0.0f : sqr(boundary.roughness);
  set_roughness(lobe, alpha, alpha);
  lobe.eta = eta_from_ior(surface, boundary.ior);
}

}  // namespace

void add_refraction(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, const RoughBoundary& boundary) {
  Lobe lobe = make_lobe(LobeKind::MicrofacetRefraction, weight, normal);
  set_boundary(lobe, surface, boundary);
  bsdf.add(lobe);
}

void add_glass(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, const RoughBoundary& boundary,
               bool reflects, bool refracts) {
  if (!reflects && !refracts) return;
  const bool compensated = boundary.distribution == Distribution::MultiGgx && reflects;
  const LobeKind kind = (reflects && refracts) || compensated ? LobeKind::MicrofacetGlass
                        : reflects                            ? LobeKind::MicrofacetReflection
                                                              : LobeKind::MicrofacetRefraction;
  Lobe lobe = make_lobe(kind, weight, normal);
  set_boundary(lobe, surface, boundary);
  if (compensated) {
    lobe.fresnel = FresnelKind::Dielectric;
    if (!refracts) lobe.transmission_tint = Color(0.0f);
    compensate(lobe, Compensation::Scaled, weight);
  } else {
    lobe.normal_fresnel = reflects ? NormalFresnel::Reflected : NormalFresnel::Transmitted;
  }
  bsdf.add(lobe);
}

// If the normal is at angle a from ng in the plane of ng and ns, the mirror direction of wo has the cosine r cos(2 a -
// d) to ng, where (r, d) are the polar coordinates of wo in that plane. Solved for the largest a that is not beyond ns.
Vec3 bend_shading_normal(Vec3 ng, Vec3 wo, Vec3 ns) {
  const float cos_ng = glm::dot(ng, wo);
  const float lowest = std::min(0.9f * cos_ng, 0.01f);
  if (glm::dot(2.0f * glm::dot(ns, wo) * ns - wo, ng) >= lowest) return ns;
  const Vec3 tangent = ns - glm::dot(ns, ng) * ng;
  const float length = std::sqrt(length_squared(tangent));
  if (!(length > 1e-6f)) return ng;
  const Vec3 x = tangent / length;
  const float wo_x = glm::dot(wo, x), r = std::sqrt(wo_x * wo_x + cos_ng * cos_ng);
  if (!(r > 1e-6f)) return ng;
  const float angle = 0.5f * (std::atan2(wo_x, cos_ng) + std::acos(std::clamp(lowest / r, -1.0f, 1.0f)));
  return std::cos(angle) * ng + std::sin(angle) * x;
}

}  // namespace ajar::closures
