#include "shading/bsdf/lobe.h"

#include <algorithm>
#include <cmath>

#include "math/warps.h"
#include "shading/bsdf/compensation.h"
#include "shading/bsdf/diffuse_lobes.h"
#include "shading/bsdf/hair.h"
#include "shading/bsdf/thin_film.h"
#include "shading/models/albedo_table.h"
#include "shading/models/diffuse.h"
#include "shading/models/fresnel.h"
#include "shading/models/microfacet.h"
#include "shading/models/sheen.h"
#include "shading/models/toon.h"

namespace ajar {
namespace {

bool is_delta_roughness(const Lobe& lobe) { return lobe.alpha_x * lobe.alpha_y <= kDeltaAlphaProduct; }

/// For a wo on the other side of the surface, the index is inverted, unless it only shapes a reflection.
float eta_from(const Lobe& lobe, bool flipped) {
  const bool shapes_reflection = lobe.kind == LobeKind::MicrofacetReflection &&
                                 lobe.normal_fresnel == NormalFresnel::None;
  const bool is_thin = lobe.normal_fresnel >= NormalFresnel::ThinReflected;  // a sheet has the same index on both sides
  return flipped && !shapes_reflection && !is_thin ? 1.0f / lobe.eta : lobe.eta;
}

bool is_index_matched(float eta) { return std::abs(eta - 1.0f) < 1e-4f; }

/// The reflectance of a facet by a kind of Fresnel curve.
Color fresnel_color(const Lobe& lobe, FresnelKind kind, float cosine, float eta) {
  if (lobe.film.thickness > thin_film::kThinnest) [[unlikely]]
    return thin_film::on_lobe(lobe, kind, cosine, eta);
  switch (kind) {
    case FresnelKind::DielectricTint: return glm::mix(lobe.f0, lobe.f90, fresnel::dielectric_position(cosine, eta));
    case FresnelKind::Dielectric: return Color(fresnel::dielectric(cosine, eta));
    case FresnelKind::F82Tint: return fresnel::f82(cosine, lobe.f0, lobe.f90);
    case FresnelKind::Conductor: return fresnel::conductor(cosine, lobe.f0, lobe.f90);
    case FresnelKind::None: break;
  }
  return Color(1.0f);
}
Color fresnel_color(const Lobe& lobe, float cosine, float eta) {
  return fresnel_color(lobe, lobe.fresnel, cosine, eta);
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
    split.reflected = fresnel_color(lobe, cos_facet, eta);
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

/// G(wo, wi) / (cos(wo) cos(wi)), from masking_over_cos for both. The correlated form is that of Heitz 2014, eq. 99.
float masking_over_cosines(const Lobe& lobe, float masking_o, float masking_i, float cos_o, float cos_i) {
  return lobe.correlated ? 1.0f / (cos_i / masking_o + cos_o / masking_i - cos_o * cos_i) : masking_o * masking_i;
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

/// A thin sheet of glass whose absorption along the normal is `transmission_tint`. Light bounces inside it: with
/// reflectances r1 and r2 at the outer and the inner side and absorption c on each way, the sheet transmits t =
/// c (1 - r1) (1 - r2) / (1 - (r2 c)^2) and reflects r1 + t r2 c.
Color thin_sheet(const Lobe& lobe, float cosine) {
  const float sin2 = (1.0f - cosine * cosine) / sqr(lobe.eta);
  const Color r1 = fresnel_color(lobe, FresnelKind::DielectricTint, cosine, lobe.eta);
  Color transmitted(0.0f), again(0.0f);
  if (sin2 < 1.0f) {
    const float cos_inside = std::sqrt(1.0f - sin2);
    Color r2 = r1;
    if (lobe.film.thickness > thin_film::kThinnest)
      r2 = fresnel_color(lobe, FresnelKind::DielectricTint, cos_inside, 1.0f / lobe.eta);
    const Color absorption = glm::pow(lobe.transmission_tint, Color(1.0f / cos_inside)), inside = r2 * absorption;
    transmitted = absorption * (1.0f - r1) * (1.0f - r2) / glm::max(1.0f - inside * inside, 1e-6f);
    again = transmitted * inside;
  }
  return lobe.normal_fresnel == NormalFresnel::ThinReflected ? r1 + again : transmitted;
}

Color normal_fresnel(const Lobe& lobe, float cos_eye, float eta_eye) {
  switch (lobe.normal_fresnel) {
    case NormalFresnel::None: return Color(1.0f);
    case NormalFresnel::Reflected: return Color(fresnel::dielectric(cos_eye, eta_eye));
    case NormalFresnel::Transmitted: return Color(1.0f - fresnel::dielectric(cos_eye, eta_eye));
    default: return thin_sheet(lobe, cos_eye);
  }
}

/// `pdf_back`: receives the density from wi to wo; not for the distribution of Ashikhmin and Shirley, or Gtr1.
LobeValue reflect_microfacet(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode, float eta,
                             float* pdf_back = nullptr) {
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
    const float common = 0.25f * density, masking_o = masking_over_cos(lobe, wo),
                masking_i = masking_over_cos(lobe, wi);
    f_cos = common * wi.z * masking_over_cosines(lobe, masking_o, masking_i, wo.z, wi.z);
    if (pdf_back) *pdf_back = common * masking_i;
    pdf = common * (lobe.microfacet == Microfacet::Gtr1 ? m.z / cos_facet : masking_o);
  }
  Color color = lobe.weight * f_cos;
  if (lobe.kind == LobeKind::MicrofacetGlass) {
    const Split for_wo = split_glass(lobe, cos_facet, wo.z, eta);
    pdf *= for_wo.probability_reflected;
    if (pdf_back) *pdf_back *= split_glass(lobe, cos_facet, wi.z, eta).probability_reflected;
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
    if (pdf_back) *pdf_back = glm::mix(*pdf_back, wo.z * kInvPi, added.diffuse_share_back);
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
  const float common = density_of_normal(lobe, m) * cos_o * jacobian;
  const float masking_o = masking_over_cos(lobe, wo), masking_i = masking_over_cos(lobe, {wi.x, wi.y, -wi.z});
  float f_cos = common * masking_over_cosines(lobe, masking_o, masking_i, wo.z, -wi.z) * -wi.z;
  float pdf = common * masking_o;
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
    case LobeKind::MicrofacetThin: {
      if (!sample_reflection(lobe, wo, m, sample)) return false;
      sample.wi -= 2.0f * glm::dot(sample.wi, lobe.frame.n) * lobe.frame.n;
      sample.flags = kTransmission | glossy_or_specular(lobe);
      if (delta) sample.weight = lobe.weight * normal_fresnel(lobe, wo.z, eta);
      return true;
    }
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
    case LobeKind::MicrofacetReflection:
    case LobeKind::MicrofacetThin: return is_delta_roughness(*this);
    case LobeKind::MicrofacetRefraction:
    case LobeKind::MicrofacetGlass: return is_delta_roughness(*this) || is_index_matched(eta);
    default: return false;
  }
}

LobeValue evaluate_lobe(const Lobe& lobe, Vec3 wo, Vec3 wi, bool reflection, TransportMode mode, bool flipped) {
  const float cos_o = glm::dot(lobe.frame.n, wo), cos_i = glm::dot(lobe.frame.n, wi);
  if (lobe.ignores_eye) [[unlikely]] {
    if (is_fiber(lobe.kind)) return hair::evaluate(lobe, wo, wi, mode, flipped);
    return reflection ? for_any_eye(lobe, wo, wi, mode) : LobeValue{};
  }
  if (!(cos_o > 0.0f) || (reflection ? !(cos_i > 0.0f) : !(cos_i < 0.0f))) return {};
  const auto cosine_lobe = [&](float f) { return LobeValue{lobe.weight * (f * cos_i), cos_i * kInvPi}; };
  switch (lobe.kind) {
    case LobeKind::Diffuse:
      if (!reflection) return {};
      if (lobe.roughness > 0.0f) return {rough_diffuse(lobe, cos_o, cos_i, glm::dot(wo, wi)) * cos_i, cos_i * kInvPi};
      return cosine_lobe(kInvPi);
    case LobeKind::PrincipledDiffuse:
      if (!reflection) return {};
      return cosine_lobe(principled_diffuse(lobe.roughness, cos_o, cos_i, glm::dot(wo, wi)));
    case LobeKind::Sheen:
      if (!reflection) return {};
      return cosine_lobe(sheen::disney(glm::dot(wo, wi)));
    case LobeKind::MicrofiberSheen:
      if (!reflection) return {};
      return microfiber(lobe, wo, wi, mode);
    case LobeKind::PrincipledRetro:
      if (!reflection) return {};
      return cosine_lobe(principled_retro(lobe.roughness, cos_o, cos_i, glm::dot(wo, wi)));
    case LobeKind::Velvet:
      if (!reflection) return {};
      return {lobe.weight * (sheen::velvet(lobe.roughness, lobe.frame.n, wo, wi) * cos_i),
              warp::hemisphere_pdf_solid_angle()};
    case LobeKind::ToonDiffuse:
      if (!reflection) return {};
      return toon_diffuse(lobe, wo, wi, mode);
    case LobeKind::ToonGlossy: {
      if (!reflection) return {};
      // The cosine between the light's direction and the axis of the cone. For importance, the light is at wo, and f is
      // multiplied by the cosine of the other direction.
      const float mirrored = 2.0f * cos_o * cos_i - glm::dot(wo, wi);
      const float value = toon::value(mirrored, lobe.alpha_x, lobe.alpha_y) *
                          (mode == TransportMode::Radiance ? 1.0f : cos_i / cos_o);
      return {lobe.weight * value, toon::pdf_solid_angle(mirrored, lobe.alpha_x, lobe.alpha_y)};
    }
    case LobeKind::Translucent:
      if (reflection) return {};
      if (lobe.roughness > 0.0f)
        return {rough_diffuse(lobe, cos_o, -cos_i, glm::dot(wo, wi) - 2.0f * cos_o * cos_i) * -cos_i, -cos_i * kInvPi};
      return {lobe.weight * (-cos_i * kInvPi), -cos_i * kInvPi};
    case LobeKind::MicrofacetReflection:
      if (!reflection) return {};
      break;
    case LobeKind::MicrofacetRefraction:
      if (reflection) return {};
      break;
    case LobeKind::MicrofacetGlass: break;
    case LobeKind::MicrofacetThin:
      if (reflection) return {};
      break;
    case LobeKind::HairChiang:
    case LobeKind::HairHuang:
    case LobeKind::HairReflection:
    case LobeKind::HairTransmission:
    case LobeKind::Transparent: return {};
  }
  const Vec3 local_o = lobe.frame.to_local(wo);
  Vec3 local_i = lobe.frame.to_local(wi);
  const float eta = eta_from(lobe, flipped);
  if (lobe.kind == LobeKind::MicrofacetThin) {
    local_i.z = -local_i.z;
    reflection = true;
  }
  return reflection ? reflect_microfacet(lobe, local_o, local_i, mode, eta)
                    : refract_microfacet(lobe, local_o, local_i, mode, eta);
}

bool shares_evaluation(const Lobe& lobe) {
  if (lobe.ignores_eye) return false;
  if (lobe.kind == LobeKind::Diffuse) return true;
  return (lobe.kind == LobeKind::MicrofacetReflection || lobe.kind == LobeKind::MicrofacetGlass) &&
         (lobe.microfacet == Microfacet::Ggx || lobe.microfacet == Microfacet::Beckmann);
}

LobeValue evaluate_reflection(const Lobe& lobe, Vec3 wo, Vec3 wi, bool flipped, float& pdf_back) {
  const float cos_o = glm::dot(lobe.frame.n, wo), cos_i = glm::dot(lobe.frame.n, wi);
  pdf_back = 0.0f;
  if (!(cos_o > 0.0f && cos_i > 0.0f)) return {};
  if (lobe.kind != LobeKind::Diffuse)
    return reflect_microfacet(lobe, lobe.frame.to_local(wo), lobe.frame.to_local(wi), TransportMode::Radiance,
                              eta_from(lobe, flipped), &pdf_back);
  pdf_back = cos_o * kInvPi;
  const Color f = lobe.roughness > 0.0f ? rough_diffuse(lobe, cos_o, cos_i, glm::dot(wo, wi)) : lobe.weight * kInvPi;
  return {f * cos_i, cos_i * kInvPi};
}

bool sample_lobe(const Lobe& lobe, Vec3 wo, float u_branch, Vec2 u, TransportMode mode, bool flipped,
                 LobeSample& sample) {
  switch (lobe.kind) {
    case LobeKind::Diffuse:
    case LobeKind::PrincipledDiffuse:
    case LobeKind::Sheen:
    case LobeKind::PrincipledRetro:
      sample.wi = lobe.frame.to_world(warp::square_to_cosine_hemisphere(u));
      sample.flags = kReflection | kDiffuse;
      return true;
    case LobeKind::MicrofiberSheen: {
      const float cosine = glm::dot(lobe.frame.n, wo);
      sample.wi = Frame(lobe.frame.n, wo).to_world(sheen::Microfiber(lobe.roughness, cosine).sample(u));
      sample.flags = kReflection | kDiffuse;
      return true;
    }
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
    case LobeKind::HairChiang:
    case LobeKind::HairHuang:
    case LobeKind::HairReflection:
    case LobeKind::HairTransmission: return hair::sample(lobe, wo, u_branch, u, flipped, sample);
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
    case LobeKind::MicrofiberSheen: return lobe.weight * sheen::Microfiber(lobe.roughness, cos_wo).albedo;
    case LobeKind::MicrofacetReflection:
    case LobeKind::MicrofacetRefraction:
    case LobeKind::MicrofacetThin:
    case LobeKind::MicrofacetGlass: break;
    case LobeKind::HairChiang:
    case LobeKind::HairHuang: return lobe.weight * hair::albedo(lobe, cos_wo);
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
  if (lobe.kind != LobeKind::MicrofacetReflection) return color;
  const bool is_dielectric = lobe.fresnel == FresnelKind::Dielectric || lobe.fresnel == FresnelKind::DielectricTint;
  if (!is_dielectric || !lobe.correlated || lobe.film.thickness > thin_film::kThinnest)
    return color * fresnel_color(lobe, cos_facet, eta);
  const float position = albedo_table::dielectric_position(cos_wo, std::sqrt(lobe.alpha_x * lobe.alpha_y), eta);
  if (lobe.fresnel == FresnelKind::DielectricTint) return color * glm::mix(lobe.f0, lobe.f90, position);
  return color * glm::mix(Color(fresnel::f0_from_eta(eta)), Color(1.0f), position);
}

Color lobe_albedo(const Lobe& lobe, float cos_wo, bool flipped) {
  const Color scattered = lobe_scattered(lobe, cos_wo, flipped);
  if (!is_microfacet(lobe.kind) || lobe.microfacet == Microfacet::Gtr1 || lobe.delta) return scattered;
  const float alpha = std::sqrt(lobe.alpha_x * lobe.alpha_y);
  const float single = single_albedo(lobe, saturate(cos_wo), alpha, eta_from(lobe, flipped));
  // Since Blender 4.0, Cycles ignores the lost light where it estimates how much a layer lets through.
  if (lobe.compensation == Compensation::None) return lobe.correlated ? scattered : scattered * single;
  return scattered * (single + lobe.multiple_scattering * (1.0f - single));
}

}  // namespace ajar
