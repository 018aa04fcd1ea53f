// Sampling of collisions and transmittance along the stretches of a ray.
#include <algorithm>
#include <cmath>

#include "transport/media/media.h"

namespace ajar {

namespace {

constexpr float kFaint = 0.05f;       ///< weight below which roulette decides, as a fraction of the weight before
constexpr float kMinChannel = 0.25f;  ///< minimum probability of channels that do not scatter

/// Emission along a distance, attenuated by the medium that emits it.
Color emitted_along(const MediumPoint& medium, Color transmittance, float distance) {
  Color result(0.0f);
  for (int c = 0; c < 3; ++c) {
    if (!(medium.emission[c] > 0.0f)) continue;
    const float depth = medium.extinction[c] * distance;
    // The quotient loses its digits if the medium is thin.
    if (depth < 1e-3f)
      result[c] = medium.emission[c] * distance * (1.0f - 0.5f * depth);
    else
      result[c] = medium.emission[c] * (1.0f - transmittance[c]) / medium.extinction[c];
    if (!std::isfinite(result[c])) result[c] = 0.0f;  // an infinite medium that only emits
  }
  return result;
}

/// Russian roulette if the weight is below `faint`.
bool outlives(float faint, Pcg32& rng, Color& weight) {
  const float most = max_component(glm::abs(weight));
  if (most >= faint) return true;
  const float survival = most / faint;
  if (!(rng.next_float() < survival)) {
    weight = Color(0.0f);
    return false;
  }
  weight /= survival;
  return true;
}

/// The probability with which the distance is that of a channel: proportional to its throughput, and larger if it scatters
/// much. Black if nothing scatters.
Color channel_probability(const MediumPoint& at, Color beta) {
  Color probability(0.0f);
  if (!at.scatters()) return probability;
  for (int c = 0; c < 3; ++c) {
    const float albedo = at.extinction[c] > 0.0f ? at.scattering[c] / at.extinction[c] : 0.0f;
    probability[c] = std::abs(beta[c]) * (kMinChannel + (1.0f - kMinChannel) * albedo);
  }
  const float sum = probability.x + probability.y + probability.z;
  return sum > 0.0f ? probability / sum : probability;
}
int channel_of(Color probability, float u) { return u < probability.x ? 0 : u < probability.x + probability.y ? 1 : 2; }

}  // namespace

ShadingPoint inside_of(const MediaRay& along) {
  ShadingPoint inside = along.path;
  inside.primitive = kInsideVolume;
  inside.barycentric = Vec2(0.0f);
  inside.wo = inside.ng = inside.ns = -along.ray.direction;
  inside.backfacing = false;
  inside.dpdu = inside.dpdv = Vec3(0.0f);
  inside.ray_length = 0.0f;
  inside.time = along.ray.time;
  inside.ray_kind = along.ray_kind;
  return inside;
}

Color transmittance_of(Color extinction, float distance) {
  Color result;
  for (int c = 0; c < 3; ++c) result[c] = extinction[c] > 0.0f ? std::exp(-extinction[c] * distance) : 1.0f;
  return result;
}

/// Media that vary end at their bounds, in case a ray has missed their surface.
template <bool kEndless>
bool Media::reaches(const Medium& medium, Vec3 position) const {
  for (int axis = 0; axis < 3; ++axis) {
    const float place = medium.grid.place<kEndless>(axis, position[axis]);
    if (!(place >= 0.0f && place < float(medium.grid.cells()[size_t(axis)]))) return false;
  }
  return true;
}

void Media::add(const Medium& medium, ShadingPoint& inside, MediumPoint& point, MediaCounters& counters) const {
  if (medium.instance == kNone) {
    inside.instance = nullptr;
    inside.mesh = nullptr;
    inside.object = nullptr;
  } else {
    const BuiltInstance& instance = scene_.instances()[medium.instance];
    inside.instance = &instance;
    inside.mesh = &scene_.meshes()[instance.mesh];
    inside.object = &scene_.object(instance.object);
  }
  if (!medium.varies && medium.scale == 1.0f) {
    medium.program->add_medium(inside, point);
    return;
  }
  if (medium.grid.is_divided() &&
      !(medium.grid.is_endless() ? reaches<true>(medium, inside.position) : reaches<false>(medium, inside.position)))
    return;
  MediumPoint own;
  if (inside.mesh && inside.mesh->velocity >= 0) [[unlikely]] {
    const Vec3 place = inside.position;
    inside.position = before_flow(*inside.mesh, *inside.instance, place, inside.time);
    medium.program->add_medium(inside, own);
    inside.position = place;
  } else {
    medium.program->add_medium(inside, own);
  }
  const float largest = max_component(own.extinction);
  float scale = medium.scale;
  if (medium.most > 0.0f && largest * scale > medium.most) {
    scale = medium.most / largest;
    ++counters.capped;
  }
  const Color scattering = own.scattering * scale;
  point.extinction += own.extinction * scale - scattering;
  for (int i = 0; i < own.lobe_count; ++i)
    point.add_scattering(own.lobes[size_t(i)].scattering * scale, own.lobes[size_t(i)].shape);
  point.emission += own.emission * medium.scale;
  point.refused += own.refused;
}

void Media::evaluate(const MediaStack& stack, ShadingPoint& inside, MediumPoint& point, MediaCounters& counters) const {
  for (int i = 0; i < stack.size(); ++i) add(media_[stack[i]], inside, point, counters);
  counters.refused += uint64_t(point.refused);
}

const MediaStack& Media::seen_by(const MediaRay& along, MediaStack& scratch) const {
  const uint32_t mask = any_hidden_ ? visibility_mask(along.ray_kind) : 0u;
  if (mask == 0) return along.stack;
  scratch = along.stack;
  for (int i = 0; i < along.stack.size(); ++i)
    if (!(media_[along.stack[i]].visibility & mask)) scratch.leave(along.stack[i]);
  return scratch;
}

template <bool kEndless>
float Media::majorant(const Medium& medium, Vec3 position, Vec3 direction, float& reach) const {
  std::array<int, 3> cell;
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis) {
    const int count = medium.grid.cells()[size_t(axis)];
    const float d = direction[axis], place = medium.grid.place<kEndless>(axis, position[axis]);
    int border;  // the next border of a cell on the ray
    if (!(place >= 0.0f && place < float(count))) {
      inside = false;
      if (place < 0.0f ? !(d > 0.0f) : !(d < 0.0f)) return 0.0f;  // the ray never enters the grid
      border = place < 0.0f ? 0 : count;
    } else {
      cell[size_t(axis)] = std::min(int(place), count - 1);
      border = cell[size_t(axis)] + (d > 0.0f ? 1 : 0);
    }
    if (d == 0.0f) continue;
    const float size = medium.grid.size<kEndless>(axis, std::min(border, count - 1));
    reach = std::min(reach, std::max((medium.grid.border<kEndless>(axis, border) - position[axis]) / d, 1e-3f * size));
  }
  if (!inside) return 0.0f;
  const size_t index = medium.grid.index(cell);
  if (medium.fine.divides(index)) return fine_majorant(medium, cell, position, direction, reach);
  return majorants_[medium.first_majorant + index];
}

