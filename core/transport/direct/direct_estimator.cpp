#include "transport/direct/direct_estimator.h"

namespace ajar {

Color DirectEstimator::one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex&,
                                  SampleAux*, uint64_t& rays) const {
  LightCutCache::Choice chosen;
  return sample_light(c, sampler, first, LightCutCache::kNone, chosen, rays, [](LightFlags) { return true; });
}

Color DirectEstimator::weight_sample(const DirectLightContext& c, const LightSet::Choice& chosen, LightFlags light,
                                     const LightSample& sample, uint64_t& rays) const {
  const Bsdf::Evaluation scattered = c.evaluate(sample.wi);
  if (is_black(scattered.f_cos)) return Color(0.0f);
  const float pdf = chosen.pmf * sample.pdf_solid_angle;
  float weight = 1.0f / pdf;
  // Balance heuristic [Veach 1997, eq. 9.8; Fan 2006, eq. 2.23] or power heuristic [Veach 1997, eq. 9.13].
  if (!sample.delta && light.mis && heuristic_ != Heuristic::LightsOnly)
    weight *= heuristic_ == Heuristic::Balance
                  ? pdf / (pdf + scattered.pdf_solid_angle)
                  : power_heuristic(counted_light_pdf(pdf, sample.distance, weights_define_light(scene_)),
                                    scattered.pdf_solid_angle);
  Color contribution = scattered.f_cos * sample.radiance * weight;
  if (light.cast_shadow) {
    ++rays;
    contribution *= scene_.transmittance(scene_.spawn_segment(c.point, sample), scene_.settings().bounces.transparent);
  }
  return contribution;
}

float DirectEstimator::weight_of_hit(const Scene& scene, const DirectVertex& v, uint32_t light, Vec3 wi, Vec3 position,
                                     Vec3 normal) const {
  if (v.bsdf_pdf == 0.0f) return 1.0f;
  if (v.complete) return 0.0f;
  const float distance = is_finite(position) ? glm::length(position - v.position) : kInfinity;
  const float light_pdf = mixture_.choice_pmf(v.cell, v.position, v.normal, light) *
                          scene.lights().pdf_li(light, v.position, wi, distance, normal, v.time);
  if (heuristic_ == Heuristic::LightsOnly) return light_pdf > 0.0f ? 0.0f : 1.0f;
  return heuristic_ == Heuristic::Balance
             ? v.bsdf_pdf / (v.bsdf_pdf + light_pdf)
             : power_heuristic(v.bsdf_pdf, counted_light_pdf(light_pdf, distance, weights_define_light(scene)));
}

Color DirectEstimator::mean_of_draws(const DirectLightContext& c, const LightMixture::Kernel& k, Sampler& sampler,
                                     bool power, uint64_t& rays) const {
  // The mixture estimator 1 / N sum_i f(x_i) / K(x_i) [Fan 2006, eq. 6.6].
  Color sum(0.0f);
  mixture_.for_each_draw({c, k, rays, power}, samples_, 0, sampler,
                         [&](int, const LightMixture::Draw& draw) { sum += draw.y; });
  return sum / float(samples_);
}

}  // namespace ajar
