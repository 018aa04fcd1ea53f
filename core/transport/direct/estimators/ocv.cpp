#include "transport/direct/estimators/ocv.h"

#include "platform/platform.h"

namespace ajar {

namespace {

using M = LightMixture;

}  // namespace

Ocv::Ocv(const Scene& scene, DirectMethod method, const DirectRequest& request)
    : DirectEstimator(scene, with_enough_samples(request), groups_to_choose(scene)),
      method_(method),
      lobes_apart_(request.lobes_apart && method != DirectMethod::Correlated) {
  if (scene.lights().can_choose()) columns_.emplace(scene, mixture_.groups(), method == DirectMethod::Correlated);
}

Color Ocv::many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                        uint64_t& rays) const {
  vertex.complete = true;
  const LobeComponents lobes(c.bsdf, c.point.wo, lobes_apart_);
  const bool possible = columns_ && columns_->possible();
  const M::Kernel k = mixture_.kernel(lobes, 0.5f,
                                      !possible                             ? M::Lights::Any
                                      : method_ == DirectMethod::Correlated ? M::Lights::GroupsByPrior
                                                                            : M::Lights::GroupsAlike);
  if (!columns_) return mean_of_draws(c, k, sampler, false, rays);
  mixture_.record_shares(k, aux);
  std::vector<ControlSample>& samples = platform::of_thread<std::vector<ControlSample>>();
  const int n = std::min(samples_, kMaxControlSamples);
  samples.resize(size_t(n));
  // Two folds with equal shares.
  const int folds = method_ == DirectMethod::OcvPaper ? 1 : 2;
  int filled = 0, first_fold = 0;
  for (int fold = 0; fold < folds; ++fold) {
    const int count = fold == 0 ? n / folds : n - n / folds;
    mixture_.for_each_draw({c, k, rays}, count, fold, sampler, [&](int component, const M::Draw& draw) {
      ControlSample& sample = samples[size_t(filled++)];
      if (possible)
        sample = columns_->sample(c, k, lobes.count(), component, draw);
      else
        sample.y = draw.y;
    });
    if (fold == 0) first_fold = filled;
  }
  const std::span<const ControlSample> all(samples.data(), size_t(filled));
  if (!possible) return control_estimate(all, {});
  const int components = lobes.count() + columns_->light_columns();
  // The published form fits and corrects with the same samples [Fan 2006, eq. 6.10 and 6.11]. The unbiased form
  // corrects each fold by the beta of the other (eq. 6.7).
  if (method_ == DirectMethod::OcvPaper) return ocv_paper(all, components);
  return ocv_cross_fitted(all.subspan(0, size_t(first_fold)), all.subspan(size_t(first_fold)), components);
}

}  // namespace ajar
