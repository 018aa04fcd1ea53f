#include "transport/direct/estimators/ris.h"

#include <bit>

namespace ajar {

namespace {

constexpr int kRisCandidates = 8;

}  // namespace

Color Ris::one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex&, SampleAux*,
                      uint64_t& rays) const {
  const LightSet& lights = scene_.lights();
  sampler.set_dimension(first);
  float u_keep = sampler.get_1d();
  sampler.set_dimension(first + 1);
  float sum = 0.0f, kept_target = 0.0f;
  Color kept(0.0f);
  LightSample kept_sample{};
  bool kept_shadow = true;
  for (int i = 0; i < kRisCandidates; ++i) {
    Sampler numbers = sampler.branch(uint32_t(i), kRisCandidates);
    const auto choice = lights.choose(c.point.position, c.bsdf.receiving_normal(), numbers.get_1d());
    if (!(choice.pmf > 0.0f)) continue;
    const auto sample = lights.sample_li(choice.light, c.point.position, numbers.get_2d(), c.point.time);
    if (!sample || is_black(sample->radiance)) continue;
    const Bsdf::Evaluation scattered = c.evaluate(sample->wi);
    const LightFlags light = lights.flags(choice.light);
    const float pdf = choice.pmf * sample->pdf_solid_angle;
    float weight = 1.0f / pdf;
    if (!sample->delta && light.mis)
      weight *= power_heuristic(counted_light_pdf(pdf, sample->distance, weights_define_light(scene_)),
                                scattered.pdf_solid_angle);
    const Color value = scattered.f_cos * sample->radiance * weight;
    // g(x_i) / p_i: the contribution of the candidate without visibility.
    const float target = luminance_of(value);
    if (!(target > 0.0f)) continue;
    sum += target;
    // Keep this candidate with probability target / sum. One random number is enough for all; it is rescaled each time.
    const float keep = target / sum;
    if (u_keep < keep) {
      u_keep /= keep;
      kept = value;
      kept_target = target;
      kept_sample = *sample;
      kept_shadow = light.cast_shadow;
    } else {
      u_keep = (u_keep - keep) / (1.0f - keep);
    }
    u_keep = std::min(u_keep, kOneMinusEpsilon);
  }
  if (!(sum > 0.0f)) return Color(0.0f);
  // f / g * (1 / M) sum_i g(x_i) / p_i [Fan 2006, eq. 3.18]. `kept` is f / p_i without visibility.
  Color estimate = kept * (sum / (kept_target * float(kRisCandidates)));
  if (kept_shadow) {
    ++rays;
    estimate *= scene_.transmittance(scene_.spawn_segment(c.point, kept_sample), scene_.settings().bounces.transparent);
  }
  return estimate;
}

Color Ris::many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                        uint64_t& rays) const {
  Color sum(0.0f);
  sampler.set_dimension(kBranchDimension);
  for (int i = 0; i < samples_; ++i) {
    Sampler numbers = sampler.branch(uint32_t(i), std::bit_ceil(uint32_t(samples_)));
    sum += one_sample(c, numbers, 0, vertex, aux, rays);
  }
  return sum / float(samples_);
}

}  // namespace ajar
