// The two versions of the Principled BSDF, as sums of lobes.
#include <algorithm>
#include <cmath>

#include "shading/bsdf/closure_parts.h"
#include "shading/bsdf/fresnel.h"
#include "shading/bsdf/lobe.h"

namespace ajar::closures {
namespace {

/// A colour of luminance 1 with the same hue and saturation.
Color hue_of(Color color, float luminance) { return luminance > 0.0f ? color / luminance : Color(1.0f); }

void set_anisotropy(Lobe& lobe, const PrincipledInputs& in) {
  const float aspect = safe_sqrt(1.0f - 0.9f * saturate(in.anisotropic)), alpha = sqr(in.roughness);
  set_roughness(lobe, alpha / aspect, alpha * aspect);
  if (lobe.alpha_x != lobe.alpha_y) set_tangent(lobe, in.tangent, in.anisotropic_rotation);
}

/// The mean over the hemisphere of a reflectance that goes from f0 to f90 along the dielectric curve of eta.
Color mean_dielectric_tint(Color f0, Color f90, float eta) {
  const float at_normal = fresnel::f0_from_eta(eta);
  return glm::mix(f0, f90, saturate((fresnel::dielectric_mean(eta) - at_normal) / (1.0f - at_normal)));
}

// ---- Version 1: Disney 2012 as in Blender 2.79 to 3.x --------------------------------------------------------------

Color diffuse_color_v1(const PrincipledInputs& in) {
  return glm::mix(in.base_color, in.subsurface_color, saturate(in.subsurface));
}

/// If light does not enter, subsurface scattering is approximated by diffuse reflection of the mixed colour.
void add_diffuse_v1(Bsdf& bsdf, const Surface& surface, Color weight, const PrincipledInputs& in) {
  const Color color = diffuse_color_v1(in);
  const bool enters = in.enters && in.subsurface > kWeightCutoff;
  if (enters) add_subsurface(bsdf, surface, weight * color, in.normal, principled_medium(in));
  Lobe lobe = make_lobe(enters ? LobeKind::PrincipledRetro : LobeKind::PrincipledDiffuse, weight * color, in.normal);
  lobe.roughness = in.roughness;
  bsdf.add(lobe);
  if (in.sheen > kWeightCutoff) {
    const Color tint = glm::mix(Color(1.0f), hue_of(in.base_color, luminance(in.base_color)), in.sheen_tint);
    bsdf.add(make_lobe(LobeKind::Sheen, weight * in.sheen * tint, in.normal));
  }
}

void add_specular_v1(Bsdf& bsdf, Color weight, const PrincipledInputs& in) {
  // The tint uses Burley's own luminance. The index of refraction is the one whose f0 is 0.08 specular.
  const float rough_luminance = glm::dot(in.base_color, Color(0.3f, 0.6f, 0.1f));
  const Color tint = glm::mix(Color(1.0f), hue_of(in.base_color, rough_luminance), in.specular_tint);
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, weight, in.normal);
  lobe.fresnel = FresnelKind::DielectricTint;
  lobe.eta = 2.0f / (1.0f - safe_sqrt(0.08f * in.specular)) - 1.0f;
  lobe.f0 = glm::clamp(glm::mix(0.08f * in.specular * tint, in.base_color, in.metallic), 0.0f, 1.0f);
  set_anisotropy(lobe, in);
  if (in.distribution == Distribution::MultiGgx && in.roughness > 0.075f)
    compensate(lobe, Compensation::Mixed, mean_dielectric_tint(lobe.f0, lobe.f90, lobe.eta));
  bsdf.add(lobe);
}

void add_transmission_v1(Bsdf& bsdf, const Surface& surface, Color weight, const PrincipledInputs& in) {
  const Color f0 = glm::clamp(glm::mix(Color(1.0f), in.base_color, in.specular_tint), 0.0f, 1.0f);
  const float eta = eta_from_ior(surface, in.ior);
  if (in.distribution == Distribution::MultiGgx && in.roughness > 0.05f) {
    Lobe lobe = make_lobe(LobeKind::MicrofacetGlass, weight, in.normal);
    lobe.fresnel = FresnelKind::Dielectric;
    lobe.eta = eta;
    lobe.transmission_tint = glm::clamp(in.base_color, 0.0f, 1.0f);
    set_roughness(lobe, sqr(in.roughness), sqr(in.roughness));
    compensate(lobe, Compensation::Scaled, lobe.transmission_tint);
    bsdf.add(lobe);
    return;
  }
  if (in.reflective_caustics) {
    Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, weight, in.normal);
    lobe.fresnel = FresnelKind::DielectricTint;
    lobe.normal_fresnel = NormalFresnel::Reflected;
    lobe.eta = eta;
    lobe.f0 = f0;
    set_roughness(lobe, sqr(in.roughness), sqr(in.roughness));
    bsdf.add(lobe);
  }
  if (in.refractive_caustics) {
    Lobe lobe = make_lobe(LobeKind::MicrofacetRefraction, weight * in.base_color, in.normal);
    lobe.normal_fresnel = NormalFresnel::Transmitted;
    lobe.eta = eta;
    float roughness = in.roughness;
    if (in.distribution != Distribution::MultiGgx)
      roughness = 1.0f - (1.0f - roughness) * (1.0f - in.transmission_roughness);
    set_roughness(lobe, sqr(roughness), sqr(roughness));
    bsdf.add(lobe);
  }
}

