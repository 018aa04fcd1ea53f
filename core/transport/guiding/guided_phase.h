// The directional sampling of a medium with a guide: a mixture of phase function and guide, with one density over
// directions (guided_bsdf.h tells how whole paths are a mixture, too). Light samples are weighted against the phase
// function alone, in both estimates of direct light. So the guide learns the light that light sampling does not find.
#pragma once

#include "transport/guiding/guided_bsdf.h"
#include "transport/media/phase_function.h"

namespace ajar {

/// A sampled direction.
struct PhaseSample {
  Vec3 wi;               ///< of travel after scattering
  Color value;           ///< of the phase function
  float pdf_phase, pdf;  ///< density by the phase function alone, and by the mixture
};

inline PhaseSample sample_phase(const PhaseFunction& phase, Vec3 direction, float u_lobe, Vec2 u) {
  const Vec3 wi = phase.sample(direction, u_lobe, u);
  const float cosine = glm::dot(direction, wi), pdf = phase.pdf_solid_angle(cosine);
  return {wi, phase.evaluate(cosine), pdf, pdf};
}

struct PhaseNumbers {
  float u_guide, u_lobe;
  Vec2 u;
};
/// The same with the guide at `place`, if it knows something there. `trust` is 1 - e_k.
inline PhaseSample sample_phase_guided(const PhaseFunction& phase, Vec3 direction, const GuideTree* tree, Vec3 place,
                                       float trust, const PhaseNumbers& numbers) {
  const auto& [u_guide, u_lobe, u] = numbers;
  const GuideDistribution* const found = tree ? tree->find_in_volume(place) : nullptr;
  const float share = found ? trust * found->share(GuideKind::Volume) : 0.0f;
  if (!(share > 0.0f)) return sample_phase(phase, direction, u_lobe, u);
  GuideLobes lobes;
  found->aim(place, lobes);
  PhaseSample sample;
  sample.wi = u_guide < share ? found->sample(lobes, u_guide / share, u) : phase.sample(direction, u_lobe, u);
  const float cosine = glm::dot(direction, sample.wi);
  sample.value = phase.evaluate(cosine);
  sample.pdf_phase = phase.pdf_solid_angle(cosine);
  sample.pdf = (1.0f - share) * sample.pdf_phase + share * pdf_solid_angle(lobes, sample.wi);
  return sample;
}

}  // namespace ajar
