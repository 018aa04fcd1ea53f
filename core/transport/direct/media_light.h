// Direct light in scenes with media: at points that scatter, and at surfaces that are seen through media.
//
// One sample of one light, weighted by the power heuristic against the phase function (or the BSDF) and multiplied by
// the transmittance [Veach 1997, section 9.2; Fong et al. 2017]. For a part of a ray where no medium varies, direct
// light is estimated whether or not the path scatters there. The light is chosen for the whole part. The estimate
// samples its own distance, by transmittance or by the angle at the light, so that lamps near the ray do not cause
// noise [Kulla and Fajardo 2012, "Importance Sampling Techniques for Path Tracing in Participating Media"]. Otherwise
// it is estimated at the point where the path scatters. `State` is the state of a path: media, counters, random
// numbers, stack.
#pragma once

#include "lights/sources/lamp.h"
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
  Sampler& sampler;
  uint32_t first;  ///< dimension of the sampler
  uint64_t& rays;
  SampledPart part = SampledPart::All;  ///< or ByRayKind
};
/// Number of dimensions, starting at `first`, that are kept for each estimate.
constexpr uint32_t kMediumLightDimensions = 6;

/// The light that an estimate has chosen, and the part of the ray for which it was chosen.
struct MediumLight {
  LightStretch chosen_for;
  uint32_t light = 0;
};

/// Chooses a light, of those that light the volume. False if there is none, or if the path does not count its light.
template <class State>
bool choose_light(const MediumLightContext<State>& c, const LightStretch& stretch, float u, MediumLight& sampled,
                  LightSet::Choice& choice, LightFlags& light) {
  const LightSet& lights = c.scene.lights();
  const uint32_t set = lights.any_linked() ? c.state.media.receiver_set(c.state.stack) : kEveryLight;
  choice = lights.choose(stretch, u, set);
  sampled = {stretch, choice.light};
  if (!(choice.pmf > 0.0f)) return false;
  light = lights.flags(choice.light);
  return (light.visibility & kVisibleVolumeScatter) && c.path.ray_depth <= light.max_bounces;
}

/// The light that reaches `place` from the chosen light and is scattered there.
template <class State>
Color light_scattered(const MediumLightContext<State>& c, const PhaseFunction& phase, const LightSet::Choice& choice,
                      LightFlags light, Vec3 place, Vec2 u) {
  const auto sample = c.scene.lights().sample_li(choice.light, place, u, c.ray.time);
  const bool by_kind = c.part == SampledPart::ByRayKind;
  if (!sample || is_black(sample->radiance) || (by_kind && !light.cast_shadow)) return Color(0.0f);
  const float cosine = glm::dot(c.ray.direction, sample->wi);
  Color contribution = phase.evaluate(cosine) * sample->radiance / (choice.pmf * sample->pdf_solid_angle);
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
    contribution *= power_heuristic(choice.pmf * sample->pdf_solid_angle, phase.pdf_solid_angle(cosine));
  return contribution;
}

/// The data of a vertex in a medium that weigh the hit of its phase function's sample.
struct MediumVertex {
  Vec3 position;
  LightStretch chosen_for;  ///< lights were chosen for it
  float phase_pdf;          ///< of the direction travelled
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
  return power_heuristic(v.phase_pdf, lights.choice_pmf(v.chosen_for, light, v.receiver_set) *
                                          lights.pdf_li(light, v.position, wi, distance, normal, v.time));
}

/// Direct light at a point where the path scatters.
template <class State>
Color estimate_direct_at(const MediumLightContext<State>& c, const PhaseFunction& phase, Vec3 place,
                         MediumLight& sampled) {
  c.sampler.set_dimension(c.first);
  const Vec3 u = c.sampler.get_3d();
  LightSet::Choice choice;
  LightFlags light;
  if (!choose_light(c, LightStretch::at(place), u.z, sampled, choice, light)) return Color(0.0f);
  return light_scattered(c, phase, choice, light, place, Vec2(u));
}

/// Distances at which a uniform medium scatters: a mixture of those of the channels, by their scattered light.
class UniformDistances {
 public:
  /// `beta`: throughput at the begin of the stretch.
  UniformDistances(const MediumPoint& medium, Color beta, float begin, float end) : extinction_(medium.extinction) {
    limit_to(begin, end);
    for (int k = 0; k < 3; ++k) {
      probability_[k] = lost_[k] > 0.0f ? std::abs(beta[k]) * medium.scattering[k] : 0.0f;
      if (probability_[k] > probability_[likeliest_]) likeliest_ = k;
    }
    const float sum = probability_.x + probability_.y + probability_.z;
    if (sum > 0.0f) probability_ /= sum;
  }
  bool scatters() const { return probability_[likeliest_] > 0.0f; }
  /// The same medium on another stretch, which is not empty.
  void limit_to(float begin, float end) {
    begin_ = begin;
    length_ = end - begin;
    for (int k = 0; k < 3; ++k)
      if (extinction_[k] > 0.0f) lost_[k] = -std::expm1(-extinction_[k] * length_);
  }
  float begin() const { return begin_; }
  float end() const { return begin_ + length_; }
  /// Where most of the scattering is: within a mean free path.
  float reach() const { return std::min(length_, 1.0f / extinction_[likeliest_]); }
  float sample(float u) const {
    int channel = 0;
    while (channel < 2 && u >= probability_[channel]) u -= probability_[channel++];
    if (!(probability_[channel] > 0.0f)) channel = likeliest_;  // rounding
    u = std::min(u / probability_[channel], kOneMinusEpsilon);
    return begin_ + std::min(-std::log(1.0f - u * lost_[channel]) / extinction_[channel], length_);
  }
  float pdf(float distance) const {
    const Color reaching = transmittance_of(extinction_, distance - begin_);
    float pdf = 0.0f;
    for (int k = 0; k < 3; ++k)
      pdf += probability_[k] > 0.0f ? probability_[k] * extinction_[k] * reaching[k] / lost_[k] : 0.0f;
    return pdf;
  }

