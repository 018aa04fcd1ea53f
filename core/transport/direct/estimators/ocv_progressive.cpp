#include "transport/direct/estimators/ocv_progressive.h"

#include "platform/platform.h"

namespace ajar {

namespace {

using M = LightMixture;

}  // namespace

OcvProgressive::OcvProgressive(const Scene& scene, const DirectRequest& request)
    : DirectEstimator(scene, request, groups_to_choose(scene)), lobes_apart_(request.lobes_apart) {
  if (!scene.lights().can_choose()) return;
  columns_.emplace(scene, mixture_.groups(), false);
  const RenderSettings& settings = scene.settings();
  x0_ = settings.region[0];
  y0_ = settings.region[1];
  block_columns_ = (settings.width + kBlock - 1) / kBlock;
  const int rows = (settings.height + kBlock - 1) / kBlock;
  slots_.resize(size_t(block_columns_) * size_t(rows) * kSlots,
                {NormalEquations(M::kMaxMixtureLobes + columns_->light_columns()), {}});
}

OcvProgressive::Slot& OcvProgressive::slot(const DirectLightContext& c) const {
  const uint32_t block = uint32_t((c.pixel_y - y0_) / kBlock) * uint32_t(block_columns_) +
                         uint32_t((c.pixel_x - x0_) / kBlock);
  return slots_[size_t(block) * kSlots + hash32(c.material) % kSlots];
}

void OcvProgressive::learn() {
  // beta: penalised least squares [Fan 2006, eq. 6.11], with a relative penalty and without the intercept.
  for (Slot& slot : slots_) slot.coefficients = slot.past.fit(kRidgeMany, 4 * (1 + columns_->light_columns()));
}

/// Coefficients are used by later estimates on any surface, so they have the columns of all lobes.
Color OcvProgressive::many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                                   uint64_t& rays) const {
  vertex.complete = true;
  const LobeComponents lobes(c.bsdf, c.point.wo, lobes_apart_);
  const bool possible = columns_ && columns_->possible();
  const M::Kernel k = mixture_.kernel(lobes, 0.5f, possible ? M::Lights::GroupsAlike : M::Lights::Any);
  if (!columns_) return mean_of_draws(c, k, sampler, false, rays);
  mixture_.record_shares(k, aux);
  std::vector<ControlSample>& samples = platform::of_thread<std::vector<ControlSample>>();
  samples.clear();
  mixture_.for_each_draw({c, k, rays}, std::min(samples_, kMaxControlSamples), 0, sampler,
                         [&](int component, const M::Draw& draw) {
                           if (possible)
                             samples.push_back(columns_->sample(c, k, M::kMaxMixtureLobes, component, draw));
                           else
                             samples.emplace_back().y = draw.y;
                         });
  if (!possible) return control_estimate(samples, {});
  Slot& here = slot(c);
  // I(beta) with the beta of earlier iterations [Fan 2006, eq. 6.7]. The samples are added afterwards, so none corrects
  // itself.
  const Color estimate = control_estimate(samples, here.coefficients);
  for (const ControlSample& sample : samples) here.past.add(sample);
  return estimate;
}

}  // namespace ajar