/// Calls `collide(medium, majorant, t)` at tentative collisions until it returns false or the ray ends.
template <class Collide>
void Media::track(const MediaRay& along, Pcg32& rng, MediaCounters& counters, Collide&& collide) const {
  ShadingPoint inside = inside_of(along);
  MediaStack scratch;
  const MediaStack& stack = seen_by(along, scratch);
  if (stack.empty()) return;
  float constant = 0.0f;  // majorant of the media that do not vary
  for (int i = 0; i < stack.size(); ++i) {
    const Medium& medium = media_[stack[i]];
    if (medium.varies) continue;
    MediumPoint point;
    inside.position = along.ray.origin;
    add(medium, inside, point, counters);
    constant += max_component(point.extinction);
    if (!is_black(point.emission)) constant += 1.0f;
  }
  // The distance must increase, by at least one representable number, also for small media far away.
  const auto advanced = [](float t, float step) { return t + step > t ? t + step : t * (1.0f + 1e-6f) + 1e-30f; };
  for (float t = along.ray.t_min; t < along.t_end;) {
    const Vec3 position = along.ray.origin + t * along.ray.direction;
    float rate = constant, reach = along.t_end - t;
    for (int i = 0; i < stack.size(); ++i)
      if (const Medium& medium = media_[stack[i]]; medium.varies)
        rate += medium.grid.is_endless() ? majorant<true>(medium, position, along.ray.direction, reach)
                                         : majorant<false>(medium, position, along.ray.direction, reach);
    const float step = -std::log(1.0f - rng.next_float()) / rate;
    if (!(step < reach)) {
      // Continue in the next cell; exponential distances have no memory.
      t = advanced(t, reach);
      continue;
    }
    t = advanced(t, step);
    inside.position = along.ray.origin + t * along.ray.direction;
    MediumPoint point;
    evaluate(stack, inside, point, counters);
    ++counters.lookups;
    if (max_component(point.extinction) > rate * (1.0f + 1e-5f)) ++counters.exceeded;
    if (!collide(point, rate, t)) return;
  }
}