void add_clearcoat_v1(Bsdf& bsdf, Color weight, const PrincipledInputs& in) {
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, weight * (0.25f * in.clearcoat), in.clearcoat_normal);
  lobe.microfacet = Microfacet::Gtr1;
  lobe.fresnel = FresnelKind::DielectricTint;
  lobe.eta = 1.5f;
  lobe.f0 = Color(0.04f);
  set_roughness(lobe, sqr(in.clearcoat_roughness), sqr(in.clearcoat_roughness));
  bsdf.add(lobe);
}

void add_principled_v1(Bsdf& bsdf, const Surface& surface, Color weight, const PrincipledInputs& in) {
  const float metallic = saturate(in.metallic), transmission = saturate(in.transmission) * (1.0f - metallic);
  const float diffuse = (1.0f - metallic) * (1.0f - saturate(in.transmission));
  if (diffuse > kWeightCutoff) add_diffuse_v1(bsdf, surface, weight * diffuse, in);
  if (in.reflective_caustics && 1.0f - transmission > kWeightCutoff &&
      (in.specular > kWeightCutoff || in.metallic > kWeightCutoff))
    add_specular_v1(bsdf, weight * (1.0f - transmission), in);
  if (transmission > kWeightCutoff && (in.reflective_caustics || in.refractive_caustics))
    add_transmission_v1(bsdf, surface, weight * transmission, in);
  if (in.reflective_caustics && in.clearcoat > kWeightCutoff) add_clearcoat_v1(bsdf, weight, in);
}

// ---- Version 2: Blender 4.x. The albedo of a layer dims the lobes below it -----------------------------------------

/// The state for the lobes that are still to be added: the weight of the light that reaches them, and the layers above.
struct Below {
  Color weight;
  uint8_t layers = 0;
};

void add_below(Bsdf& bsdf, const Below& below, Lobe& lobe) {
  lobe.layers = below.layers;
  bsdf.add(lobe);
}

/// Adds the lobe as a layer that covers the lobes added after it.
void add_covering(Bsdf& bsdf, const Surface& surface, Below& below, Lobe& lobe, float tint_share, Color tint) {
  add_below(bsdf, below, lobe);
  Layer layer{lobe, tint_share, tint};
  // The weight of a layer is relative to the light that reaches it.
  for (int i = 0; i < 3; ++i) layer.lobe.weight[i] = below.weight[i] > 0.0f ? lobe.weight[i] / below.weight[i] : 0.0f;
  below.layers |= bsdf.add_layer(layer);
  below.weight *= layer.transmittance(surface.wo);
}

bool compensated_v2(const PrincipledInputs& in) { return in.distribution == Distribution::MultiGgx; }

void add_sheen_v2(Bsdf& bsdf, const Surface& surface, Below& below, const PrincipledInputs& in) {
  Lobe lobe = make_lobe(LobeKind::MicrofiberSheen, below.weight * in.sheen * glm::max(in.sheen_tint_color, 0.0f),
                        glm::normalize(glm::mix(in.normal, in.clearcoat_normal, saturate(in.clearcoat))));
  lobe.roughness = saturate(in.sheen_roughness);
  add_covering(bsdf, surface, below, lobe, 0.0f, Color(1.0f));
}

void add_coat_v2(Bsdf& bsdf, const Surface& surface, Below& below, const PrincipledInputs& in) {
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, below.weight * in.clearcoat, in.clearcoat_normal);
  lobe.fresnel = FresnelKind::Dielectric;
  lobe.eta = std::max(in.coat_ior, 1.0f);
  set_roughness(lobe, sqr(saturate(in.clearcoat_roughness)), sqr(saturate(in.clearcoat_roughness)));
  if (!in.reflective_caustics) lobe.weight = Color(0.0f);
  const float tint_share = in.coat_tint == Color(1.0f) ? 0.0f : saturate(in.clearcoat);
  add_covering(bsdf, surface, below, lobe, tint_share, glm::max(in.coat_tint, 0.0f));
}

