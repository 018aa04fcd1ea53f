#include "shading/bsdf/closures.h"

#include <algorithm>
#include <cmath>

#include "shading/bsdf/closure_parts.h"
#include "shading/models/albedo_table.h"
#include "shading/models/fresnel.h"

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
  const float outer_eta = std::max(lobe.eta, 1.0f / lobe.eta);
  if (compensation == Compensation::Mixed) lobe.correlated = true;
  float mean = lobe.correlated ? albedo_table::ggx_correlated_mean(alpha) : albedo_table::ggx_mean(alpha);
  if (lobe.kind == LobeKind::MicrofacetGlass)
    mean = lobe.correlated ? albedo_table::ggx_glass_correlated_mean(alpha, outer_eta)
                           : albedo_table::ggx_glass_mean(alpha, outer_eta);
  mean_fresnel = glm::clamp(mean_fresnel, 0.0f, 1.0f);
  lobe.compensation = compensation;
  lobe.multiple_scattering = mean_fresnel * mean / (1.0f - mean_fresnel * (1.0f - mean));
  if (lobe.fresnel != FresnelKind::None) lobe.mean_fresnel = mean_fresnel;  // otherwise the weight contains it
}

float eta_from_ior(const Surface& surface, float ior) {
  const float eta = std::max(ior, 1e-5f);
  return surface.backfacing ? 1.0f / eta : eta;
}

void add_diffuse(Bsdf& bsdf, const Surface&, Color weight, Vec3 normal, float roughness, Color albedo,
                 bool keeps_normal) {
  Lobe lobe = make_lobe(LobeKind::Diffuse, weight, normal);
  lobe.roughness = roughness < 1e-5f ? 0.0f : saturate(roughness);
  lobe.f0 = glm::clamp(albedo, 0.0f, 1.0f);
  lobe.ignores_eye = keeps_normal;
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

void add_toon(Bsdf& bsdf, Color weight, Vec3 normal, bool glossy, float size, float smooth, bool keeps_normal) {
  Lobe lobe = make_lobe(glossy ? LobeKind::ToonGlossy : LobeKind::ToonDiffuse, weight, normal);
  lobe.alpha_x = saturate(size) * 0.5f * kPi;
  lobe.alpha_y = saturate(smooth) * 0.5f * kPi;
  lobe.ignores_eye = keeps_normal && !glossy;
  if (lobe.alpha_x + lobe.alpha_y > 0.0f) bsdf.add(lobe);
}

void add_subsurface(Bsdf& bsdf, const Surface&, Color weight, Vec3 normal, const SubsurfaceMedium& medium,
                    uint8_t layers) {
  constexpr float kMinRadius = 1e-8f;
  Color shallow(0.0f);
  for (int i = 0; i < 3; ++i) {
    if (medium.radius[i] >= kMinRadius && medium.albedo[i] > 0.0f) continue;
    shallow[i] = weight[i];
    weight[i] = 0.0f;
  }
  const LobeKind kind = medium.fresnel ? LobeKind::PrincipledDiffuse : LobeKind::Diffuse;
  Lobe lobe = make_lobe(kind, shallow, normal);
  lobe.layers = layers;
  bsdf.add(lobe);
  lobe.weight = weight;
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

SubsurfaceMedium make_medium(const SubsurfaceInputs& inputs) {
  using Method = SubsurfaceMethod;
  SubsurfaceMedium medium;
  medium.albedo = inputs.albedo;
  medium.van_de_hulst = inputs.method == Method::Refracted;
  // The fit for the reduced medium does not know negative anisotropies.
  medium.anisotropy = medium.van_de_hulst ? std::clamp(inputs.anisotropy, -0.99f, 0.99f)
                                          : std::clamp(inputs.anisotropy, 0.0f, 0.9f);
  medium.profile = inputs.method == Method::Burley;
  medium.eta = std::clamp(inputs.ior, 1.01f, 3.8f);
  medium.alpha = inputs.method == Method::Skin ? 1.0f : saturate(inputs.alpha);
  if (inputs.method == Method::Skin) medium.entry = SubsurfaceEntry::Mixed;
  if (inputs.method == Method::Refracted || inputs.method == Method::RefractedFixedRadius)
    medium.entry = SubsurfaceEntry::Refracted;
  // Diffuse reflectance of the boundary from inside: the rational fit of Egan and Hilgeman.
  const float inside = 1.0f / medium.eta;
  const float fdr = inside * (-1.440f * inside + 0.710f) + 0.668f + 0.0636f * medium.eta;
  const float boundary = (4.0f / 3.0f) * (1.0f + fdr) / (1.0f - fdr);
  for (int i = 0; i < 3; ++i) {
    float factor = 1.0f;
    if (inputs.method == Method::RandomWalk || inputs.method == Method::Skin)
      factor = std::sqrt(3.0f * (1.0f - dipole_albedo(inputs.albedo[i], boundary)));
    else if (inputs.method != Method::Refracted)
      factor = 0.25f * kInvPi;
    medium.radius[i] = std::max(inputs.radius[i], 0.0f) * factor;
  }
  return medium;
}

void add_transparent(Bsdf& bsdf, Color weight) { bsdf.add(make_lobe(LobeKind::Transparent, weight, bsdf.n)); }

void add_portal(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 position, Vec3 direction) {
  Lobe lobe = make_lobe(LobeKind::Transparent, weight, bsdf.n);
  const float size = max_component(glm::abs(direction));
  lobe.portal = true;
  lobe.f0 = position;
  lobe.f90 = size > 0.0f ? glm::normalize(direction / size) : -surface.wo;
  if (!(size > 0.0f)) bsdf.bind_to_view();
  bsdf.add(lobe);
}

void add_glossy(Bsdf& bsdf, const Surface&, Color weight, Vec3 normal, const Facets& facets,
                const Anisotropy& anisotropy) {
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, weight, normal);
  lobe.microfacet = microfacet_of(facets.distribution);
  lobe.correlated = facets.correlated;
  const float alpha = facets.distribution == Distribution::Sharp ? 0.0f : sqr(facets.roughness);
  const float amount = std::clamp(anisotropy.amount, -0.99f, 0.99f);
  if (amount < 0.0f)
    set_roughness(lobe, alpha / (1.0f + amount), alpha * (1.0f + amount));
  else
    set_roughness(lobe, alpha * (1.0f - amount), alpha / (1.0f - amount));
  if (lobe.alpha_x != lobe.alpha_y) set_tangent(lobe, anisotropy.tangent, anisotropy.rotation);
  if (facets.distribution == Distribution::MultiGgx)
    compensate(lobe, facets.correlated ? Compensation::Scaled : Compensation::Mixed, weight);
  bsdf.add(lobe);
}

void set_principled_anisotropy(Lobe& lobe, float roughness, const Anisotropy& anisotropy) {
  const float aspect = safe_sqrt(1.0f - 0.9f * saturate(anisotropy.amount)), alpha = sqr(roughness);
  set_roughness(lobe, alpha / aspect, alpha * aspect);
  if (lobe.alpha_x != lobe.alpha_y) set_tangent(lobe, anisotropy.tangent, anisotropy.rotation);
}

void add_metallic(Bsdf& bsdf, Color weight, Vec3 normal, const Facets& facets, const Anisotropy& anisotropy,
                  const Metal& metal, uint8_t layers) {
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, weight, normal);
  lobe.layers = layers;
  lobe.microfacet = microfacet_of(facets.distribution);
  lobe.correlated = facets.correlated;
  set_principled_anisotropy(lobe, saturate(facets.roughness), anisotropy);
  lobe.film = metal.film;
  Color f0 = metal.color_or_n, dip = metal.tint_or_k;  // of the F82 curve
  lobe.fresnel = metal.is_conductor ? FresnelKind::Conductor : FresnelKind::F82Tint;
  if (metal.is_conductor) {
    lobe.f0 = f0;
    lobe.f90 = dip;
    f0 = fresnel::conductor(1.0f, lobe.f0, lobe.f90);
    dip = fresnel::f82_coefficient_of(f0, fresnel::conductor(fresnel::kF82Cosine, lobe.f0, lobe.f90));
  } else {
    lobe.f0 = f0 = glm::clamp(f0, 0.0f, 1.0f);
    lobe.f90 = dip = fresnel::f82_coefficient(f0, glm::clamp(dip, 0.0f, 1.0f));
  }
  if (facets.distribution == Distribution::MultiGgx) compensate(lobe, Compensation::Scaled, fresnel::f82_mean(f0, dip));
  bsdf.add(lobe);
}

