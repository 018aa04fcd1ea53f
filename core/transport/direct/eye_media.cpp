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

EyeMedia::Step EyeMedia::meet(EyeWalk& walk, const Along& how, Color& beta, Light& light, float* alpha) {
  if (!state_) return Step::Surface;
  State& s = *state_;
  const Ray& ray = walk.ray;
  ShadingPoint& point = walk.point;
  if (!walk.found()) s.media.leave_all(s.stack, s.counters);
  if (!s.stack.empty()) {
    const Color before = beta;
    const MediaRay along{s.stack, ray, walk.found() ? walk.hit.t : kInfinity, point, point.ray_kind};
    MediaEvent& event = s.event = {};
    const bool may_scatter = how.may_scatter && !at_limit(), uniform = s.media.is_uniform(along, event.at, s.counters),
               lit = scattered_ != Scattered::None && scene_.lights().can_choose(), thorough = how.thorough && uniform;
    MediumLight sampled;
    const SampledPart part = scattered_ == Scattered::ByRayKind ? SampledPart::ByRayKind : SampledPart::All;
    const MediumLightContext<State> context{scene_, s,   ray, point, how.sampler, how.dimension + (thorough ? 2 : 0),
                                            rays_,  part};
    if (thorough && lit && may_scatter && event.at.scatters())
      light.scattered += estimate_direct_along(context, along.t_end, event.at, beta, sampled);
    bool scattered;
    if (uniform) {
      how.sampler.set_dimension(how.dimension);
      const Vec2 u = thorough ? how.sampler.get_2d() : Vec2(s.rng.next_float(), s.rng.next_float());
      scattered = s.media.scatter_uniform(along, may_scatter, u, beta, event);
    } else {
      scattered = s.media.scatter_varying(along, may_scatter, s.rng, beta, event, s.counters);
    }
    light.emitted += event.emitted;
    if (alpha && point.ray_depth == 0) *alpha += luminance(scattered ? before : before - beta);
    if (!(max_component(glm::abs(beta)) > 0.0f)) return Step::End;
    if (scattered) {
      place_ = ray.origin + event.t * ray.direction;
      if (lit && !thorough) light.scattered += beta * estimate_direct_at(context, phase(), place_, sampled);
      chosen_for_ = lit ? sampled.chosen_for : LightStretch::at(place_);
      receiver_set_ = s.media.receiver_set(s.stack);
      return Step::Scattered;
    }
  }
  if (!walk.found()) return Step::Surface;
  const ShaderProgram& program = scene_.material(walk.hit);
  if (!program.only_encloses()) return Step::Surface;
  if (++bounds_ > kMaxVolumeBounds || !walk.arrive()) return Step::End;
  s.media.cross(walk.hit, !point.backfacing, s.stack, s.counters);
  way_ += walk.hit.t;
  walk.pass_uncounted();
  return Step::Traced;
}

bool EyeMedia::scatter(EyeWalk& walk, Color& beta) {
  Pcg32& rng = state_->rng;
  const float u_lobe = rng.next_float(), ux = rng.next_float(), uy = rng.next_float();
  const PhaseSample sample = sample_direction(walk, {guide_ ? rng.next_float() : 0.0f, u_lobe, {ux, uy}});
  if (!(sample.pdf_phase > 0.0f)) return false;
  beta *= sample.value / sample.pdf;
  leave_along(walk, sample);
  if (walk.point.ray_depth > kFreeScattering) {
    const float survival = std::min(1.0f, std::sqrt(max_component(glm::abs(beta))));
    if (!(rng.next_float() < survival)) return false;
    beta /= survival;
  }
  return true;
}

void EyeMedia::leave_along(EyeWalk& walk, const PhaseSample& sample) {
  pdf_ = sample.pdf_phase;
  plain_ *= sample.pdf_phase / sample.pdf;
  way_ += state_->event.t;
  ++walk.point.ray_depth;
  ++depth_;
  walk.point.ray_kind = kRayVolumeScatter;
  chose_ = true;
  Ray next;
  next.origin = place_;
  next.direction = sample.wi;
  next.time = walk.ray.time;
  walk.ray = next;
}

void EyeMedia::leave(const EyeWalk& walk, Vec3 direction) {
  if (state_ && glm::dot(direction, walk.point.ng) < 0.0f)
    state_->media.cross(walk.hit, !walk.point.backfacing, state_->stack, state_->counters);
}

}  // namespace ajar
