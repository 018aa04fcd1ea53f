#include "transport/media/media.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

namespace ajar {

namespace {

constexpr float kLargestExtent = 1e18f;  ///< of a volume that varies, in metres
constexpr uint64_t kMaxMajorants = 8 * 16 * 16 * 16;
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

constexpr uint32_t kEveryVisibility = kVisibleCamera | kVisibleDiffuse | kVisibleGlossy | kVisibleTransmission |
                                      kVisibleVolumeScatter | kVisibleShadow;

/// Number of cells along the longest axis of each of `varying` grids. All grids together have at most kMaxMajorants
/// cells, or one cell each.
int cells_of(size_t varying) { return varying <= 8 ? 16 : varying <= 64 ? 8 : varying <= 512 ? 4 : 1; }

void grow(Vec3 p, Vec3& lower, Vec3& upper) {
  lower = glm::min(lower, p);
  upper = glm::max(upper, p);
}

/// World-space bounds of an instance over the whole shutter interval.
void bounds_of(const BuiltMesh& mesh, const BuiltInstance& instance, Vec3& lower, Vec3& upper) {
  Vec3 low(kInfinity), high(-kInfinity);
  const auto grow_by = [&](const std::vector<Vec3>& positions) {
    for (size_t i = 0; i + 1 < positions.size(); ++i) grow(positions[i], low, high);
  };
  grow_by(mesh.positions);
  if (mesh.deformation)
    for (const Deformation::Key& key : mesh.deformation->keys) grow_by(key.positions);
  if (mesh.baked || !(low.x <= high.x)) {
    lower = low;
    upper = high;
    return;
  }
  lower = Vec3(kInfinity);
  upper = Vec3(-kInfinity);
  const uint32_t count = std::max(instance.motion_count, 1u);
  for (uint32_t key = 0; key < count; ++key) {
    const Mat4& m = instance.motion ? instance.motion[key] : instance.world_from_object;
    for (int corner = 0; corner < 8; ++corner)
      grow(transform_point(m,
                           Vec3(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z)),
           lower, upper);
  }
}

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

void MediaCounters::add(const MediaCounters& other) {
  lookups += other.lookups;
  exceeded += other.exceeded;
  capped += other.capped;
  refused += other.refused;
  open_ends += other.open_ends;
  too_deep += other.too_deep;
}

bool MediaStack::contains(uint32_t medium) const {
  return std::find(media_.begin(), media_.begin() + count_, medium) != media_.begin() + count_;
}

bool MediaStack::enter(uint32_t medium) {
  if (contains(medium)) return true;
  if (count_ == kMax) return false;
  media_[size_t(count_++)] = medium;
  return true;
}

void MediaStack::leave(uint32_t medium) {
  const auto end = media_.begin() + count_, found = std::find(media_.begin(), end, medium);
  if (found == end) return;
  std::copy(found + 1, end, found);
  --count_;
}

Media::Media(const Scene& scene) : scene_(scene), first_of_instance_(scene.instances().size(), kNone) {
  if (scene.world_program().has_volume()) {
    world_ = 0;
    media_.push_back({kNone, kNone, &scene.world_program(), false, {}, {}, {}, {}, 0, 0.0f});
  }
  size_t varying = 0;
  for (uint32_t i = 0; i < scene.instances().size(); ++i) {
    const BuiltInstance& instance = scene.instances()[i];
    if (!scene.meshes()[instance.mesh].has_triangles()) continue;  // strands and points enclose no volume
    Vec3 lower(kInfinity), upper(-kInfinity);
    for (const uint32_t material : scene.materials_of(instance)) {
      const ShaderProgram& program = scene.programs()[material];
      if (!program.has_volume()) continue;
      if (first_of_instance_[i] == kNone) {
        first_of_instance_[i] = uint32_t(media_.size());
        bounds_of(scene.meshes()[instance.mesh], instance, lower, upper);
        lower_ = glm::min(lower_, lower);
        upper_ = glm::max(upper_, upper);
      }
      const bool known = std::any_of(media_.begin() + first_of_instance_[i], media_.end(),
                                     [&](const Medium& m) { return m.material == material; });
      if (known) continue;
      // Larger volumes are treated as uniform, because the lengths of cells would overflow.
      const bool varies = program.medium_varies() && max_component(upper - lower) < kLargestExtent;
      varying += varies ? 1 : 0;
      media_.push_back({i, material, &program, varies, lower, upper - lower, {}, {}, 0, 0.0f});
      media_.back().visibility = instance.visibility;
      any_hidden_ |= (instance.visibility & kEveryVisibility) != kEveryVisibility;
      if (scene.meshes()[instance.mesh].density_in_object_space) {
        const float length = glm::length(Mat3(instance.world_from_object) * Vec3(1.0f / std::sqrt(3.0f)));
        if (length > 0.0f) media_.back().scale = 1.0f / length;
      }
    }
  }
  const int cells_along = cells_of(varying);
  for (Medium& medium : media_)
    if (medium.varies) find_majorants(medium, cells_along, FineMajorants::kMaxDivided / varying);
  find_emission();
}

uint64_t Media::max_bytes(uint64_t volumes, uint64_t instances) {
  // The capacity of a growing vector is at most twice its size.
  return 2 * (volumes * sizeof(Medium) + (kMaxMajorants + volumes) * sizeof(float)) + instances * sizeof(uint32_t) +
         FineMajorants::bytes_of(FineMajorants::kMaxDivided, kMaxMajorants + volumes);
}

/// Media that vary end at their bounds, in case a ray has missed their surface.
bool Media::reaches(const Medium& medium, Vec3 position) const {
  for (int axis = 0; axis < 3; ++axis) {
    const float place = (position[axis] - medium.lower[axis]) * medium.inverse_size[axis];
    if (!(place >= 0.0f && place < float(medium.cells[size_t(axis)]))) return false;
  }
  return true;
}

uint32_t Media::medium_of(const Hit& hit) const {
  const uint32_t first = first_of_instance_[hit.instance];
  if (first == kNone) return kNone;
  const uint32_t material = uint32_t(scene_.material_index(hit));
  for (uint32_t i = first; i < media_.size() && media_[i].instance == hit.instance; ++i)
    if (media_[i].material == material) return i;
  return kNone;
}

void Media::cross(const Hit& hit, bool inwards, MediaStack& stack, MediaCounters& counters) const {
  const uint32_t medium = medium_of(hit);
  if (medium == kNone) return;
  if (!inwards)
    stack.leave(medium);
  else if (!stack.enter(medium))
    ++counters.too_deep;
}

void Media::leave_all(MediaStack& stack, MediaCounters& counters) const {
  const int world = world_ == kNone ? 0 : 1;
  if (stack.size() == world) return;
  ++counters.open_ends;
  stack = MediaStack();
  if (world_ != kNone) stack.enter(world_);
}

MediaStack Media::around(Vec3 position, float time, MediaCounters& counters) const {
  MediaStack stack, entered;
  if (world_ != kNone) stack.enter(world_);
  for (int axis = 0; axis < 3; ++axis)
    if (!(position[axis] >= lower_[axis] && position[axis] <= upper_[axis])) return stack;
  Ray ray;
  ray.origin = position;
  ray.time = time;
  ShadingPoint point;
  for (int crossed = 0; crossed < kMaxVolumeBounds; ++crossed) {
    const Hit hit = scene_.intersect(ray, kRayCamera);
    if (!hit.found()) break;
    scene_.shading_point(ray, hit, point);
    if (const uint32_t medium = medium_of(hit); medium != kNone) {
      if (!point.backfacing)
        entered.enter(medium);
      else if (!entered.contains(medium) && !stack.enter(medium))
        ++counters.too_deep;
    }
    ray = scene_.straight_on(point, ray, hit.t);
  }
  return stack;
}

void Media::add(const Medium& medium, ShadingPoint& inside, MediumPoint& point, MediaCounters& counters) const {
  if (medium.instance == kNone) {
    inside.instance = nullptr;
    inside.mesh = nullptr;
    inside.object = nullptr;
    // The position of a point of the world is a direction. The volume of the world is evaluated in the direction of the
    // centre of the scene.
    ShadingPoint middle = inside;
    middle.position = scene_.center();
    middle.wo = middle.ng = middle.ns = -scene_.center();
    medium.program->add_medium(middle, point);
    return;
  }
  const BuiltInstance& instance = scene_.instances()[medium.instance];
  inside.instance = &instance;
  inside.mesh = &scene_.meshes()[instance.mesh];
  inside.object = &scene_.object(instance.object);
  if (!medium.varies && medium.scale == 1.0f) {
    medium.program->add_medium(inside, point);
    return;
  }
  if (medium.inverse_size.x > 0.0f && !reaches(medium, inside.position)) return;
  MediumPoint own;
  medium.program->add_medium(inside, own);
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

bool Media::varies(const MediaStack& stack) const {
  for (int i = 0; i < stack.size(); ++i)
    if (media_[stack[i]].varies) return true;
  return false;
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
        rate += majorant(medium, position, along.ray.direction, reach);
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

bool Media::emits(const MediaStack& stack) const {
  for (int i = 0; i < stack.size(); ++i)
    if (media_[stack[i]].emits) return true;
  return false;
}

bool Media::any_emission() const {
  return std::any_of(media_.begin(), media_.end(), [](const Medium& medium) { return medium.emits; });
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
  Color probability(0.0f);
  if (may_scatter && at.scatters()) {
    for (int c = 0; c < 3; ++c) {
      const float albedo = at.extinction[c] > 0.0f ? at.scattering[c] / at.extinction[c] : 0.0f;
      // A channel is chosen with a probability proportional to its throughput, and larger if it scatters much.
      probability[c] = std::abs(beta[c]) * (kMinChannel + (1.0f - kMinChannel) * albedo);
    }
    const float sum = probability.x + probability.y + probability.z;
    if (sum > 0.0f) probability /= sum;
  }
  if (is_black(probability)) {
    beta *= through;
    return false;
  }
  const int channel = u.y < probability.x ? 0 : u.y < probability.x + probability.y ? 1 : 2;
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

uint32_t Media::receiver_set(const MediaStack& stack) const {
  const uint32_t instance = stack.empty() ? kNone : media_[stack[stack.size() - 1]].instance;
  return instance == kNone ? kEveryLight : scene_.object(scene_.instances()[instance].object).receiver_set;
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
    const Hit hit = scene_.intersect(ray, kRayShadow);
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
