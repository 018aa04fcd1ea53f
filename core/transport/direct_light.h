// Direct light at one surface point by one sample of one light, weighted against the BSDF's own
// chance of finding that light (multiple importance sampling, Veach 1997, section 9.2).
#pragma once

#include "math/random.h"
#include "scene/scene.h"

namespace ajar {

/// Power heuristic with exponent 2 for two densities of the same measure [Veach 1997, eq. 9.13].
inline float power_heuristic(float pdf_a, float pdf_b) {
  // Ratio first: squares of large densities overflow.
  if (!(pdf_a > 0.0f)) return 0.0f;
  const float ratio = pdf_b / pdf_a;
  return 1.0f / (1.0f + ratio * ratio);
}

struct DirectLightContext {
  const Scene& scene;
  const ShadingPoint& point;
  const Bsdf& bsdf;
};

/// One-sample estimate of the light that arrives directly and is scattered towards wo. `rays` counts shadow rays.
inline Color estimate_direct(const DirectLightContext& c, float u_choice, Vec2 u, uint64_t& rays) {
  const LightSet& lights = c.scene.lights();
  const auto choice = lights.choose(c.point.position, c.point.ns, u_choice);
  if (!(choice.pmf > 0.0f)) return Color(0.0f);
  const auto sample = lights.sample_li(choice.light, c.point.position, u, c.point.time);
  if (!sample || is_black(sample->radiance)) return Color(0.0f);
  const Bsdf::Evaluation scattered = c.bsdf.evaluate(c.point.wo, sample->wi);
  if (is_black(scattered.f_cos)) return Color(0.0f);
  const LightFlags light = lights.flags(choice.light);
  float weight = 1.0f / (choice.pmf * sample->pdf_solid_angle);
  if (!sample->delta && light.mis) weight *= power_heuristic(choice.pmf * sample->pdf_solid_angle, scattered.pdf_solid_angle);
  Color contribution = scattered.f_cos * sample->radiance * weight;
  if (light.cast_shadow) {
    ++rays;
    contribution *= c.scene.transmittance(c.scene.spawn_segment(c.point, sample->wi, sample->distance),
                                          c.scene.settings().bounces.transparent);
  }
  return contribution;
}

}  // namespace ajar
