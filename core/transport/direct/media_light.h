// Direct light in scenes with media: at points that scatter, and at surfaces that are seen through media.
//
// One sample of one light, weighted by the power heuristic against the phase function (or the BSDF) and multiplied by
// the transmittance [Veach 1997, section 9.2; Fong et al. 2017]. For a part of a ray where no medium varies, direct
// light is estimated whether or not the path scatters there. The estimate samples its own distance, by transmittance or
// by the angle at the light, so that lamps near the ray do not cause noise [Kulla and Fajardo 2012, "Importance
// Sampling Techniques for Path Tracing in Participating Media"]. Otherwise it is estimated at the point where the path
// scatters. `State` is the state of a path: media, counters, random numbers, stack.
#pragma once

#include "lights/lamp.h"
#include "transport/direct/direct_light.h"
#include "transport/media/media.h"
#include "transport/media/phase_function.h"

namespace ajar {

/// For surfaces. The light can come from the other side, through the volume that the surface encloses.
template <class State>
struct MediaDirectContext : DirectLightContext {
  State& state;
  const Hit& hit;

  MediaDirectContext(const DirectLightContext& context, State& s, const Hit& h)
      : DirectLightContext(context), state(s), hit(h) {}

  Color transmittance(const Ray& ray, bool* by_ray_kind = nullptr) const {
    MediaStack stack = state.stack;
    if (glm::dot(ray.direction, point.ng) < 0.0f) state.media.cross(hit, !point.backfacing, stack, state.counters);
    return state.media.transmittance_to_light(ray, stack, point, state.rng, state.counters, by_ray_kind);
  }
  Color beyond(const LightPlace& light, Color f_cos, bool shadows, uint64_t& rays) const {
    Ray ray;
    if (!beyond_terminator(scene, point, bsdf, light, shadows, f_cos, ray)) return Color(0.0f);
    if (!(ray.t_max > 0.0f)) return f_cos;
    ++rays;
    return f_cos * transmittance(ray);
  }
};

/// The input of the estimates of direct light in a medium.
template <class State>
struct MediumLightContext {
  const Scene& scene;
  State& state;
  const Ray& ray;            ///< along which the path travels
  const ShadingPoint& path;  ///< depths of the path
  const PhaseFunction& phase;
  Sampler& sampler;
  uint32_t first;  ///< dimension of the sampler
  uint64_t& rays;
  SampledPart part = SampledPart::All;  ///< or ByRayKind
};
/// Number of dimensions, starting at `first`, of each estimate.
constexpr uint32_t kMediumLightDimensions = 6;

/// The light that an estimate has chosen, and the place for which it was chosen.
struct MediumLight {
  Vec3 chosen_from{0.0f};
  uint32_t light = 0;
};

/// Chooses a light for `place`, of those that light the volume.
template <class State>
LightSet::Choice choose_light(const MediumLightContext<State>& c, Vec3 place) {
  const LightSet& lights = c.scene.lights();
  const uint32_t set = lights.any_linked() ? c.state.media.receiver_set(c.state.stack) : kEveryLight;
  return lights.choose(place, Vec3(0.0f), c.sampler.get_1d(), set);
}

/// The light that reaches `place` from the chosen light and is scattered there.
template <class State>
Color light_scattered(const MediumLightContext<State>& c, const LightSet::Choice& choice, LightFlags light, Vec3 place,
                      Vec2 u) {
  const auto sample = c.scene.lights().sample_li(choice.light, place, u, c.ray.time);
  const bool by_kind = c.part == SampledPart::ByRayKind;
  if (!sample || is_black(sample->radiance) || (by_kind && !light.cast_shadow)) return Color(0.0f);
  const float cosine = glm::dot(c.ray.direction, sample->wi);
  Color contribution = c.phase.evaluate(cosine) * sample->radiance / (choice.pmf * sample->pdf_solid_angle);
  if (light.cast_shadow) {
    ++c.rays;
    Ray shadow;
    shadow.origin = place;
    shadow.direction = sample->wi;
    shadow.time = c.ray.time;
    bool by_ray_kind = false;
    contribution *= c.state.media.transmittance_to_light(end_before(shadow, *sample), c.state.stack, c.path,
                                                         c.state.rng, c.state.counters,
                                                         by_kind ? &by_ray_kind : nullptr);
    if (by_kind && !by_ray_kind) return Color(0.0f);
  }
  if (!sample->delta && light.mis && !light.partial())
    contribution *= power_heuristic(choice.pmf * sample->pdf_solid_angle, c.phase.pdf_solid_angle(cosine));
  return contribution;
}

/// The data of a vertex in a medium that weigh the hit of its phase function's sample.
struct MediumVertex {
  Vec3 position;
  Vec3 chosen_from;  ///< lights were chosen for there
  float phase_pdf;   ///< of the direction travelled
  uint32_t receiver_set;
  float time;  ///< of the path
};

/// The weight of light that the sample of the phase function at `v` has found.
inline float weight_of_hit_in_medium(const Scene& scene, const MediumVertex& v, uint32_t light, Vec3 wi, Vec3 position,
                                     Vec3 normal) {
  const LightSet& lights = scene.lights();
  if (lights.any_partial() && lights.flags(light).partial()) return 0.0f;
  if (lights.any_linked() && !lights.flags(light).lights(v.receiver_set)) return 0.0f;
  const float distance = is_finite(position) ? glm::length(position - v.position) : kInfinity;
  return power_heuristic(v.phase_pdf, lights.choice_pmf(v.chosen_from, Vec3(0.0f), light, v.receiver_set) *
                                          lights.pdf_li(light, v.position, wi, distance, normal, v.time));
}

/// Direct light at a point where the path scatters.
template <class State>
Color estimate_direct_at(const MediumLightContext<State>& c, Vec3 place, MediumLight& sampled) {
  c.sampler.set_dimension(c.first);
  const Vec2 u = c.sampler.get_2d();
  const LightSet::Choice choice = choose_light(c, place);
  sampled = {place, choice.light};
  if (!(choice.pmf > 0.0f)) return Color(0.0f);
  const LightFlags light = c.scene.lights().flags(choice.light);
  if (!(light.visibility & kVisibleVolumeScatter) || c.path.ray_depth > light.max_bounces) return Color(0.0f);
  return light_scattered(c, choice, light, place, u);
}

/// Direct light along a part of a ray in one medium. `beta` is the throughput at its start. The light is chosen for a
/// point that is sampled by transmittance. The distance is sampled by a mixture of transmittance and, within the cone of
/// a spot or area lamp, the angle at the light. The path's own scattering is weighted against this estimate for the same point.
template <class State>
Color estimate_direct_along(const MediumLightContext<State>& c, float t_end, const MediumPoint& medium, Color beta,
                            MediumLight& sampled) {
  const Ray& ray = c.ray;
  const float length = t_end - ray.t_min;
  Color lost(0.0f), probability(0.0f);
  int likeliest = 0;
  for (int k = 0; k < 3; ++k) {
    if (medium.extinction[k] > 0.0f) lost[k] = -std::expm1(-medium.extinction[k] * length);
    probability[k] = lost[k] > 0.0f ? std::abs(beta[k]) * medium.scattering[k] : 0.0f;
    if (probability[k] > probability[likeliest]) likeliest = k;
  }
  const float sum = probability.x + probability.y + probability.z;
  if (!(sum > 0.0f)) return Color(0.0f);
  probability /= sum;
  const auto distance_of = [&](float u) {
    int channel = 0;
    while (channel < 2 && u >= probability[channel]) u -= probability[channel++];
    if (!(probability[channel] > 0.0f)) channel = likeliest;  // rounding
    u = std::min(u / probability[channel], kOneMinusEpsilon);
    return std::min(-std::log(1.0f - u * lost[channel]) / medium.extinction[channel], length);
  };
  c.sampler.set_dimension(c.first);
  const Vec2 u = c.sampler.get_2d();
  const Vec3 chosen_from = ray.origin + (ray.t_min + distance_of(c.sampler.get_1d())) * ray.direction;
  const LightSet::Choice choice = choose_light(c, chosen_from);
  sampled = {chosen_from, choice.light};
  if (!(choice.pmf > 0.0f)) return Color(0.0f);
  const LightFlags light = c.scene.lights().flags(choice.light);
  if (!(light.visibility & kVisibleVolumeScatter) || c.path.ray_depth > light.max_bounces) return Color(0.0f);

  // Distances towards a point on the light.
  const auto towards = c.scene.lights().sample_li(choice.light, chosen_from, u, ray.time);
  float share = 0.0f, nearest = 0.0f, apart = 0.0f, angle_begin = 0.0f, angles = 0.0f;
  float lit_begin = ray.t_min, lit_end = t_end;
  if (towards && towards->distance < kInfinity) {
    const Vec3 to_light = chosen_from + towards->distance * towards->wi - ray.origin;
    if (has_cone(light.type)) clip_to_cone(c.scene.lights().light(choice.light), ray, lit_begin, lit_end);
    nearest = glm::dot(to_light, ray.direction);
    apart = glm::length(to_light - nearest * ray.direction);
    angle_begin = std::atan2(lit_begin - nearest, apart);
    angles = std::atan2(lit_end - nearest, apart) - angle_begin;
    if (apart > 0.0f && angles > 0.0f) share = 0.5f;
  }
  float u_distance = c.sampler.get_1d(), distance;
  if (u_distance < share)
    distance = std::clamp(nearest + apart * std::tan(angle_begin + angles * (u_distance / share)) - ray.t_min, 0.0f,
                          length);
  else
    distance = distance_of(std::min((u_distance - share) / (1.0f - share), kOneMinusEpsilon));
  if (!(distance < kInfinity)) return Color(0.0f);
  // The density of the mixture: transmittance for each channel, and the angle at the light [Kulla and Fajardo 2012].
  const Color reaching = transmittance_of(medium.extinction, distance);
  float pdf = 0.0f;
  for (int k = 0; k < 3; ++k)
    pdf += probability[k] > 0.0f ? probability[k] * medium.extinction[k] * reaching[k] / lost[k] : 0.0f;
  pdf *= 1.0f - share;
  const float t = ray.t_min + distance;
  if (share > 0.0f && t >= lit_begin && t <= lit_end)
    pdf += share * apart / (angles * (apart * apart + sqr(t - nearest)));
  const Color weight = beta * medium.scattering * reaching / pdf;
  if (!(max_component(glm::abs(weight)) > 0.0f) || !is_finite(weight)) return Color(0.0f);
  const Vec3 place = ray.origin + t * ray.direction;
  return weight * light_scattered(c, choice, light, place, u);
}

}  // namespace ajar
