#include "shading/bsdf/lobe.h"

#include <algorithm>
#include <cmath>

#include "math/warps.h"
#include "shading/bsdf/albedo_table.h"
#include "shading/bsdf/fresnel.h"
#include "shading/bsdf/microfacet.h"
#include "shading/bsdf/sheen.h"
#include "shading/bsdf/toon.h"

namespace ajar {
namespace {

bool is_delta_roughness(const Lobe& lobe) { return lobe.alpha_x * lobe.alpha_y <= kDeltaAlphaProduct; }

/// For a wo on the other side of the surface, the index is inverted, unless it only shapes a reflection.
float eta_from(const Lobe& lobe, bool flipped) {
  const bool shapes_reflection = lobe.kind == LobeKind::MicrofacetReflection &&
                                 lobe.normal_fresnel == NormalFresnel::None;
  return flipped && !shapes_reflection ? 1.0f / lobe.eta : lobe.eta;
}

bool is_index_matched(float eta) { return std::abs(eta - 1.0f) < 1e-4f; }

/// The Oren-Nayar model in Fujii's form, which Cycles uses.
float oren_nayar(float sigma, float cos_o, float cos_i, float cos_between) {
  const float scale = 1.0f / (kPi + ((3.0f * kPi - 4.0f) / 6.0f) * sigma);
  float t = cos_between - cos_o * cos_i;
  if (t > 0.0f) t /= std::max(cos_o, cos_i);
  return scale * (1.0f + sigma * t);
}

/// Burley 2015, sections 2.2 (Lambert with Fresnel) and 2.3 (retro-reflection).
float principled_diffuse(float roughness, float cos_o, float cos_i, float cos_between) {
  const float fo = fresnel::schlick(cos_o), fi = fresnel::schlick(cos_i);
  const float rr = roughness * (cos_between + 1.0f);
  return kInvPi * ((1.0f - 0.5f * fo) * (1.0f - 0.5f * fi) + rr * (fo + fi + fo * fi * (rr - 1.0f)));
}

/// The second summand of principled_diffuse (retro-reflection) alone.
float principled_retro(float roughness, float cos_o, float cos_i, float cos_between) {
  const float fo = fresnel::schlick(cos_o), fi = fresnel::schlick(cos_i);
  const float rr = roughness * (cos_between + 1.0f);
  return kInvPi * rr * (fo + fi + fo * fi * (rr - 1.0f));
}

Color fresnel_color(const Lobe& lobe, float cosine, float eta) {
  switch (lobe.fresnel) {
    case FresnelKind::DielectricTint: return glm::mix(lobe.f0, lobe.f90, fresnel::dielectric_position(cosine, eta));
    case FresnelKind::Dielectric: return Color(fresnel::dielectric(cosine, eta));
    case FresnelKind::F82Tint: return fresnel::f82(cosine, lobe.f0, lobe.f90);
    case FresnelKind::None: break;
  }
  return Color(1.0f);
}

/// The reflected and transmitted fractions of a glass lobe. They depend on the facet, or only on n if light is split
/// there.
struct Split {
  Color reflected, transmitted;
  float probability_reflected;
};
Split split_glass(const Lobe& lobe, float cos_facet, float cos_normal, float eta) {
  const bool at_normal = lobe.normal_fresnel != NormalFresnel::None;
  const float f = fresnel::dielectric(at_normal ? cos_normal : cos_facet, eta);
  Split split;
  if (at_normal || lobe.fresnel != FresnelKind::DielectricTint) {
    split = {Color(f), (1.0f - f) * lobe.transmission_tint, f};
    // If light is split at n, importance weights both parts by the reflectance that the eye sees. Either part can then
    // be large.
    if (at_normal && !lobe.delta) split.probability_reflected = std::clamp(f, 0.02f, 0.95f);
  } else {
    split.reflected = glm::mix(lobe.f0, lobe.f90, fresnel::dielectric_position(cos_facet, eta));
    split.transmitted = f < 1.0f ? glm::max(1.0f - split.reflected, 0.0f) * lobe.transmission_tint : Color(0.0f);
  }
  const float r = luminance(split.reflected), t = luminance(split.transmitted);
  // Both parts keep a minimum share, so that no colour makes one of them rare with large weights.
  if (!at_normal && f < 1.0f && r + t > 0.0f)
    split.probability_reflected = std::clamp(r / (r + t), 0.5f * f, 0.5f + 0.5f * f);
  if (!at_normal && f >= 1.0f) split.probability_reflected = 1.0f;
  return split;
}

float density_of_normal(const Lobe& lobe, Vec3 m) {
  switch (lobe.microfacet) {
    case Microfacet::Ggx: return microfacet::ggx_density(m, lobe.alpha_x, lobe.alpha_y);
    case Microfacet::Beckmann: return microfacet::beckmann_density(m, lobe.alpha_x, lobe.alpha_y);
    case Microfacet::Gtr1: return microfacet::gtr1_density(m, lobe.alpha_x);
    case Microfacet::AshikhminShirley: return microfacet::ashikhmin_shirley_density(m, lobe.alpha_x, lobe.alpha_y);
  }
  return 0.0f;
}

float masking_over_cos(const Lobe& lobe, Vec3 w) {
  switch (lobe.microfacet) {
    case Microfacet::Beckmann: return microfacet::beckmann_masking_over_cos(w, lobe.alpha_x, lobe.alpha_y);
    case Microfacet::Gtr1: return microfacet::ggx_masking_over_cos(w, 0.25f, 0.25f);  // fixed value of Burley 2012
    default: return microfacet::ggx_masking_over_cos(w, lobe.alpha_x, lobe.alpha_y);
  }
}

Vec3 sample_normal(const Lobe& lobe, Vec3 wo, Vec2 u) {
  switch (lobe.microfacet) {
    case Microfacet::Ggx: break;
    case Microfacet::Beckmann: return microfacet::beckmann_sample_visible(wo, lobe.alpha_x, lobe.alpha_y, u);
    case Microfacet::Gtr1: return microfacet::gtr1_sample(lobe.alpha_x, u);
    case Microfacet::AshikhminShirley: return microfacet::ashikhmin_shirley_sample(lobe.alpha_x, lobe.alpha_y, u);
  }
  return microfacet::ggx_sample_visible(wo, lobe.alpha_x, lobe.alpha_y, u);
}

/// Compensation of the light that is lost between facets, in the shape of single scattering (Turquin 2019), for the
/// eye's direction.
Color scaled_compensation(const Lobe& lobe, float cos_eye, float eta_eye) {
  const float alpha = std::sqrt(lobe.alpha_x * lobe.alpha_y);
  const float albedo = lobe.kind == LobeKind::MicrofacetGlass ? albedo_table::ggx_glass(cos_eye, alpha, eta_eye)
                                                              : albedo_table::ggx(cos_eye, alpha);
  return 1.0f + lobe.multiple_scattering * ((1.0f - albedo) / albedo);
}

/// The same light, divided by roughness between that shape and a nearly diffuse, reciprocal one (Kulla and Conty 2017).
/// Light that bounces between smooth facets stays near the mirror direction; between rough facets it leaves in any
/// direction.
struct MixedCompensation {
  float scale;          ///< factor on single scattering, minus 1
  float diffuse;        ///< value of the diffuse part times the cosine
  float diffuse_share;  ///< fraction of the samples that are drawn from the diffuse part
};
MixedCompensation mixed_compensation(const Lobe& lobe, float cos_o, float cos_i, float cos_eye) {
  const float alpha = std::sqrt(lobe.alpha_x * lobe.alpha_y), diffuse = std::sqrt(alpha);
  const float lost_o = 1.0f - albedo_table::ggx_correlated(cos_o, alpha),
              lost_i = 1.0f - albedo_table::ggx_correlated(cos_i, alpha);
  const float lost_mean = std::max(1.0f - albedo_table::ggx_correlated_mean(alpha), 1e-6f);
  const float lost_eye = cos_eye == cos_o ? lost_o : lost_i;
  return {(1.0f - diffuse) * lost_eye / (1.0f - lost_eye), diffuse * kInvPi * cos_i * lost_o * lost_i / lost_mean,
          diffuse * lost_o};
}

float normal_fresnel(const Lobe& lobe, float cos_eye, float eta_eye) {
  if (lobe.normal_fresnel == NormalFresnel::None) return 1.0f;
  const float f = fresnel::dielectric(cos_eye, eta_eye);
  return lobe.normal_fresnel == NormalFresnel::Reflected ? f : 1.0f - f;
}

LobeValue reflect_microfacet(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode, float eta) {
  const Vec3 sum = wo + wi;
  const float length = std::sqrt(length_squared(sum));
  if (!(length > 0.0f)) return {};
  const Vec3 m = sum / length;
  const float cos_facet = std::min(glm::dot(wo, m), 1.0f);
  const float cos_eye = mode == TransportMode::Radiance ? wo.z : wi.z;
  const float density = density_of_normal(lobe, m);
  float f_cos, pdf;
  if (lobe.microfacet == Microfacet::AshikhminShirley) {
    pdf = density / (4.0f * cos_facet);
    f_cos = pdf * wi.z / std::max(wo.z, wi.z);
  } else {
    const float common = 0.25f * density * masking_over_cos(lobe, wo);
    f_cos = lobe.compensation == Compensation::Mixed
                ? 0.25f * density * wi.z * microfacet::ggx_correlated_over_cosines(wo, wi, lobe.alpha_x, lobe.alpha_y)
                : common * masking_over_cos(lobe, wi) * wi.z;
    pdf = lobe.microfacet == Microfacet::Gtr1 ? 0.25f * density * m.z / cos_facet : common;
  }
  Color color = lobe.weight * f_cos;
  if (lobe.kind == LobeKind::MicrofacetGlass) {
    const Split for_wo = split_glass(lobe, cos_facet, wo.z, eta);
    pdf *= for_wo.probability_reflected;
    color *= mode == TransportMode::Radiance ? for_wo.reflected : split_glass(lobe, cos_facet, wi.z, eta).reflected;
  } else {
    color *= fresnel_color(lobe, cos_facet, eta) * normal_fresnel(lobe, cos_eye, eta);
  }
  if (lobe.compensation == Compensation::Scaled) color *= scaled_compensation(lobe, cos_eye, eta);
  if (lobe.compensation == Compensation::Mixed) {
    const MixedCompensation added = mixed_compensation(lobe, wo.z, wi.z, cos_eye);
    color = color * (1.0f + lobe.multiple_scattering * added.scale) +
            lobe.weight * lobe.mean_fresnel * lobe.multiple_scattering * added.diffuse;
    pdf = glm::mix(pdf, wi.z * kInvPi, added.diffuse_share);
  }
  return {color, pdf};
}

/// Walter et al. 2007, eq. 21 and 17, with the numerator of the adjoint (see the section on refraction in bsdf.h).
LobeValue refract_microfacet(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode, float eta) {
  Vec3 sum = wo + eta * wi;
  const float length2 = length_squared(sum);
  if (!(length2 > 0.0f)) return {};
  Vec3 m = sum / std::sqrt(length2);
  if (m.z < 0.0f) m = -m;
  const float cos_o = glm::dot(wo, m), cos_i = glm::dot(wi, m);
  if (!(cos_o > 0.0f && cos_i < 0.0f)) return {};
  const float jacobian = eta * eta * -cos_i / sqr(cos_o + eta * cos_i);
  const float common = density_of_normal(lobe, m) * masking_over_cos(lobe, wo) * cos_o * jacobian;
  float f_cos = common * masking_over_cos(lobe, {wi.x, wi.y, -wi.z}) * -wi.z, pdf = common;
  const bool radiance = mode == TransportMode::Radiance;
  const float cos_eye = radiance ? wo.z : -wi.z, eta_eye = radiance ? eta : 1.0f / eta;
  if (!radiance) f_cos /= eta * eta;
  Color color = lobe.weight * f_cos;
  if (lobe.kind == LobeKind::MicrofacetGlass) {
    const Split for_wo = split_glass(lobe, cos_o, wo.z, eta);
    pdf *= 1.0f - for_wo.probability_reflected;
    color *= radiance ? for_wo.transmitted : split_glass(lobe, -cos_i, -wi.z, eta_eye).transmitted;
  } else {
    color *= normal_fresnel(lobe, cos_eye, eta_eye);
  }
  if (lobe.compensation == Compensation::Scaled) color *= scaled_compensation(lobe, cos_eye, eta_eye);
  return {color, pdf};
}

uint32_t glossy_or_specular(const Lobe& lobe) { return lobe.delta ? kSpecular : kGlossy; }

/// Reflects wo at the facet m (local frame), or at n for delta lobes.
bool sample_reflection(const Lobe& lobe, Vec3 wo, Vec3 m, LobeSample& sample) {
  const float cos_facet = glm::dot(wo, m);
  if (!(cos_facet > 0.0f)) return false;
  const Vec3 wi = 2.0f * cos_facet * m - wo;
  if (!(wi.z > 0.0f)) return false;
  sample.wi = lobe.frame.to_world(wi);
  sample.flags = kReflection | glossy_or_specular(lobe);
  sample.eta = 1.0f;
  return true;
}

bool sample_refraction(const Lobe& lobe, Vec3 wo, Vec3 m, float eta, LobeSample& sample) {
  Vec3 wi;
  if (!fresnel::refract(wo, m, eta, wi) || !(wi.z < 0.0f)) return false;
  sample.wi = lobe.frame.to_world(wi);
  sample.flags = kTransmission | glossy_or_specular(lobe);
  sample.eta = eta;
  return true;
}

bool sample_microfacet(const Lobe& lobe, Vec3 wo_world, float u_branch, Vec2 u, TransportMode mode, float eta,
                       LobeSample& sample) {
  const Vec3 wo = lobe.frame.to_local(wo_world);
  if (!(wo.z > 0.0f)) return false;
  const bool delta = lobe.delta;
  const Vec3 m = delta ? Vec3(0, 0, 1) : sample_normal(lobe, wo, u);
  const float cos_facet = std::min(glm::dot(wo, m), 1.0f);
  const float importance_scale = mode == TransportMode::Radiance ? 1.0f : 1.0f / (eta * eta);
  sample.roughness = delta ? 0.0f : std::sqrt(std::sqrt(lobe.alpha_x * lobe.alpha_y));
  sample.probability = 1.0f;
  switch (lobe.kind) {
    case LobeKind::MicrofacetReflection:
      if (lobe.compensation == Compensation::Mixed &&
          u_branch < mixed_compensation(lobe, wo.z, 1.0f, wo.z).diffuse_share) {
        sample.wi = lobe.frame.to_world(warp::square_to_cosine_hemisphere(u));
        sample.flags = kReflection | kGlossy;
        return true;
      }
      if (!sample_reflection(lobe, wo, m, sample)) return false;
      if (delta) sample.weight = lobe.weight * fresnel_color(lobe, wo.z, eta) * normal_fresnel(lobe, wo.z, eta);
      return true;
    case LobeKind::MicrofacetRefraction:
      if (!sample_refraction(lobe, wo, m, eta, sample)) return false;
      if (delta) sample.weight = lobe.weight * (normal_fresnel(lobe, wo.z, eta) * importance_scale);
      return true;
    default: {
      const Split split = split_glass(lobe, cos_facet, wo.z, eta);
      const bool reflect = u_branch < split.probability_reflected;
      sample.probability = reflect ? split.probability_reflected : 1.0f - split.probability_reflected;
      if (delta) sample.weight = lobe.weight * (reflect ? split.reflected : split.transmitted * importance_scale);
      return reflect ? sample_reflection(lobe, wo, m, sample) : sample_refraction(lobe, wo, m, eta, sample);
    }
  }
}

}  // namespace

bool Lobe::is_delta() const {
  switch (kind) {
    case LobeKind::Transparent: return true;
    case LobeKind::MicrofacetReflection: return is_delta_roughness(*this);
    case LobeKind::MicrofacetRefraction:
    case LobeKind::MicrofacetGlass: return is_delta_roughness(*this) || is_index_matched(eta);
    default: return false;
  }
}

LobeValue evaluate_lobe(const Lobe& lobe, Vec3 wo, Vec3 wi, bool reflection, TransportMode mode, bool flipped) {
  const float cos_o = glm::dot(lobe.frame.n, wo), cos_i = glm::dot(lobe.frame.n, wi);
  if (!(cos_o > 0.0f) || (reflection ? !(cos_i > 0.0f) : !(cos_i < 0.0f))) return {};
  const auto cosine_lobe = [&](float f) { return LobeValue{lobe.weight * (f * cos_i), cos_i * kInvPi}; };
  switch (lobe.kind) {
    case LobeKind::Diffuse:
      if (!reflection) return {};
      return cosine_lobe(lobe.roughness > 0.0f ? oren_nayar(lobe.roughness, cos_o, cos_i, glm::dot(wo, wi)) : kInvPi);
    case LobeKind::PrincipledDiffuse:
      if (!reflection) return {};
      return cosine_lobe(principled_diffuse(lobe.roughness, cos_o, cos_i, glm::dot(wo, wi)));
    case LobeKind::Sheen:
      if (!reflection) return {};
      return cosine_lobe(sheen::disney(glm::dot(wo, wi)));
    case LobeKind::MicrofiberSheen:
      if (!reflection) return {};
      return cosine_lobe(
          sheen::microfiber(lobe.roughness, lobe.frame.n, wo, wi, mode == TransportMode::Radiance ? cos_o : cos_i));
    case LobeKind::PrincipledRetro:
      if (!reflection) return {};
      return cosine_lobe(principled_retro(lobe.roughness, cos_o, cos_i, glm::dot(wo, wi)));
    case LobeKind::Velvet:
      if (!reflection) return {};
      return {lobe.weight * (sheen::velvet(lobe.roughness, lobe.frame.n, wo, wi) * cos_i),
              warp::hemisphere_pdf_solid_angle()};
    case LobeKind::ToonDiffuse:
    case LobeKind::ToonGlossy: {
      if (!reflection) return {};
      // The cosine between the light's direction and the axis of the cone. For importance, the light is at wo, and f is
      // multiplied by the cosine of the other direction.
      const bool glossy = lobe.kind == LobeKind::ToonGlossy, radiance = mode == TransportMode::Radiance;
      const float mirrored = 2.0f * cos_o * cos_i - glm::dot(wo, wi);
      const float value = toon::value(glossy     ? mirrored
                                      : radiance ? cos_i
                                                 : cos_o,
                                      lobe.alpha_x, lobe.alpha_y) *
                          (radiance ? 1.0f : cos_i / cos_o);
      const float pdf = toon::pdf_solid_angle(glossy ? mirrored : cos_i, lobe.alpha_x, lobe.alpha_y);
      return {lobe.weight * value, glossy ? pdf : 0.5f * (pdf + cos_i * kInvPi)};
    }
    case LobeKind::Translucent:
      if (reflection) return {};
      return {lobe.weight * (-cos_i * kInvPi), -cos_i * kInvPi};
    case LobeKind::MicrofacetReflection:
      if (!reflection) return {};
      break;
    case LobeKind::MicrofacetRefraction:
      if (reflection) return {};
      break;
    case LobeKind::MicrofacetGlass: break;
    case LobeKind::Transparent: return {};
  }
  const Vec3 local_o = lobe.frame.to_local(wo), local_i = lobe.frame.to_local(wi);
  const float eta = eta_from(lobe, flipped);
  return reflection ? reflect_microfacet(lobe, local_o, local_i, mode, eta)
                    : refract_microfacet(lobe, local_o, local_i, mode, eta);
}

bool sample_lobe(const Lobe& lobe, Vec3 wo, float u_branch, Vec2 u, TransportMode mode, bool flipped,
                 LobeSample& sample) {
  switch (lobe.kind) {
    case LobeKind::Diffuse:
    case LobeKind::PrincipledDiffuse:
    case LobeKind::Sheen:
    case LobeKind::MicrofiberSheen:
    case LobeKind::PrincipledRetro:
      sample.wi = lobe.frame.to_world(warp::square_to_cosine_hemisphere(u));
      sample.flags = kReflection | kDiffuse;
      return true;
    case LobeKind::Velvet:
      sample.wi = lobe.frame.to_world(warp::square_to_hemisphere(u));
      sample.flags = kReflection | kDiffuse;
      return true;
    case LobeKind::ToonDiffuse:
      // Half of the samples are cosine-distributed, because importance may leave in any direction.
      sample.wi = lobe.frame.to_world(u_branch < 0.5f ? warp::square_to_cone(u, toon::cone(lobe.alpha_x, lobe.alpha_y))
                                                      : warp::square_to_cosine_hemisphere(u));
      sample.flags = kReflection | kDiffuse;
      return true;
    case LobeKind::ToonGlossy: {
      const Vec3 mirror = 2.0f * glm::dot(lobe.frame.n, wo) * lobe.frame.n - wo;
      sample.wi = Frame(mirror).to_world(warp::square_to_cone(u, toon::cone(lobe.alpha_x, lobe.alpha_y)));
      sample.flags = kReflection | kGlossy;
      return true;
    }
    case LobeKind::Translucent:
      sample.wi = -lobe.frame.to_world(warp::square_to_cosine_hemisphere(u));
      sample.flags = kTransmission | kDiffuse;
      return true;
    case LobeKind::Transparent:
      sample = {-wo, lobe.weight, 1.0f, kTransmission | kSpecular | kTransparent, 1.0f, 0.0f};
      return true;
    default: break;
  }
  return sample_microfacet(lobe, wo, u_branch, u, mode, eta_from(lobe, flipped), sample);
}

Color lobe_scattered(const Lobe& lobe, float cos_wo, bool flipped) {
  cos_wo = saturate(cos_wo);
  switch (lobe.kind) {
    case LobeKind::Sheen: return lobe.weight * sheen::disney_albedo(cos_wo);
    case LobeKind::MicrofiberSheen: return lobe.weight * sheen::microfiber_albedo(lobe.roughness, cos_wo);
    case LobeKind::MicrofacetReflection:
    case LobeKind::MicrofacetRefraction:
    case LobeKind::MicrofacetGlass: break;
    default: return lobe.weight;
  }
  const float eta = eta_from(lobe, flipped);
  // The mean cosine under which facets are seen. It moves from the eye's cosine towards 2/3 as the roughness increases.
  const float cos_facet = cos_wo + (2.0f / 3.0f - cos_wo) * std::sqrt(lobe.alpha_x * lobe.alpha_y);
  if (lobe.kind == LobeKind::MicrofacetGlass) {
    const Split split = split_glass(lobe, cos_facet, cos_wo, eta);
    return lobe.weight * (split.reflected + split.transmitted);
  }
  const Color color = lobe.weight * normal_fresnel(lobe, cos_wo, eta);
  return lobe.kind == LobeKind::MicrofacetReflection ? color * fresnel_color(lobe, cos_facet, eta) : color;
}

Color lobe_albedo(const Lobe& lobe, float cos_wo, bool flipped) {
  const Color scattered = lobe_scattered(lobe, cos_wo, flipped);
  const bool microfacet = lobe.kind == LobeKind::MicrofacetReflection || lobe.kind == LobeKind::MicrofacetRefraction ||
                          lobe.kind == LobeKind::MicrofacetGlass;
  if (!microfacet || lobe.microfacet == Microfacet::Gtr1 || lobe.delta) return scattered;
  const float alpha = std::sqrt(lobe.alpha_x * lobe.alpha_y);
  const float single = lobe.kind == LobeKind::MicrofacetGlass
                           ? albedo_table::ggx_glass(saturate(cos_wo), alpha, eta_from(lobe, flipped))
                           : albedo_table::ggx(saturate(cos_wo), alpha);
  if (lobe.compensation == Compensation::None) return scattered * single;
  return scattered * (single + lobe.multiple_scattering * (1.0f - single));
}

namespace {

/// [Conty Estevez, Lecocq and Stein 2019, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem",
/// section 12.3]: the light is shadowed by a GGX distribution whose width makes the bumped normal one in eight.
float microfacet_bump_shadowing(Vec3 n, Vec3 bumped, Vec3 light) {
  const float cos_light = glm::dot(n, light), cos_bump = glm::dot(n, bumped);
  // Without this test, light from the other side of the smooth surface would pass through it.
  if (cos_light * cos_bump * glm::dot(bumped, light) < 0.0f) return 0.0f;
  const float c2 = sqr(cos_light), d2 = sqr(cos_bump);
  if (c2 >= 1.0f || d2 >= 1.0f) return 1.0f;
  if (c2 < 1e-12f || d2 < 1e-12f) return 0.0f;
  const float alpha2 = saturate(0.125f * (1.0f / d2 - 1.0f));
  return 2.0f / (1.0f + std::sqrt(1.0f + alpha2 * (1.0f / c2 - 1.0f)));
}

}  // namespace

float bump_shadowing(BumpTerminator terminator, Vec3 n, Vec3 bumped, Vec3 light) {
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
