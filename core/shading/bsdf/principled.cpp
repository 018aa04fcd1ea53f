// The two versions of the Principled BSDF, as sums of lobes.
#include <algorithm>
#include <cmath>

#include "shading/bsdf/closure_parts.h"
#include "shading/bsdf/lobe.h"
#include "shading/bsdf/thin_film.h"
#include "shading/models/fresnel.h"
#include "shading/models/microfacet.h"

namespace ajar::closures {
namespace {

/// A colour of luminance 1 with the same hue and saturation.
Color hue_of(Color color, float luminance) { return luminance > 0.0f ? color / luminance : Color(1.0f); }

void set_anisotropy(Lobe& lobe, const PrincipledInputs& in) {
  set_principled_anisotropy(lobe, in.roughness, in.anisotropy());
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

/// Where less of the light passes a layer, the lobes below are not made from it for other directions.
constexpr float kLeastTransmittance = 1e-3f;

/// Adds the lobe as a layer that covers the lobes added after it.
void add_covering(Bsdf& bsdf, const Surface& surface, Below& below, Lobe& lobe, float tint_share, Color tint) {
  add_below(bsdf, below, lobe);
  Layer layer{lobe, tint_share, tint, Color(1.0f)};
  // The weight of a layer is relative to the light that reaches it.
  for (int i = 0; i < 3; ++i) layer.lobe.weight[i] = below.weight[i] > 0.0f ? lobe.weight[i] / below.weight[i] : 0.0f;
  const Color passes = layer.in_weights = layer.transmittance(surface.ng, surface.wo);
  below.layers |= bsdf.add_layer(layer);
  if (!(std::min({passes.x, passes.y, passes.z}) > kLeastTransmittance)) bsdf.bind_to_view();
  below.weight *= passes;
}

bool compensated_v2(const PrincipledInputs& in) { return in.distribution == Distribution::MultiGgx; }
bool is_thin(const PrincipledInputs& in) { return in.thin_wall != 0.0f; }

/// The reflectance of a transmitting surface along its normal.
Color transmission_f0(const PrincipledInputs& in) {
  return glm::clamp(fresnel::f0_from_eta(std::max(in.ior, 1e-5f)) * glm::max(in.specular_tint_color, 0.0f), 0.0f, 1.0f);
}

void add_sheen_v2(Bsdf& bsdf, const Surface& surface, Below& below, const PrincipledInputs& in) {
  Lobe lobe = make_lobe(LobeKind::MicrofiberSheen, below.weight * in.sheen * glm::max(in.sheen_tint_color, 0.0f),
                        glm::normalize(glm::mix(in.keeps_normal ? in.diffuse_normal : in.normal, in.clearcoat_normal,
                                                saturate(in.clearcoat))));
  lobe.ignores_eye = in.keeps_normal;
  lobe.roughness = saturate(in.sheen_roughness);
  add_covering(bsdf, surface, below, lobe, 0.0f, Color(1.0f));
}

void add_coat_v2(Bsdf& bsdf, const Surface& surface, Below& below, const PrincipledInputs& in) {
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, below.weight * in.clearcoat, in.clearcoat_normal);
  lobe.correlated = true;
  lobe.fresnel = FresnelKind::Dielectric;
  lobe.eta = std::max(in.coat_ior, 1.0f);
  set_roughness(lobe, sqr(saturate(in.clearcoat_roughness)), sqr(saturate(in.clearcoat_roughness)));
  compensate(lobe, Compensation::Scaled, Color(fresnel::dielectric_mean(lobe.eta)));
  if (!in.reflective_caustics) lobe.weight = Color(0.0f);
  const float tint_share = in.coat_tint == Color(1.0f) ? 0.0f : saturate(in.clearcoat);
  add_covering(bsdf, surface, below, lobe, tint_share, glm::max(in.coat_tint, 0.0f));
}

void add_metal_v2(Bsdf& bsdf, const Below& below, float metallic, const PrincipledInputs& in) {
  Metal metal;
  metal.color_or_n = in.base_color;
  metal.tint_or_k = in.specular_tint_color;
  if (in.film_on_metal) metal.film = in.film;
  add_metallic(bsdf, below.weight * metallic, in.normal, {in.distribution, in.roughness, true}, in.anisotropy(), metal,
               below.layers);
}

void add_transmission_v2(Bsdf& bsdf, const Surface& surface, const Below& below, float transmission,
                         const PrincipledInputs& in) {
  Lobe lobe = make_lobe(LobeKind::MicrofacetGlass, below.weight * transmission, in.normal);
  lobe.correlated = true;
  lobe.fresnel = FresnelKind::DielectricTint;
  lobe.eta = eta_from_ior(surface, in.ior);
  lobe.f0 = transmission_f0(in);
  set_film(lobe, surface, in.film, std::max(in.ior, 1e-5f));
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

/// Reflection and transmission by a thin sheet, with all bounces inside it (ThinSheet). Light that is refracted twice
/// leaves in its direction; the width of the transmitted lobe is that of Kulla and Conty 2017 ("Revisiting Physically
/// Based Shading at Imageworks", page 40, with 3.4 for 3.7). A smooth sheet is transparent.
void add_thin_glass_v2(Bsdf& bsdf, const Surface& surface, const Below& below, float transmission,
                       const PrincipledInputs& in) {
  const float alpha = sqr(saturate(in.roughness)), eta = std::max(in.ior, 1e-5f);
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, below.weight * transmission, in.normal);
  lobe.correlated = true;
  lobe.eta = eta;
  lobe.f0 = transmission_f0(in);
  lobe.transmission_tint = glm::clamp(in.base_color, 0.0f, 1.0f);
  lobe.film = in.film;
  set_roughness(lobe, alpha, alpha);
  lobe.normal_fresnel = NormalFresnel::ThinReflected;
  compensate(lobe, Compensation::Scaled, glm::max(in.specular_tint_color, 0.0f));
  if (in.reflective_caustics) {
    Lobe reflection = lobe;
    add_below(bsdf, below, reflection);
  }
  if (!in.refractive_caustics) return;
  // In Cycles 5.2, light goes straight on only if the product of both alphas is at most kStraight. Our limit for a delta
  // lobe is larger. Between both limits the lobe is a little rougher than asked for, so that it is no delta lobe.
  constexpr float kStraight = 2e-10f;
  float through = saturate(alpha * safe_sqrt(3.4f * (eta - 1.0f) * sqr(eta - 0.5f) / (eta * eta * eta)));
  if (sqr(through) > kStraight) through = std::max(through, 1.001f * std::sqrt(kDeltaAlphaProduct));
  lobe.kind = LobeKind::MicrofacetThin;
  lobe.normal_fresnel = NormalFresnel::ThinTransmitted;
  lobe.compensation = Compensation::None;
  set_roughness(lobe, through, through);
  if (lobe.is_delta()) {
    bsdf.bind_to_view();
    Lobe straight = make_lobe(LobeKind::Transparent, lobe_scattered(lobe, glm::dot(in.normal, surface.wo)), in.normal);
    straight.thin_wall = true;
    add_below(bsdf, below, straight);
    return;
  }
  compensate(lobe, Compensation::Scaled, Color(1.0f));
  add_below(bsdf, below, lobe);
}

/// The index of refraction, and the reflectance at normal incidence, after the change by Specular IOR Level.
struct Specular {
  float eta, f0;
};
Specular specular_of(const PrincipledInputs& in) {
  Specular specular{std::max(in.ior, 1e-5f), 0.0f};
  specular.f0 = fresnel::f0_from_eta(specular.eta);
  if (in.specular_ior_level == 0.5f) return specular;
  specular.f0 *= 2.0f * std::max(in.specular_ior_level, 0.0f);
  specular.eta = fresnel::eta_from_f0(specular.f0);
  if (in.ior < 1.0f) specular.eta = 1.0f / specular.eta;
  return specular;
}

void add_specular_v2(Bsdf& bsdf, const Surface& surface, Below& below, const PrincipledInputs& in) {
  const auto [eta, f0] = specular_of(in);
  if ((eta == 1.0f && !(in.film.thickness > thin_film::kThinnest)) || !in.reflective_caustics) return;
  Lobe lobe = make_lobe(LobeKind::MicrofacetReflection, below.weight, in.normal);
  lobe.fresnel = FresnelKind::DielectricTint;
  lobe.eta = eta;
  lobe.f0 = glm::min(f0 * glm::max(in.specular_tint_color, 0.0f), 1.0f);
  lobe.correlated = true;
  lobe.film = in.film;
  set_anisotropy(lobe, in);
  if (compensated_v2(in)) compensate(lobe, Compensation::Scaled, mean_dielectric_tint(lobe.f0, lobe.f90, eta));
  add_covering(bsdf, surface, below, lobe, 0.0f, Color(1.0f));
}

/// Diffuse reflection and subsurface scattering, which both have the base colour. Light that does not enter is
/// reflected.
void add_base_v2(Bsdf& bsdf, const Surface& surface, const Below& below, const PrincipledInputs& in) {
  const float subsurface = in.subsurface > kWeightCutoff ? saturate(in.subsurface) : 0.0f;
  const Color color = below.weight * glm::clamp(in.base_color, 0.0f, 1.0f);  // of subsurface scattering
  const float diffuse_roughness = in.diffuse_roughness < 1e-5f ? 0.0f : saturate(in.diffuse_roughness);
  const auto add_diffuse_lobe = [&](LobeKind kind, Color weight, float roughness) {
    const bool keeps_normal = in.keeps_normal && kind == LobeKind::Diffuse;
    Lobe lobe = make_lobe(kind, weight, keeps_normal ? in.diffuse_normal : in.normal);
    lobe.ignores_eye = keeps_normal;
    lobe.roughness = roughness;
    lobe.f0 = glm::clamp(in.base_color, 0.0f, 1.0f);
    add_below(bsdf, below, lobe);
  };
  if (subsurface > 0.0f && is_thin(in)) {
    // Dense scattering in a sheet: the anisotropy divides light between both sides (OpenPBR 1.1, "Thin-walled case").
    const float forwards = saturate(0.5f * (1.0f + in.subsurface_anisotropy));
    add_diffuse_lobe(LobeKind::Diffuse, color * subsurface * (1.0f - forwards), diffuse_roughness);
    add_diffuse_lobe(LobeKind::Translucent, color * subsurface * forwards, diffuse_roughness);
  } else if (subsurface > 0.0f && in.enters) {
    add_subsurface(bsdf, surface, color * subsurface, in.normal, principled_medium(in), below.layers);
  } else if (subsurface > 0.0f) {
    add_diffuse_lobe(LobeKind::Diffuse, color * subsurface, 0.0f);
  }
  const Color reflected = below.weight * glm::max(in.base_color, 0.0f);  // may amplify light, as in Cycles
  add_diffuse_lobe(LobeKind::Diffuse, reflected * (1.0f - subsurface), diffuse_roughness);
}

void add_principled_v2(Bsdf& bsdf, const Surface& surface, Color weight, const PrincipledInputs& in) {
  const float metallic = saturate(in.metallic), transmission = saturate(in.transmission);
  Below below{weight};
  if (in.sheen > kWeightCutoff) add_sheen_v2(bsdf, surface, below, in);
  if (in.clearcoat > kWeightCutoff) add_coat_v2(bsdf, surface, below, in);
  if (metallic > kWeightCutoff && in.reflective_caustics) add_metal_v2(bsdf, below, metallic, in);
  below.weight *= 1.0f - metallic;
  if (transmission > kWeightCutoff && is_thin(in))
    add_thin_glass_v2(bsdf, surface, below, transmission, in);
  else if (transmission > kWeightCutoff && (in.reflective_caustics || in.refractive_caustics))
    add_transmission_v2(bsdf, surface, below, transmission, in);
  below.weight *= 1.0f - transmission;
  if (!(max_component(below.weight) > kWeightCutoff)) return;
  add_specular_v2(bsdf, surface, below, in);
  add_base_v2(bsdf, surface, below, in);
}

}  // namespace

SubsurfaceMedium principled_medium(const PrincipledInputs& in) {
  const bool is_v2 = in.version >= 2;
  SubsurfaceInputs inputs{in.subsurface_method};
  inputs.albedo = is_v2 ? glm::clamp(in.base_color, 0.0f, 1.0f) : diffuse_color_v1(in);
  inputs.radius = in.subsurface_radius * (is_v2 ? in.subsurface_scale : saturate(in.subsurface));
  inputs.anisotropy = in.subsurface_anisotropy;
  inputs.ior = is_v2 && in.subsurface_method != SubsurfaceMethod::Skin ? specular_of(in).eta : in.subsurface_ior;
  inputs.alpha = sqr(saturate(in.roughness));
  SubsurfaceMedium medium = make_medium(inputs);
  medium.fresnel = !is_v2;
  return medium;
}

Color emission_through_coat(const Surface& surface, const PrincipledInputs& in) {
  Bsdf covers;
  covers.start(surface.ng, in.normal);
  Below below{Color(1.0f)};
  if (in.sheen > kWeightCutoff) add_sheen_v2(covers, surface, below, in);
  if (in.clearcoat > kWeightCutoff) add_coat_v2(covers, surface, below, in);
  return below.weight;
}

void add_principled(Bsdf& bsdf, const Surface& surface, Color weight, const PrincipledInputs& inputs) {
  if (inputs.version >= 2)
    add_principled_v2(bsdf, surface, weight, inputs);
  else
    add_principled_v1(bsdf, surface, weight, inputs);
}

}  // namespace ajar::closures