void add_metal_v2(Bsdf& bsdf, const Below& below, float metallic, const PrincipledInputs& in) {
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, below.weight * metallic, in.normal);
  lobe.fresnel = FresnelKind::F82Tint;
  lobe.f0 = glm::clamp(in.base_color, 0.0f, 1.0f);
  lobe.f90 = fresnel::f82_coefficient(lobe.f0, glm::clamp(in.specular_tint_color, 0.0f, 1.0f));
  set_anisotropy(lobe, in);
  // Means over the hemisphere: 1/21 of the rise of Schlick's curve, 1/126 of the dip.
  if (compensated_v2(in))
    compensate(lobe, Compensation::Scaled, glm::mix(lobe.f0, Color(1.0f), 1.0f / 21.0f) - lobe.f90 / 126.0f);
  add_below(bsdf, below, lobe);
}

void add_transmission_v2(Bsdf& bsdf, const Surface& surface, const Below& below, float transmission,
                         const PrincipledInputs& in) {
  Lobe lobe = make_lobe(LobeKind::MicrofacetGlass, below.weight * transmission, in.normal);
  lobe.fresnel = FresnelKind::DielectricTint;
  lobe.eta = eta_from_ior(surface, in.ior);
  lobe.f0 = fresnel::f0_from_eta(std::max(in.ior, 1e-5f)) * glm::max(in.specular_tint_color, 0.0f);
  // Light passes the surface twice, in and out. Each time the factor is the square root of the colour.
  lobe.transmission_tint = glm::sqrt(glm::clamp(in.base_color, 0.0f, 1.0f));
  if (!in.refractive_caustics) lobe.transmission_tint = Color(0.0f);
  set_roughness(lobe, sqr(saturate(in.roughness)), sqr(saturate(in.roughness)));
  if (compensated_v2(in)) {
    const Color reflected = mean_dielectric_tint(lobe.f0, lobe.f90, std::max(lobe.eta, 1.0f / lobe.eta));
    compensate(lobe, Compensation::Scaled, reflected + (1.0f - reflected) * lobe.transmission_tint);
  }
  add_below(bsdf, below, lobe);
}

void add_specular_v2(Bsdf& bsdf, const Surface& surface, Below& below, const PrincipledInputs& in) {
  float eta = std::max(in.ior, 1e-5f), f0 = fresnel::f0_from_eta(eta);
  if (in.specular_ior_level != 0.5f) {
    f0 *= 2.0f * std::max(in.specular_ior_level, 0.0f);
    eta = in.ior < 1.0f ? 1.0f / fresnel::eta_from_f0(f0) : fresnel::eta_from_f0(f0);
  }
  if (eta == 1.0f || !in.reflective_caustics) return;
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, below.weight, in.normal);
  lobe.fresnel = FresnelKind::DielectricTint;
  lobe.eta = eta;
  lobe.f0 = glm::min(f0 * glm::max(in.specular_tint_color, 0.0f), 1.0f);
  set_anisotropy(lobe, in);
  if (compensated_v2(in)) compensate(lobe, Compensation::Scaled, mean_dielectric_tint(lobe.f0, lobe.f90, eta));
  add_covering(bsdf, surface, below, lobe, 0.0f, Color(1.0f));
}

void add_principled_v2(Bsdf& bsdf, const Surface& surface, Color weight, const PrincipledInputs& in) {
  const float metallic = saturate(in.metallic), transmission = saturate(in.transmission);
  Below below{weight};
  if (in.sheen > kWeightCutoff) add_sheen_v2(bsdf, surface, below, in);
  if (in.clearcoat > kWeightCutoff) add_coat_v2(bsdf, surface, below, in);
  if (metallic > kWeightCutoff && in.reflective_caustics) add_metal_v2(bsdf, below, metallic, in);
  below.weight *= 1.0f - metallic;
  if (transmission > kWeightCutoff && (in.reflective_caustics || in.refractive_caustics))
    add_transmission_v2(bsdf, surface, below, transmission, in);
  below.weight *= 1.0f - transmission;
  if (!(max_component(below.weight) > kWeightCutoff)) return;
  add_specular_v2(bsdf, surface, below, in);
  // Subsurface scattering is approximated by diffuse reflection of the base colour. In Blender 4.x its colour is the
  // base colour too.
  Lobe diffuse = make_lobe(LobeKind::Diffuse, below.weight * glm::clamp(in.base_color, 0.0f, 1.0f), in.normal);
  diffuse.roughness = saturate(in.diffuse_roughness);
  add_below(bsdf, below, diffuse);
}

}  // namespace

SubsurfaceMedium principled_medium(const PrincipledInputs& in) {
  SubsurfaceMedium medium = make_medium(diffuse_color_v1(in), in.subsurface_radius * saturate(in.subsurface),
                                        in.subsurface_anisotropy, in.subsurface_ior, in.subsurface_method);
  medium.fresnel = true;
  return medium;
}

void add_principled(Bsdf& bsdf, const Surface& surface, Color weight, const PrincipledInputs& inputs) {
  if (inputs.version >= 2)
    add_principled_v2(bsdf, surface, weight, inputs);
  else
    add_principled_v1(bsdf, surface, weight, inputs);
}

}  // namespace ajar::closures
