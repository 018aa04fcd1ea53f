#include "lights/light_clusters.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "geometry/points.h"
#include "lights/sources/triangle_light.h"
#include "math/random.h"

namespace ajar {

namespace {

/// A point and a normal (or 0) in object space.
struct Receiver {
  Vec3 p, n;
  Receiver(const BuiltInstance& instance, Vec3 world_p, Vec3 world_n)
      : p(transform_point(instance.object_from_world, world_p)), n(world_n * Mat3(instance.world_from_object)) {
    const float length = glm::length(n);
    n = length > 0.0f ? n / length : Vec3(0.0f);
  }
};

bool is_usable(const LightBounds& b) {
  return b.intensity > 0.0f && std::isfinite(b.intensity) && is_finite(b.lower) && is_finite(b.upper);
}

}  // namespace

BuiltInstance in_object_space(BuiltInstance instance) {
  instance.world_from_object = instance.object_from_world = Mat4(1.0f);
  instance.flips_orientation = false;
  return instance;
}

int LightClusters::share(const BuiltMesh& mesh, const BuiltInstance& instance, const std::vector<double>& watts) {
  const BuiltInstance still = in_object_space(instance);
  std::vector<LightTree::Entry> entries(watts.size());
  tbb::parallel_for(size_t(0), watts.size(), [&](size_t t) {
    entries[t] = {uint32_t(t), triangle_bounds(world_triangle(mesh, still, uint32_t(t), kMidShutter), float(watts[t]))};
  });
  std::erase_if(entries, [](const LightTree::Entry& e) { return !is_usable(e.bounds); });
  if (entries.empty()) return -1;
  Shared shared;
  for (const LightTree::Entry& e : entries) {
    shared.bounds = join(shared.bounds, e.bounds);
    shared.watts += watts[e.light];
  }
  shared.tree = LightTree(std::move(entries), uint32_t(watts.size()));
  shared.by_power = DiscreteDistribution(watts);
  shared_.push_back(std::move(shared));
  return int(shared_.size()) - 1;
}

void LightClusters::add(uint32_t first_light, uint32_t count, const BuiltInstance& instance, int shared) {
  const uint32_t first_entry = ranges_.empty() ? first_light : ranges_.back().first_entry + ranges_.back().entries;
  ranges_.push_back({first_light, first_entry, count, shared < 0 ? count : 1, shared, &instance});
}

template <uint32_t LightClusters::Range::*kFirst>
const LightClusters::Range* LightClusters::range_from(uint32_t index) const {
  const auto after = std::upper_bound(ranges_.begin(), ranges_.end(), index,
                                      [](uint32_t i, const Range& range) { return i < range.*kFirst; });
  return after == ranges_.begin() ? nullptr : &*(after - 1);
}

const LightClusters::Range* LightClusters::cluster_of_light(uint32_t light) const {
  const Range* range = range_from<&Range::first_light>(light);
  return range && range->shared >= 0 && light - range->first_light < range->count ? range : nullptr;
}

const LightClusters::Range* LightClusters::cluster_of_entry(uint32_t entry) const {
  const Range* range = range_from<&Range::first_entry>(entry);
  return range && range->shared >= 0 && entry == range->first_entry ? range : nullptr;
}

// Lamps come before all ranges, and the environment after them: there the numbers have a constant difference.
uint32_t LightClusters::entry_of(uint32_t light) const {
  const Range* range = range_from<&Range::first_light>(light);
  if (!range) return light;
  const uint32_t offset = light - range->first_light;
  if (offset >= range->count) return range->first_entry + range->entries + (offset - range->count);
  return range->first_entry + (range->shared < 0 ? offset : 0);
}

uint32_t LightClusters::light_of(uint32_t entry) const {
  const Range* range = range_from<&Range::first_entry>(entry);
  if (!range) return entry;
  const uint32_t offset = entry - range->first_entry;
  return offset < range->entries ? range->first_light + offset
                                 : range->first_light + range->count + (offset - range->entries);
}

LightClusters::Choice LightClusters::choose(uint32_t entry, Vec3 p, Vec3 n, float u) const {
  const Range* range = cluster_of_entry(entry);
  if (!range) return {light_of(entry), 1.0f, u};
  const Receiver at(*range->instance, p, n);
  const LightTree::Choice choice = shared_[size_t(range->shared)].tree.choose(at.p, at.n, u);
  return {range->first_light + choice.light, choice.pmf, choice.u_remapped};
}

/// The point of the stretch that is nearest to the cluster. A light inside the cluster is chosen for it: triangles shine
/// to both sides, so each of them can be chosen.
Vec3 LightClusters::nearest_to(const Range& range, const LightStretch& stretch) const {
  const LightBounds& bounds = shared_[size_t(range.shared)].bounds;
  return stretch.point(
      stretch.nearest(transform_point(range.instance->world_from_object, 0.5f * bounds.lower + 0.5f * bounds.upper)));
}

LightClusters::Choice LightClusters::choose(uint32_t entry, const LightStretch& stretch, float u) const {
  const Range* range = cluster_of_entry(entry);
  return range ? choose(entry, nearest_to(*range, stretch), Vec3(0.0f), u) : Choice{light_of(entry), 1.0f, u};
}

LightClusters::Choice LightClusters::choose_by_power(uint32_t entry, float u) const {
  const Range* range = cluster_of_entry(entry);
  if (!range) return {light_of(entry), 1.0f, u};
  const auto choice = shared_[size_t(range->shared)].by_power.sample(u);
  return {range->first_light + choice.index, choice.pmf, choice.u_remapped};
}

float LightClusters::pmf(uint32_t light, Vec3 p, Vec3 n) const {
  const Range* range = cluster_of_light(light);
  if (!range) return 1.0f;
  const Receiver at(*range->instance, p, n);
  return shared_[size_t(range->shared)].tree.pmf(at.p, at.n, light - range->first_light);
}

float LightClusters::pmf(uint32_t light, const LightStretch& stretch) const {
  const Range* range = cluster_of_light(light);
  return range ? pmf(light, nearest_to(*range, stretch), Vec3(0.0f)) : 1.0f;
}

float LightClusters::power_pmf(uint32_t light) const {
  const Range* range = cluster_of_light(light);
  return range ? shared_[size_t(range->shared)].by_power.pmf(light - range->first_light) : 1.0f;
}

LightBounds LightClusters::bounds_of(int shared, const BuiltInstance& instance, float watts) const {
  const LightBounds& here = shared_[size_t(shared)].bounds;
  const Mat4& m = instance.world_from_object;
  LightBounds there = here;
  there.lower = Vec3(kInfinity);
  there.upper = Vec3(-kInfinity);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p = transform_point(m,
                                   {corner & 1 ? here.upper.x : here.lower.x, corner & 2 ? here.upper.y : here.lower.y,
                                    corner & 4 ? here.upper.z : here.lower.z});
    there.lower = glm::min(there.lower, p);
    there.upper = glm::max(there.upper, p);
  }
  const Vec3 axis = here.axis * Mat3(instance.object_from_world);
  const float length = glm::length(axis);
  if (scales_evenly(m) && length > 0.0f)
    there.axis = axis / length;
  else
    there.cos_normals = -1.0f;
  there.intensity = float(double(here.intensity) * double(watts) / shared_[size_t(shared)].watts);
  return there;
}

uint64_t LightClusters::fingerprint() const {
  uint64_t hash = hash64(ranges_.size());
  for (const Shared& shared : shared_) hash = hash64(hash ^ shared.tree.fingerprint());
  return hash;
}

size_t LightClusters::memory_bytes() const {
  size_t bytes = ranges_.size() * sizeof(Range);
  for (const Shared& shared : shared_) bytes += shared.tree.memory_bytes() + shared.by_power.memory_bytes();
  return bytes;
}

}  // namespace ajar
