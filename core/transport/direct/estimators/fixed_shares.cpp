#include "transport/direct/estimators/fixed_shares.h"

namespace ajar {

FixedShares::FixedShares(const Scene& scene, DirectMethod method, const DirectRequest& request)
    : DirectEstimator(scene, request), method_(method) {
  heuristic_ = method == DirectMethod::Light        ? Heuristic::LightsOnly
               : method == DirectMethod::MisBalance ? Heuristic::Balance
                                                    : Heuristic::Power;
}

float FixedShares::weight_of_hit(const Scene& scene, const DirectVertex& v, uint32_t light, Vec3 wi, Vec3 position,
                                 Vec3 normal) const {
  if (method_ == DirectMethod::Bsdf) return v.bsdf_pdf != 0.0f && v.complete ? 0.0f : 1.0f;
  return DirectEstimator::weight_of_hit(scene, v, light, wi, position, normal);
}

/// If only surfaces are sampled, light sampling covers the lights that no ray can hit.
Color FixedShares::one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex&, SampleAux*,
                              uint64_t& rays) const {
  LightCutCache::Choice chosen;
  return sample_light(c, sampler, first, LightCutCache::kNone, chosen, rays, [&](LightFlags light) {
    return method_ != DirectMethod::Bsdf || !light.mis || is_delta(light.type);
  });
}

Color FixedShares::many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                                uint64_t& rays) const {
  // If only lights are sampled, the path covers the lights that LightSet leaves to BSDF sampling.
  vertex.complete = method_ != DirectMethod::Light;
  const LobeComponents lobes(c.bsdf, c.point.wo, false);
  const float bsdf_share = method_ == DirectMethod::Light ? 0.0f : method_ == DirectMethod::Bsdf ? 1.0f : 0.5f;
  const LightMixture::Kernel k = mixture_.kernel(lobes, bsdf_share, LightMixture::Lights::Any);
  Color estimate = mean_of_draws(c, k, sampler, method_ == DirectMethod::Mis, rays);
  if (method_ == DirectMethod::Bsdf) {
    DirectVertex unused;
    estimate += one_sample(c, sampler, kBranchDimension, unused, aux, rays);
  }
  return estimate;
}

}  // namespace ajar
