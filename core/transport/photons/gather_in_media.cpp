// The part of PhotonGatherer (photon_gather.h) for volumes along camera rays.
#include <algorithm>
#include <cmath>

#include "math/random.h"
#include "transport/photons/photon_gather.h"

namespace ajar {

EyeMedia::Step PhotonGatherer::pass_media(EyeMedia& media, EyeWalk& walk, uint32_t number, bool may_scatter,
                                          Color& beta, Color& radiance, float& alpha) {
  EyeMedia::Light light;
  EyeMedia::Step step = media.meet(
      walk, {sampler_, kMediaDimensions + EyeMedia::kDimensions * number, may_scatter, true}, beta, light, &alpha);
  radiance += light.sum();
  if (!in_media_) direct_paths_ += light.sum();
  if (passes_) [[unlikely]]
    add_to_passes(light, walk.point.ray_depth);
  if (step != EyeMedia::Step::Scattered) return step;
  in_media_ = true;
  if (passes_ && walk.point.ray_depth == 0) [[unlikely]]
    first_.part = PathPasses::Part::VolumeDirect;
  if ((maps_.has_global || log_) && media.may_scatter_again(walk)) {
    radiance += gathered_in_medium(media, walk, beta, number);
    return EyeMedia::Step::End;
  }
  return media.scatter(walk, beta) ? EyeMedia::Step::Traced : EyeMedia::Step::End;
}

Color PhotonGatherer::gathered_in_medium(const EyeMedia& media, const EyeWalk& walk, Color beta, uint32_t number) {
  const int rays = std::max(1, int(std::ceil(float(settings_.rays) * std::min(1.0f, max_component(glm::abs(beta))))));
  const Color share = beta / float(rays);
  const int bounces = walk.point.ray_depth + 1;
  const bool logs = logs_;
  Color gathered(0.0f);
  for (int i = 0; i < rays; ++i) {
    gather_sampler_.start(hash_combine(pixel_, kMediaDimensions + number), index_ * uint32_t(rays) + uint32_t(i));
    const GatherNumbers u(gather_sampler_, 0, guide_ != nullptr);
    EyeMedia own(media);
    own.reseed(hash_combine(hash_combine(pixel_, index_), kMediaDimensions + uint32_t(++gathered_)));
    const PhaseSample sample = own.sample_direction(walk, {u.guide, u.lobe, u.direction});
    if (!(sample.pdf_phase > 0.0f)) continue;
    const Color weight = sample.value / sample.pdf;
    EyeWalk next(walk);
    own.leave_along(next, sample);
    const Color logged = logs_gather_ray(uint32_t(i)) ? share * weight : Color(0.0f);
    const Incoming arriving = follow(next, own, {}, logged, 0, {gather_sampler_, kGatherDimensions});
    logs_ = logs;
    const Color direct = weight * arriving.direct, indirect = weight * arriving.scattered;
    gathered += direct + indirect;
    if (passes_) [[unlikely]] {
      add_to_passes(share * direct, bounces);
      add_to_passes(share * indirect, bounces + 1);
    }
    learn_from(
        {media.place(), Vec3(0.0f), sample.wi, 0.0f, luminance(direct + indirect), sample.pdf_phase, GuideKind::Volume},
        arriving.distance, index_ * uint32_t(rays) + uint32_t(i));
  }
  return share * gathered;
}

}  // namespace ajar
