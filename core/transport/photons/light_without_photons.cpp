// The part of PhotonGatherer (photon_gather.h) that finds light which sends no photons.
#include <algorithm>
#include <cmath>

#include "math/random.h"
#include "transport/media/subsurface_walk.h"
#include "transport/photons/photon_gather.h"

namespace ajar {

namespace {
constexpr int kFreeBounces = 2;  // before roulette
}  // namespace

Color PhotonGatherer::light_without_photons(const ShadingPoint& from, const Bsdf& rough, const Place& place,
                                            uint32_t dimension) {
  const BounceLimits& limits = scene_.settings().bounces;
  Pcg32 rng(hash_combine(hash_combine(pixel_, index_), dimension + uint32_t(gathered_)), 0x756E6C69U);
  // Each of the gather rays of a surface goes on with this probability: one of them in the mean.
  const float rays = float(std::max(1, settings_.rays));
  if (!(rng.next_float() * rays < 1.0f)) return Color(0.0f);
  const auto sampled = [&rng](const Bsdf& bsdf, Vec3 wo) {
    const float u_lobe = rng.next_float(), ux = rng.next_float();
    return bsdf.sample(wo, u_lobe, {ux, rng.next_float()});
  };
  const auto first = sampled(rough, from.wo);
  if (!first || !(first->pdf_solid_angle > 0.0f)) return Color(0.0f);
  Color radiance(0.0f), beta = first->f_cos / first->pdf_solid_angle * rays;
  EyeWalk walk(scene_, scene_.spawn_ray(from, first->wi), rays_, from);
  EyeMedia media(scene_, media_, stack_towards(from, place, first->wi), rng.next(), rays_);
  media.count_only_emission();
  ShadingPoint& point = walk.point;
  const SurfaceShading& shading = walk.shading;
  count_bounce(*first, from, point);
  bool at_bounce_limit = past_limits(point, limits);
  while (max_component(beta) > 0.0f) {
    walk.trace();
    if (media.active()) {
      EyeMedia::Light light;
      const EyeMedia::Step step = media.pass(walk, {sampler_, 0, !at_bounce_limit}, beta, light);
      radiance += light.sum();
      if (step == EyeMedia::Step::End) break;
      at_bounce_limit = at_bounce_limit || past_limits(point, limits) || media.at_limit();
      if (step == EyeMedia::Step::Traced) continue;
    }
    if (!walk.found()) break;
    walk.arrive();
    walk.shade();
    if (scene_.light_of(walk.hit) < 0) radiance += beta * shading.emission;
    if (at_bounce_limit && is_black(shading.bsdf.transparency())) break;
    if (!at_bounce_limit && shading.bsdf.has_subsurface() && !on_strand_or_point(point) &&
        !walk_below_or_stay(scene_, walk.hit.instance, {rng.next_float(), rng.next()}, point, walk.shading, beta,
                            rays_))
      break;
    const auto sample = sampled(shading.bsdf, point.wo);
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) break;
    beta *= sample->f_cos / sample->pdf_solid_angle;
    if (sample->flags & kTransparent) {
      media.leave(walk, walk.ray.direction);
      if (!walk.pass_through()) break;
      continue;
    }
    if (at_bounce_limit) break;
    count_bounce(*sample, point, point);
    at_bounce_limit = past_limits(point, limits);
    if (point.ray_depth > kFreeBounces) {
      const float survival = std::min(1.0f, std::sqrt(max_component(beta) / rays));
      if (!(rng.next_float() < survival)) break;
      beta /= survival;
    }
    media.leave(walk, sample->wi);
    media.scattered_at_surface();
    walk.leave_along(sample->wi);
  }
  return radiance;
}

}  // namespace ajar
