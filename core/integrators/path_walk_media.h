// The part of path_walk.h that passes media.
//
// A ray of the camera is split where a medium may scatter: it passes with the transmittance, and a walk of its own follows
// what is scattered, as at delta lobes (transport/paths/specular_branches.h). The light of the surfaces and the world
// behind a medium is then not left to the chance that nothing scatters the ray, which is most of the noise of a bright
// sky behind thin fog. Both are weighted along the same collisions, so that in white light their sum has no noise.
#pragma once

namespace ajar {

/// Adds what media emit and scatter along a segment of the ray, and attenuates the throughput. Returns Traced if the
/// path was scattered.
template <class DirectLight, class Guide, class Medium, class Parts>
auto PathWalk<DirectLight, Guide, Medium, Parts>::pass_media() -> Step {
  const Ray& ray = walk_.ray;
  ShadingPoint& point = walk_.point;
  if (!walk_.found()) medium_.media.leave_all(medium_.stack, medium_.counters);
  if (medium_.stack.empty()) return Step::GoOn;
  const Color before = beta_;
  MediaEvent event;
  const MediumPoint& at = event.at;
  const uint32_t here = D::kScatter + D::kStretch * uint32_t(medium_.stretch++);
  const MediaRay along{medium_.stack, ray, walk_.found() ? walk_.hit.t : kInfinity, point, point.ray_kind};
  const bool uniform = medium_.media.is_uniform(along, event.at, medium_.counters), may_scatter = !at_bounce_limit_;
  const bool is_first = point.ray_depth == 0, splits = is_first && may_scatter && !start_.caught;
  Color direct(0.0f), passing(0.0f);
  MediumLight sampled;
  const MediumLightContext<Medium> context{scene_, medium_, ray, point, sampler_, here + 2, start_.counters.rays};
  if (uniform && may_scatter && at.scatters() && lights_.can_choose())
    direct = estimate_direct_along(context, along.t_end, at, beta_, sampled);
  sampler_.set_dimension(here);
  bool scattered;
  if (splits) {
    passing = uniform ? medium_.media.split_uniform(along, sampler_.get_2d(), beta_, event)
                      : medium_.media.split_varying(along, medium_.rng, beta_, event, medium_.counters);
    const Color scattering = beta_;
    scattered = is_kept(beta_);
    if (!is_kept(passing)) passing = Color(0.0f);
    record_split(ray.direction, before, scattering, passing, medium_.rng.next_float(), aux_);
  } else {
    scattered = uniform
                    ? medium_.media.scatter_uniform(along, may_scatter, sampler_.get_2d(), beta_, event)
                    : medium_.media.scatter_varying(along, may_scatter, medium_.rng, beta_, event, medium_.counters);
  }
  const PhaseFunction phase(at);
  const Vec3 place = ray.origin + event.t * ray.direction;
  if (scattered && !uniform && lights_.can_choose())
    direct = beta_ * estimate_direct_at(context, phase, place, sampled);
  note_nothing();
  if (!is_black(event.emitted)) add(event.emitted, point.ray_depth);
  if constexpr (kParts)
    if (is_first) first_.part = PathPasses::Part::VolumeDirect;
  if (!is_black(direct)) note_light(sampled.light);
  if (!is_black(direct)) add(direct, point.ray_depth + 1);
  if (scattered) medium_.chosen_for = sampled.chosen_for;
  if (splits) {
    if (scattered) follow_scattered(at, phase, place);
    beta_ = passing;
    scattered = false;
  } else {
    record_medium(ray.direction, before, beta_, scattered, aux_);
  }
  if constexpr (kParts)
    if (is_first && !scattered) first_.part = PathPasses::Part::None;
  if (is_first) alpha_ += luminance(scattered ? before : before - beta_);
  if (!(largest(beta_) > 0.0f)) return Step::End;
  if constexpr (kGuided) guided_.unguided_beta *= largest(beta_) / largest(before);
  if (!scattered) return Step::GoOn;
  if constexpr (kGuided) guided_.note_arrival(place);
  return scatter_in_medium(at, phase, place) ? Step::Traced : Step::End;
}

/// Russian roulette for one of the two walks after a split.
template <class DirectLight, class Guide, class Medium, class Parts>
bool PathWalk<DirectLight, Guide, Medium, Parts>::is_kept(Color& throughput) {
  constexpr float kCertain = 0.1f;
  const float survival = largest(throughput) / kCertain;
  if (survival >= 1.0f) return true;
  if (!(medium_.rng.next_float() < survival)) return false;
  throughput /= survival;
  return true;
}

/// Follows what is scattered after a split. The light that it finds is added to this path.
template <class DirectLight, class Guide, class Medium, class Parts>
void PathWalk<DirectLight, Guide, Medium, Parts>::follow_scattered(const MediumPoint& at, const PhaseFunction& phase,
                                                                   Vec3 place) {
  PathWalk other(*this);
  other.aux_ = nullptr;
  if constexpr (kGuided) other.guided_.note_arrival(place);
  bool goes_on = other.scatter_in_medium(at, phase, place);
  while (goes_on) goes_on = other.step();
  if constexpr (kGuided) other.guided_.end(guide_, other.radiance_);
  radiance_ = other.radiance_;
  medium_.rng = other.medium_.rng;
}

/// Continues the path by the phase function.
template <class DirectLight, class Guide, class Medium, class Parts>
bool PathWalk<DirectLight, Guide, Medium, Parts>::scatter_in_medium(const MediumPoint& at, const PhaseFunction& phase,
                                                                    Vec3 place) {
  ShadingPoint& point = walk_.point;
  const uint32_t base = D::kCamera + D::kVertex * uint32_t(vertex_++);
  sampler_.set_dimension(base + D::kLobe);
  const auto [u_lobe, u] = draw_direction(at.lobe_count > 1);
  PhaseSample sample;
  if constexpr (kGuided) {
    sampler_.set_dimension(base + D::kGuide);
    sample = sample_phase_guided(phase, walk_.ray.direction, guide_.tree, place, 1.0f - guided_.plain,
                                 {sampler_.get_1d(), u_lobe, u});
    guided_.note_scattering(guide_, place, sample, radiance_, luminance(beta_));
  } else {
    sample = sample_phase(phase, walk_.ray.direction, u_lobe, u);
  }
  if (!(sample.pdf_phase > 0.0f)) return false;
  beta_ *= sample.value / sample.pdf;
  note_rough(true);
  ++point.ray_depth;
  at_bounce_limit_ = point.ray_depth > settings_.bounces.total || ++medium_.depth > settings_.bounces.volume;
  point.ray_kind = kRayVolumeScatter;
  roulette_is_due_ = false;
  if (point.ray_depth > kSafeBounces && !survives_roulette(base)) return false;
  previous_ = DirectVertex();
  previous_.bsdf_pdf = sample.pdf_phase;
  unguided_pdf_ = true;
  previous_.position = place;
  previous_.receiver_set = medium_.media.receiver_set(medium_.stack);
  medium_.chose = true;
  Ray next;
  next.origin = place;
  next.direction = sample.wi;
  next.time = walk_.ray.time;
  walk_.ray = next;
  return true;
}

/// Continues straight through a surface that only encloses a volume.
template <class DirectLight, class Guide, class Medium, class Parts>
bool PathWalk<DirectLight, Guide, Medium, Parts>::cross_boundary() {
  if (++medium_.bounds > kMaxVolumeBounds) return false;
  medium_.media.cross(walk_.hit, !walk_.point.backfacing, medium_.stack, medium_.counters);
  walk_.pass_uncounted();
  return true;
}

}  // namespace ajar
