// The part of PhotonGatherer (photon_gather.h) that finds light which brings no photons: emission that sends none, light
// beyond the shadow terminator (shadow_terminator.h), and light by way of surfaces that depend on the kind of the ray
// (ray_kind_surfaces.h). A walk that has met an eye-only surface finds all light from there on.
#include <algorithm>
#include <cmath>

#include "math/random.h"
#include "transport/media/subsurface_walk.h"
#include "transport/photons/photon_gather.h"

namespace ajar {

namespace {
constexpr int kFreeBounces = 2;  // before roulette
constexpr uint32_t kStream = 0x756E6C69U, kBeyondStream = 0x62796E64U, kByKindStream = 0x6B696E64U;

std::optional<BsdfSample> sampled(const Bsdf& bsdf, Vec3 wo, Pcg32& rng) {
  const float u_lobe = rng.next_float(), ux = rng.next_float();
  return bsdf.sample(wo, u_lobe, {ux, rng.next_float()});
}

}  // namespace

Color PhotonGatherer::light_beyond(const ShadingPoint& point, const Bsdf& bsdf, const Place& place, Pcg32& rng) {
  if (!has_soft_terminator(point)) return Color(0.0f);
  return sampled_light<SampledPart::BeyondTerminator>(point, bsdf, place, rng);
}

Color PhotonGatherer::light_beyond(const ShadingPoint& point, const Bsdf& bsdf, const Place& place, uint32_t number) {
  const float probability = settings_.beyond_terminator;
  if (!(probability > 0.0f) || log_only_ || !has_soft_terminator(point)) return Color(0.0f);
  Pcg32 rng(hash_combine(hash_combine(pixel_, index_), number + uint32_t(gathered_)), kBeyondStream);
  if (!(rng.next_float() < probability)) return Color(0.0f);
  const uint64_t before = rays_;
  const Color light = light_beyond(point, bsdf, place, rng) / probability;
  beyond_.note_found(light, rays_ - before, probability);
  return light;
}

Color PhotonGatherer::light_past_ray_kinds(const ShadingPoint& point, const Bsdf& rough, const Place& place,
                                           uint32_t number) {
  Pcg32 rng(hash_combine(hash_combine(pixel_, index_), number + uint32_t(gathered_)), kByKindStream);
  return sampled_light<SampledPart::ByRayKind>(point, rough, place, rng, false);
}

Color PhotonGatherer::light_without_photons(const ShadingPoint& from, const Bsdf& rough, const Place& place,
                                            uint32_t dimension) {
  Color radiance = light_beyond(from, rough, place, dimension), beyond(0.0f);
  Pcg32 rng(hash_combine(hash_combine(pixel_, index_), dimension + uint32_t(gathered_)), kStream);
  // Each of the gather rays of a surface goes on with this probability: one of them in the mean, if there is emission.
  const float share = settings_.light_without_photons ? 1.0f : settings_.beyond_terminator;
  const float rays = float(std::max(1, settings_.rays)) / share;
  if (!(rng.next_float() * rays < 1.0f)) return radiance;
  const uint64_t before = rays_;
  const auto first = sampled(rough, from.wo, rng);
  if (!first || !(first->pdf_solid_angle > 0.0f)) return radiance;
  const Color beta = first->f_cos / first->pdf_solid_angle * rays;
  EyeWalk walk(scene_, scene_.spawn_ray(from, first->wi), rays_, from);
  EyeMedia media(scene_, media_, stack_towards(from, place, first->wi), rng.next(), rays_, place.media.bounces());
  media.count(scene_.depends_on_ray_kind() ? EyeMedia::Scattered::ByRayKind : EyeMedia::Scattered::None);
  count_bounce(*first, from, walk.point);
  radiance += follow_without_photons(walk, media, vertex_of({}, from, rough, *first), beta, rays, rng, beyond);
  beyond_.note_found(beyond, rays_ - before, share);
  return radiance + beyond;
}

Color PhotonGatherer::follow_without_photons(EyeWalk& walk, EyeMedia& media, DirectVertex origin, Color beta,
                                             float rays, Pcg32& rng, Color& beyond) {
  const BounceLimits& limits = scene_.settings().bounces;
  Color radiance(0.0f);
  ShadingPoint& point = walk.point;
  const SurfaceShading& shading = walk.shading;
  const WalkHitWeight weight_of_hit{scene_, direct_, media, walk, origin};
  bool finds_all = false, past_ray_kinds = false;
  const auto add_met = [&](const LightMet& met) {
    radiance += beta * met.radiance * media.to_lamp(walk, met) * weight_of_hit(met.light, met.position, met.normal);
  };
  bool at_bounce_limit = past_limits(point, limits);
  while (max_component(beta) > 0.0f) {
    walk.trace();
    if (finds_all || past_ray_kinds) walk.meet_lamps(add_met);
    if (media.active()) {
      EyeMedia::Light light;
      const int depth = point.ray_depth;
      const EyeMedia::Step step = media.pass(walk, {sampler_, 0, !at_bounce_limit}, beta, light);
      radiance += light.sum();
      if (step == EyeMedia::Step::End) break;
      at_bounce_limit = at_bounce_limit || past_limits(point, limits) || media.at_limit();
      past_ray_kinds = past_ray_kinds && point.ray_depth == depth;
      if (step == EyeMedia::Step::Traced) continue;
    }
    if ((finds_all || past_ray_kinds) && !walk.found()) walk.meet_distant(add_met);
    if (!walk.found()) break;
    walk.arrive();
    walk.shade();
    if (!is_black(shading.emission) && (finds_all || past_ray_kinds || scene_.light_of(walk.hit) < 0))
      radiance += beta * shading.emission * walk.emission_weight(weight_of_hit);
    if (!finds_all && scene_.is_eye_only(walk.hit)) {
      finds_all = true;
      media.count(EyeMedia::Scattered::All);
    }
    if (at_bounce_limit && is_black(shading.bsdf.transparency())) break;
    if (!at_bounce_limit && shading.bsdf.has_subsurface() && !on_strand_or_point(point) &&
        !walk_below_or_stay(scene_, walk.hit.instance, {rng.next_float(), rng.next()}, point, walk.shading, beta,
                            rays_))
      break;
    if (!at_bounce_limit && finds_all) {
      radiance += beta * sampled_light<SampledPart::All>(point, shading.bsdf, {media, walk.hit}, rng);
    } else if (!at_bounce_limit) {
      beyond += beta * light_beyond(point, shading.bsdf, {media, walk.hit}, rng);
    }
    const auto sample = sampled(shading.bsdf, point.wo, rng);
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) break;
    beta *= sample->f_cos / sample->pdf_solid_angle;
    if (sample->flags & kTransparent) {
      media.leave(walk, walk.ray.direction);
      past_ray_kinds |= scene_.depends_on_ray_kind(walk.hit);
      origin.past_ray_kinds = past_ray_kinds;
      if (!walk.pass_through()) break;
      continue;
    }
    if (at_bounce_limit) break;
    origin = vertex_of({}, point, shading.bsdf, *sample);
    past_ray_kinds = false;
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
