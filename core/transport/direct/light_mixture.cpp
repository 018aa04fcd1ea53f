#include "transport/direct/light_mixture.h"

#include "math/warps.h"
#include "transport/paths/ray_events.h"

namespace ajar {

namespace {

/// Calls visit(light, radiance, normal, distance) for each light along a ray, up to the first opaque surface.
template <class Visit>
void for_each_light_along(const Scene& scene, const ShadingPoint& from, Vec3 wi, uint32_t ray_kind, uint64_t& rays,
                          Visit&& visit) {
  Ray ray = scene.spawn_ray(from, wi);
  Color through(1.0f);
  ShadingPoint point;
  for (int crossed = 0;; ++crossed) {
    const Hit hit = scene.intersect(ray, ray_kind);
    ++rays;
    const auto visit_met = [&](const LightMet& met) {
      visit(met.light, through * met.radiance, met.normal,
            is_finite(met.position) ? glm::length(met.position - from.position) : kInfinity);
    };
    if (scene.has_lamp_shapes()) for_each_lamp_crossed(scene, ray, hit.t, ray_kind, visit_met);
    if (!hit.found()) {
      for_each_distant_light(scene, ray, ray_kind, true, visit_met);
      return;
    }
    const ShaderProgram& program = scene.material(hit);
    const int light = scene.light_of(hit);
    const bool transparent = program.may_be_transparent();
    if (light < 0 && !transparent) return;
    scene.shading_point(ray, hit, point);
    point.ray_kind = ray_kind;
    if (light >= 0)
      visit(uint32_t(light), through * program.evaluate_emission(point), point.ng,
            glm::length(point.position - from.position));
    if (!transparent || crossed >= scene.settings().bounces.transparent) return;
    through *= program.evaluate_transparency(point);
    if (!(max_component(through) > 0.0f)) return;
    ray = scene.straight_on(point, ray, hit.t);
  }
}

}  // namespace

LightMixture::Kernel LightMixture::kernel(const LobeComponents& lobes, float bsdf_share, Lights by) const {
  Kernel k{lobes};
  k.count = kFirstGroup + groups_.size();
  k.alpha.fill(0.0f);
  const float lights = 1.0f - bsdf_share;
  for (int i = 0; i < lobes.count(); ++i) k.alpha[size_t(i)] = bsdf_share * lobes.prior(i);
  if (by == Lights::Any) k.alpha[kAny] = lights;
  for (int g = 0; by != Lights::Any && g < groups_.size(); ++g)
    k.alpha[size_t(kFirstGroup + g)] = by == Lights::GroupsByPrior ? lights * groups_.prior(g)
                                                                   : lights / float(groups_.size());
  return k;
}

LightMixture::Densities LightMixture::densities(const DirectLightContext& c, const Kernel& k, const LightDirection& at,
                                                const std::array<float, kMaxMixtureLobes>& pdf_lobes) const {
  // The summands of the kernel K_HI [Fan 2006, eq. 5.6].
  Densities d{{}, 0.0f, 0.0f, 0.0f, 0.0f, -1};
  if (at.mis) {
    for (int i = 0; i < k.lobes.count(); ++i) d.bsdf += d.lobes[size_t(i)] = k.alpha[size_t(i)] * pdf_lobes[size_t(i)];
    if (k.alpha[kCone] > 0.0f && 1.0f - glm::dot(k.cone.n, at.wi) <= k.one_minus_cos)
      d.cone = k.alpha[kCone] * warp::cone_pdf_solid_angle(k.one_minus_cos);
  }
  if (k.alpha[kAny] > 0.0f)
    d.any = k.alpha[kAny] *
            (at.known_pmf >= 0.0f ? at.known_pmf
                                  : choice_pmf(k.cell, c.point.position, c.bsdf.receiving_normal(), at.light)) *
            at.pdf_light;
  d.group_index = groups_.size() > 0 ? groups_.group_of(at.light) : -1;
  if (d.group_index >= 0)
    d.group = k.alpha[size_t(kFirstGroup + d.group_index)] * groups_.pmf_in_group(at.light) * at.pdf_light;
  return d;
}

/// Adds light f that was found at a sample with densities d. The power heuristic distinguishes BSDF and lights.
void LightMixture::add_found(const Densities& d, Color f, bool power, bool from_bsdf, Draw& out) const {
  const float total = d.total();
  if (!(total > 0.0f)) return;
  if (power) {
    // w / a with w = a^2 / (a^2 + b^2), where a belongs to the technique that drew the sample.
    const float lights = d.any + d.group, a = from_bsdf ? d.bsdf : lights, b = from_bsdf ? lights : d.bsdf;
    out.y += f * (power_heuristic(a, b) / a);
    return;
  }
  // y = f / K [Fan 2006, eq. 5.7], which is the balance heuristic (eq. 6.4).
  const Color y = f / total;
  out.y += y;
  // Luminance of y times rho_k = alpha_k p_k / K, from which the shares are learned (eq. 5.8).
  const float luminous = luminance_of(y) / total;
  for (int i = 0; i < kMaxMixtureLobes; ++i) out.responsible[size_t(i)] += luminous * d.lobes[size_t(i)];
  out.responsible[kCone] += luminous * d.cone;
  out.responsible[kAny] += luminous * d.any;
  if (d.group_index >= 0) out.responsible[size_t(kFirstGroup + d.group_index)] += luminous * d.group;
}

void LightMixture::draw_light(const Estimate& estimate, int component, float u_choice, Vec2 u, Draw& out) const {
  const DirectLightContext& c = estimate.c;
  const Kernel& k = estimate.k;
  const LightSet& lights = scene_.lights();
  uint32_t index;
  float known_pmf = -1.0f;
  if (component == kAny) {
    out.choice = choose_light(k.cell, c, u_choice);
    const LightSet::Choice& choice = out.choice.choice;
    if (!(choice.pmf > 0.0f)) return;
    index = choice.light;
    known_pmf = choice.pmf;
    if (lights.size() < kFewLights) u.x = choice.u_remapped;
  } else {
    index = groups_.choose(component - kFirstGroup, u_choice);
  }
  const auto sample = lights.sample_li(index, c.point.position, u, c.point.time);
  if (!sample) return;
  const LightFlags light = lights.flags(index);
  const bool mis = !sample->delta && light.mis;
  if (mis) out.wi = sample->wi;
  const LobeComponents::Evaluation scattered = k.lobes.evaluate(c.point.wo, sample->wi);
  out.pdf_lobes = scattered.pdf;
  Color f = scattered.f_cos * sample->radiance;
  if (is_black(f)) return;
  if (light.cast_shadow) {
    ++estimate.rays;
    f *= scene_.transmittance(scene_.spawn_segment(c.point, *sample), scene_.settings().bounces.transparent);
    if (is_black(f)) return;
  }
  const LightDirection at{index, sample->wi, sample->pdf_solid_angle, mis, known_pmf};
  add_found(densities(c, k, at, scattered.pdf), f, estimate.power, false, out);
}

void LightMixture::draw_direction(const Estimate& estimate, int component, float u_choice, Vec2 u, Draw& out) const {
  const DirectLightContext& c = estimate.c;
  const Kernel& k = estimate.k;
  Vec3 wi;
  Color f_cos;
  uint32_t kind;
  if (component < kMaxMixtureLobes) {
    const auto sample = k.lobes.sample(component, c.point.wo, u_choice, u);
    // Delta lobes and transparency are left to the path.
    if (!sample) return;
    wi = sample->wi;
    f_cos = sample->value.f_cos;
    out.pdf_lobes = sample->value.pdf;
    kind = ray_kind_after(sample->flags);
  } else {
    wi = k.cone.to_world(warp::square_to_cone(u, k.one_minus_cos));
    const LobeComponents::Evaluation scattered = k.lobes.evaluate(c.point.wo, wi);
    f_cos = scattered.f_cos;
    out.pdf_lobes = scattered.pdf;
    kind = kRayReflection | kRayDiffuse;
  }
  out.wi = wi;
  if (is_black(f_cos)) return;
  const LightSet& lights = scene_.lights();
  for_each_light_along(
      scene_, c.point, wi, kind, estimate.rays, [&](uint32_t light, Color radiance, Vec3 normal, float distance) {
        if (is_black(radiance)) return;
        const float pdf_light = lights.pdf_li(light, c.point.position, wi, distance, normal, c.point.time);
        add_found(densities(c, k, {light, wi, pdf_light, true}, out.pdf_lobes), f_cos * radiance, estimate.power, true,
                  out);
      });
}

LightCutCache::Choice LightMixture::choose_light(uint32_t cell, const DirectLightContext& c, float u) const {
  const Vec3 p = c.point.position, n = c.bsdf.receiving_normal();
  return cell == LightCutCache::kNone ? LightCutCache::Choice{scene_.lights().choose(p, n, u), 0, 0.0f}
                                      : cuts_->choose(cell, p, n, u);
}

float LightMixture::choice_pmf(uint32_t cell, Vec3 position, Vec3 normal, uint32_t light) const {
  return cell == LightCutCache::kNone ? scene_.lights().choice_pmf(position, normal, light)
                                      : cuts_->pmf(cell, position, normal, light);
}

void LightMixture::record_shares(const Kernel& k, SampleAux* aux) const {
  if (!aux) return;
  aux->shares[0] = k.bsdf_share();
  for (int i = 0; i < k.lobes.count(); ++i) aux->shares[size_t(4 + i)] = k.alpha[size_t(i)];
  for (int g = 0; g < std::min(2, groups_.size()); ++g) aux->shares[size_t(1 + g)] = k.alpha[size_t(kFirstGroup + g)];
  aux->shares[3] = k.alpha[kCone];
}

}  // namespace ajar