Color Media::collision_rate(const MediaRay& along, MediaCounters& counters) const {
  Color rate(0.0f);
  ShadingPoint inside = inside_of(along);
  inside.position = along.ray.origin;
  MediaStack scratch;
  const MediaStack& stack = seen_by(along, scratch);
  for (int i = 0; i < stack.size(); ++i) {
    const Medium& medium = media_[stack[i]];
    rate += medium.mean_extinction;
    if (medium.varies) continue;
    MediumPoint point;
    add(medium, inside, point, counters);
    if (point.scatters()) rate += point.extinction;
  }
  return rate;
}

MediumPoint Media::at(const MediaRay& along, float t, MediaCounters& counters) const {
  ShadingPoint inside = inside_of(along);
  inside.position = along.ray.origin + t * along.ray.direction;
  MediumPoint point;
  MediaStack scratch;
  evaluate(seen_by(along, scratch), inside, point, counters);
  return point;
}

bool Media::is_uniform(const MediaRay& along, MediumPoint& at, MediaCounters& counters) const {
  MediaStack scratch;
  const MediaStack& stack = seen_by(along, scratch);
  if (varies(stack)) return false;
  ShadingPoint inside = inside_of(along);
  inside.position = along.ray.origin;
  evaluate(stack, inside, at, counters);
  return true;
}

bool Media::scatter_uniform(const MediaRay& along, bool may_scatter, Vec2 u, Color& beta, MediaEvent& event) const {
  const MediumPoint& at = event.at;
  if (at.empty()) return false;
  const float length = along.t_end - along.ray.t_min;
  const Color through = transmittance_of(at.extinction, length);
  if (!is_black(at.emission)) event.emitted += beta * emitted_along(at, through, length);
  const Color probability = may_scatter ? channel_probability(at, beta) : Color(0.0f);
  if (is_black(probability)) {
    beta *= through;
    return false;
  }
  const int channel = channel_of(probability, u.y);
  const float distance = at.extinction[channel] > 0.0f ? -std::log(1.0f - u.x) / at.extinction[channel] : kInfinity;
  if (!(distance < length)) {
    // Transmittance over the probability of no scattering: balance heuristic over the channels [Veach 1997, section
    // 9.2.4].
    beta *= through / glm::dot(probability, through);
    return false;
  }
  const Color reaching = transmittance_of(at.extinction, distance);
  beta *= at.scattering * reaching / glm::dot(probability, at.extinction * reaching);
  event.t = along.ray.t_min + distance;
  return true;
}

Color Media::split_uniform(const MediaRay& along, Vec2 u, Color& beta, MediaEvent& event) const {
  const MediumPoint& at = event.at;
  const float length = along.t_end - along.ray.t_min;
  const Color through = at.empty() ? Color(1.0f) : transmittance_of(at.extinction, length), passing = beta * through;
  if (!is_black(at.emission)) event.emitted += beta * emitted_along(at, through, length);
  const Color probability = channel_probability(at, beta);
  const int channel = channel_of(probability, u.y);
  const float extinction = at.extinction[channel];
  if (is_black(probability) || !(extinction > 0.0f)) {
    beta = Color(0.0f);
    return passing;
  }
  // Distances up to the end only, with the balance heuristic over the channels. expm1 and log1p keep thin media exact.
  const Color ends = -Color(std::expm1(-at.extinction.x * length), std::expm1(-at.extinction.y * length),
                            std::expm1(-at.extinction.z * length));
  const float distance = std::min(-std::log1p(-u.x * ends[channel]) / extinction, length);
  const Color reaching = transmittance_of(at.extinction, distance);
  Color density(0.0f);
  for (int c = 0; c < 3; ++c)
    if (ends[c] > 0.0f) density[c] = at.extinction[c] * reaching[c] / ends[c];
  const float pdf = glm::dot(probability, density);
  beta *= pdf > 0.0f ? at.scattering * reaching / pdf : Color(0.0f);
  event.t = along.ray.t_min + distance;
  return passing;
}

