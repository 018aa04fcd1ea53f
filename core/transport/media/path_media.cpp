#include "transport/media/path_media.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

float mean(Color c) { return (c.x + c.y + c.z) / 3.0f; }

/// Probability to get as far without a collision, and density of a collision there given that.
MediaStretch stretch_of(Color rate, float distance) {
  MediaStretch stretch;
  if (is_black(rate)) return stretch;
  const Color reaching = transmittance_of(rate, distance);
  stretch.pass = mean(reaching);
  stretch.rate = stretch.pass > 0.0f ? mean(rate * reaching) / stretch.pass : mean(rate);
  return stretch;
}

}  // namespace

MediaStack PathMedia::around(Vec3 position, float time) const {
  return media_.around(position, time, counters_.local());
}

MediaStack PathMedia::beyond(const Scene& scene, const ShadingPoint& point, const MediaStack& front,
                             Vec3 direction) const {
  MediaStack stack = front;
  if (!(glm::dot(direction, point.ng) < 0.0f) || !point.instance) return stack;
  Hit hit;
  hit.instance = uint32_t(point.instance - scene.instances().data());
  hit.primitive = point.primitive;
  cross(hit, !point.backfacing, stack);
  return stack;
}

void PathMedia::cross(const Hit& hit, bool inwards, MediaStack& stack) const {
  media_.cross(hit, inwards, stack, counters_.local());
}

void PathMedia::leave_all(MediaStack& stack) const { media_.leave_all(stack, counters_.local()); }

bool PathMedia::sample(const MediaRay& along, Sampler& sampler, MediaStretch& stretch, float& t,
                       MediumPoint& at) const {
  stretch = {};
  if (along.stack.empty()) return false;
  const Color rate = media_.collision_rate(along, counters_.local());
  const float length = along.t_end - along.ray.t_min;
  float distance = kInfinity;
  if (!is_black(rate)) {
    const Vec2 u = sampler.get_2d();
    const float r = rate[std::min(int(u.y * 3.0f), 2)];
    if (r > 0.0f) distance = -std::log(1.0f - u.x) / r;
  }
  const bool collides = distance < length;
  MediaRay travelled = along;
  if (collides) travelled.t_end = along.ray.t_min + distance;
  stretch = stretch_of(rate, collides ? distance : length);
  Pcg32 rng = media_.varies(along.stack) ? media_numbers(sampler) : Pcg32(0, 0);
  stretch.transmittance = media_.transmittance(travelled, rng, counters_.local());
  if (!collides) return false;
  t = travelled.t_end;
  at = this->at(along, t);
  return true;
}

MediaStretch PathMedia::pass(const MediaRay& along, Pcg32& rng) const {
  if (along.stack.empty()) return {};
  MediaStretch stretch = stretch_of(media_.collision_rate(along, counters_.local()), along.t_end - along.ray.t_min);
  stretch.transmittance = media_.transmittance(along, rng, counters_.local());
  return stretch;
}

MediumPoint PathMedia::at(const MediaRay& along, float t) const { return media_.at(along, t, counters_.local()); }

Color PathMedia::emitted(const MediaRay& along, Pcg32& rng) const {
  MediaEvent event;
  if (along.stack.empty() || !media_.emits(along.stack)) return event.emitted;
  Color beta(1.0f);
  if (media_.is_uniform(along, event.at, counters_.local()))
    media_.scatter_uniform(along, false, Vec2(0.0f), beta, event);
  else
    media_.scatter_varying(along, false, rng, beta, event, counters_.local());
  return event.emitted;
}

Color PathMedia::transmittance_to_light(const Ray& ray, const MediaStack& stack, const ShadingPoint& path,
                                        Pcg32& rng) const {
  return media_.transmittance_to_light(ray, stack, path, rng, counters_.local());
}

MediaCounters PathMedia::counters() const {
  MediaCounters all;
  counters_.combine_each([&](const MediaCounters& c) { all.add(c); });
  return all;
}

}  // namespace ajar