 private:
  Color extinction_, lost_{0.0f}, probability_{0.0f};
  float begin_ = 0.0f, length_ = 0.0f;
  int likeliest_ = 0;
};

/// Where on a ray a chosen light is sampled: within the cone of a spot or area lamp, a mixture of distances at which the
/// medium scatters, and of the angle at the light.
class LightDistances {
 public:
  LightDistances(const LightSet& lights, const LightSet::Choice& choice, LightType type, const Ray& ray, Vec2 u,
                 const UniformDistances& distances)
      : distances_(distances), begin_(distances.begin()), end_(distances.end()) {
    if (is_distant(type)) return;
    // Distances towards a point on the light: one that the nearest lit point of the ray sees, or its position.
    const Light light = lights.light(choice.light);
    if (has_cone(type)) {
      clip_to_cone(light, ray, begin_, end_);
      if (!is_lit()) return;
      distances_.limit_to(begin_, end_);
    }
    const auto nearest_to = [&](Vec3 p) { return glm::dot(p - ray.origin, ray.direction); };
    const Vec3 seen_from = ray.origin + glm::clamp(nearest_to(light.position), begin_, end_) * ray.direction;
    const auto towards = lights.sample_li(choice.light, seen_from, u, ray.time);
    const Vec3 on_light = towards ? seen_from + towards->distance * towards->wi : light.position;
    nearest_ = nearest_to(on_light);
    // A light with extent does not get brighter where the ray comes nearer to one of its points than that.
    const float extent2 = is_sphere(type) ? sqr(light.radius) : 0.25f * light.area;
    apart_ = std::sqrt(length_squared(on_light - ray.origin - nearest_ * ray.direction) + extent2);
    first_angle_ = std::atan2(begin_ - nearest_, apart_);
    angles_ = std::atan2(end_ - nearest_, apart_) - first_angle_;
    if (apart_ > 0.0f && angles_ > 0.0f) share_ = 0.5f;
  }
  /// Whether light of the lamp can be anywhere on the ray.
  bool is_lit() const { return begin_ < end_; }
  float sample(float u) const {
    if (u < share_)
      return std::clamp(nearest_ + apart_ * std::tan(first_angle_ + angles_ * (u / share_)), distances_.begin(),
                        distances_.end());
    return distances_.sample(std::min((u - share_) / (1.0f - share_), kOneMinusEpsilon));
  }
  float pdf(float t) const {
    float pdf = (1.0f - share_) * distances_.pdf(t);
    if (share_ > 0.0f && t >= begin_ && t <= end_)
      pdf += share_ * apart_ / (angles_ * (apart_ * apart_ + sqr(t - nearest_)));
    return pdf;
  }

 private:
  UniformDistances distances_;
  float begin_, end_;  // where light of the lamp can be
  float share_ = 0.0f, nearest_ = 0.0f, apart_ = 0.0f, first_angle_ = 0.0f, angles_ = 0.0f;
};

/// Direct light along a part of a ray in one medium. `beta` is the throughput at its start. The path's own scattering is
/// weighted against this estimate for the same stretch.
template <class State>
Color estimate_direct_along(const MediumLightContext<State>& c, float t_end, const MediumPoint& medium, Color beta,
                            MediumLight& sampled) {
  const Ray& ray = c.ray;
  const UniformDistances distances(medium, beta, ray.t_min, t_end);
  if (!distances.scatters()) return Color(0.0f);
  c.sampler.set_dimension(c.first);
  const Vec3 u = c.sampler.get_3d();
  LightSet::Choice choice;
  LightFlags light;
  const LightStretch stretch{ray.origin, ray.direction, distances.begin(), distances.end(), distances.reach()};
  if (!choose_light(c, stretch, u.z, sampled, choice, light)) return Color(0.0f);
  const LightDistances towards(c.scene.lights(), choice, light.type, ray, Vec2(u), distances);
  if (!towards.is_lit()) return Color(0.0f);
  const float t = towards.sample(c.sampler.get_1d());
  if (!(t < kInfinity)) return Color(0.0f);
  const Color reaching = transmittance_of(medium.extinction, t - ray.t_min);
  const Color weight = beta * medium.scattering * reaching / towards.pdf(t);
  if (!(max_component(glm::abs(weight)) > 0.0f) || !is_finite(weight)) return Color(0.0f);
  const Vec3 place = ray.origin + t * ray.direction;
  return weight * light_scattered(c, PhaseFunction(medium), choice, light, place, Vec2(u));
}

}  // namespace ajar