Color Media::split_varying(const MediaRay& along, Pcg32& rng, Color& beta, MediaEvent& event,
                           MediaCounters& counters) const {
  Color passing = beta, chosen(0.0f);
  float sum = 0.0f;
  const float faint = kFaint * max_component(glm::abs(beta));
  track(along, rng, counters, [&](const MediumPoint& point, float rate, float place) {
    // Collision estimator of emission.
    event.emitted += passing * point.emission / rate;
    // Each collision may be the one that scatters, in proportion to its contribution [Chao 1982].
    const Color scatters = passing * point.scattering / rate;
    const float share = std::abs(scatters.x) + std::abs(scatters.y) + std::abs(scatters.z);
    if (share > 0.0f) {
      sum += share;
      if (rng.next_float() * sum < share) {
        chosen = scatters / share;
        event.t = place;
        event.at = point;
      }
    }
    // Ratio tracking [Novák, Selle and Jarosz 2014].
    passing *= (Color(rate) - point.extinction) / rate;
    return outlives(faint, rng, passing);
  });
  beta = sum * chosen;
  return passing;
}

bool Media::scatter_varying(const MediaRay& along, bool may_scatter, Pcg32& rng, Color& beta, MediaEvent& event,
                            MediaCounters& counters) const {
  bool scattered = false;
  const float faint = kFaint * max_component(glm::abs(beta));
  track(along, rng, counters, [&](const MediumPoint& point, float rate, float place) {
    // Collision estimator of emission.
    event.emitted += beta * point.emission / rate;
    const Color null = Color(rate) - point.extinction;
    float scatters = 0.0f, passes = 0.0f;
    for (int c = 0; c < 3; ++c) {
      scatters += may_scatter ? std::abs(beta[c]) * point.scattering[c] : 0.0f;
      passes += std::abs(beta[c] * null[c]);
    }
    if (!(scatters + passes > 0.0f)) {
      beta = Color(0.0f);
      return false;
    }
    // Spectral tracking [Kutz et al. 2017]: the probability of scattering is proportional to the weighted coefficients.
    const float probability = scatters / (scatters + passes);
    if (probability > 0.0f && rng.next_float() < probability) {
      beta *= point.scattering / (rate * probability);
      scattered = true;
      event.t = place;
      event.at = point;
      return false;
    }
    beta *= null / (rate * (1.0f - probability));
    return outlives(faint, rng, beta);
  });
  return scattered;
}

Color Media::transmittance(const MediaRay& given, Pcg32& rng, MediaCounters& counters) const {
  if (given.stack.empty()) return Color(1.0f);
  MediaRay along = given;
  if (given.attenuated_as != 0) along.ray_kind = given.attenuated_as;
  if (MediumPoint medium; is_uniform(along, medium, counters))
    return transmittance_of(medium.extinction, along.t_end - along.ray.t_min);
  Color through(1.0f);
  track(along, rng, counters, [&](const MediumPoint& point, float rate, float) {
    // Ratio tracking [Novák, Selle and Jarosz 2014].
    through *= (Color(rate) - point.extinction) / rate;
    return outlives(kFaint, rng, through);
  });
  return through;
}

Color Media::transmittance_to_light(Ray ray, MediaStack stack, const ShadingPoint& path, Pcg32& rng,
                                    MediaCounters& counters, bool* by_ray_kind) const {
  if (by_ray_kind) *by_ray_kind = false;
  Color through(1.0f);
  ShadingPoint point;
  const int most = scene_.settings().bounces.transparent;
  for (int crossed = 0, bounds = 0;;) {
    const Hit hit = scene_.intersect(ray, by_ray_kind ? scene_.shadow_kind(ray) : uint32_t(kRayShadow));
    if (!hit.found() && ray.t_max == kInfinity) leave_all(stack, counters);
    if (hit.found()) {
      const ShaderProgram& program = scene_.material(hit);
      const bool only_encloses = program.only_encloses();
      if (only_encloses ? ++bounds > kMaxVolumeBounds : !scene_.shadow_rays_pass(hit) || crossed++ >= most)
        return Color(0.0f);
      if (by_ray_kind && !only_encloses) *by_ray_kind |= scene_.depends_on_ray_kind(hit);
      scene_.shading_point(ray, hit, point);
      point.ray_kind = kRayShadow;
      if (!only_encloses) through *= program.evaluate_transparency(point);
    }
    if (!(max_component(glm::abs(through)) > 0.0f)) return Color(0.0f);
    through *= transmittance({stack, ray, hit.found() ? hit.t : ray.t_max, path, kRayShadow}, rng, counters);
    if (!hit.found() || !(max_component(glm::abs(through)) > 0.0f)) return through;
    cross(hit, !point.backfacing, stack, counters);
    ray = scene_.straight_on_to_end(point, ray);
    if (!(ray.t_max > 0.0f)) return through;
  }
}

}  // namespace ajar