void add_sheen(Bsdf& bsdf, Color weight, Vec3 normal, float roughness, bool keeps_normal) {
  Lobe lobe = make_lobe(LobeKind::MicrofiberSheen, weight, normal);
  lobe.ignores_eye = keeps_normal;
  lobe.roughness = saturate(roughness);
  bsdf.add(lobe);
}

void set_film(Lobe& lobe, const Surface& surface, const ThinFilm& film, float ior) {
  lobe.film = film;
  if (surface.backfacing) lobe.film.ior /= ior;
}

namespace {

void set_boundary(Lobe& lobe, const Surface& surface, const RoughBoundary& boundary) {
  lobe.microfacet = microfacet_of(boundary.distribution);
  const float alpha = boundary.distribution == Distribution::Sharp ? 0.0f : sqr(boundary.roughness);
  set_roughness(lobe, alpha, alpha);
  lobe.eta = eta_from_ior(surface, boundary.ior);
  lobe.correlated = boundary.correlated;
  set_film(lobe, surface, boundary.film, boundary.ior);
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
  const bool at_facets = boundary.correlated && reflects;
  const LobeKind kind = (reflects && refracts) || compensated || at_facets ? LobeKind::MicrofacetGlass
                        : reflects                                         ? LobeKind::MicrofacetReflection
                                                                           : LobeKind::MicrofacetRefraction;
  Lobe lobe = make_lobe(kind, weight, normal);
  set_boundary(lobe, surface, boundary);
  if (compensated || at_facets) {
    lobe.fresnel = FresnelKind::DielectricTint;
    lobe.f0 = Color(fresnel::f0_from_eta(boundary.ior));
    if (!refracts) lobe.transmission_tint = Color(0.0f);
    if (compensated) compensate(lobe, Compensation::Scaled, weight);
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
