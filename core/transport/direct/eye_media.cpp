#include "transport/direct/eye_media.h"

#include <algorithm>

namespace ajar {

namespace {
constexpr int kFreeScattering = 2;  // before roulette
}  // namespace

Color EyeMedia::to_lamp(const EyeWalk& walk, const LightMet& met) {
  if (!state_ || state_->stack.empty() || !is_finite(met.position)) return Color(1.0f);
  const float t = glm::dot(met.position - walk.ray.origin, walk.ray.direction);
  return state_->media.transmittance({state_->stack, walk.ray, t, walk.point, walk.point.ray_kind}, state_->rng,
                                     state_->counters);
}

EyeMedia::Step EyeMedia::pass(EyeWalk& walk, Sampler& sampler, uint32_t dimension, bool may_scatter, Color& beta,
                              Light& light, float* alpha) {
  if (!state_) return Step::Surface;
  State& s = *state_;
  const Ray& ray = walk.ray;
  ShadingPoint& point = walk.point;
  if (!walk.found()) s.media.leave_all(s.stack, s.counters);
  if (!s.stack.empty()) {
    const Color before = beta;
    const MediaRay along{s.stack, ray, walk.found() ? walk.hit.t : kInfinity, point, point.ray_kind};
    MediaEvent event;
    may_scatter &= !at_limit();
    bool scattered;
    if (s.media.is_uniform(along, event.at, s.counters)) {
      const Vec2 u(s.rng.next_float(), s.rng.next_float());
      scattered = s.media.scatter_uniform(along, may_scatter, u, beta, event);
    } else {
      scattered = s.media.scatter_varying(along, may_scatter, s.rng, beta, event, s.counters);
    }
    light.emitted += event.emitted;
    if (alpha && point.ray_depth == 0) *alpha += luminance(scattered ? before : before - beta);
    if (!(max_component(glm::abs(beta)) > 0.0f)) return Step::End;
    if (scattered) {
      const PhaseFunction phase(event.at);
      place_ = ray.origin + event.t * ray.direction;
      MediumLight sampled;
      if (!only_emission_ && scene_.lights().can_choose())
        light.scattered += beta * estimate_direct_at(MediumLightContext<State>{scene_, s, ray, point, phase, sampler,
                                                                               dimension, rays_},
                                                     place_, sampled);
      const float u_lobe = s.rng.next_float();
      const Vec3 wi = phase.sample(ray.direction, u_lobe, Vec2(s.rng.next_float(), s.rng.next_float()));
      const float cosine = glm::dot(ray.direction, wi);
      pdf_ = phase.pdf_solid_angle(cosine);
      beta *= phase.evaluate(cosine) / pdf_;
      ++point.ray_depth;
      ++depth_;
      point.ray_kind = kRayVolumeScatter;
      if (point.ray_depth > kFreeScattering) {
        const float survival = std::min(1.0f, std::sqrt(max_component(glm::abs(beta))));
        if (!(s.rng.next_float() < survival)) return Step::End;
        beta /= survival;
      }
      chose_ = true;
      receiver_set_ = s.media.receiver_set(s.stack);
      Ray next;
      next.origin = place_;
      next.direction = wi;
      next.time = ray.time;
      walk.ray = next;
      return Step::Traced;
    }
  }
  if (!walk.found()) return Step::Surface;
  const ShaderProgram& program = scene_.material(walk.hit);
  if (!program.has_volume() || program.has_surface()) return Step::Surface;
  if (++bounds_ > kMaxVolumeBounds || !walk.arrive()) return Step::End;
  s.media.cross(walk.hit, !point.backfacing, s.stack, s.counters);
  walk.pass_uncounted();
  return Step::Traced;
}

void EyeMedia::leave(const EyeWalk& walk, Vec3 direction) {
  if (state_ && glm::dot(direction, walk.point.ng) < 0.0f)
    state_->media.cross(walk.hit, !walk.point.backfacing, state_->stack, state_->counters);
}

}  // namespace ajar
