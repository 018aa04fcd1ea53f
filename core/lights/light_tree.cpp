#include "lights/light_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>

#include <tbb/parallel_invoke.h>

#include "math/random.h"

namespace ajar {

namespace {

constexpr int kBins = 12;
constexpr int kDeepestByCost = 32;  ///< below this depth, nodes are halved by number: a trail has at most 63 branches
constexpr uint32_t kParallelBuild = 8192;
constexpr size_t kSampled = 2048;  ///< about so many lights of a node decide its split
/// Minimum cosine at the receiver: shading normals differ from geometric ones, and coats have normals of their own.
constexpr float kMinReceiverCosine = 0.02f;
/// For stretches: rounding of the cosine at the edge of a cone, and the minimum factor of lights that may reach one.
constexpr float kConeRounding = 1e-4f, kMinEmitterCosine = 1e-3f;

float area_measure(const LightBounds& b) {
  const Vec3 d = b.upper - b.lower;
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

/// Cosine of max(0, a - b) from the cosines of a and b and the sine of b; a is at most 180 degrees.
float cos_of_rest(float cos_a, float cos_b, float sin_b) {
  if (cos_a >= cos_b) return 1.0f;
  const float sin_a = std::sqrt(std::abs(1.0f - cos_a * cos_a));  // rounding at 180 degrees can make this negative
  return cos_a * cos_b + sin_a * sin_b;
}

/// atan2(y, x) for y >= 0, within 0.005. An importance need not be exact.
float angle_of(float y, float x) {
  const float most = std::max(y, std::abs(x)), z = std::min(y, std::abs(x)) / std::max(most, 1e-30f);
  const float octant = z / (1.0f + 0.28f * z * z), quadrant = y > std::abs(x) ? 0.5f * kPi - octant : octant;
  return x < 0.0f ? kPi - quadrant : quadrant;
}

Vec3 center_of(const LightBounds& b) { return 0.5f * b.lower + 0.5f * b.upper; }

/// A split of lights into those up to a bin of their centres and those above.
struct Split {
  Vec3 lower, extent;  ///< of the centres
  int axis = -1;       ///< negative: there is none
  int bin = 0;         ///< the last before the split

  int bin_of(const LightTree::Entry& e, int of_axis) const {
    const float along = (center_of(e.bounds)[of_axis] - lower[of_axis]) /
                        extent[of_axis];  // divide first: bins times metres can overflow
    return std::min(int(kBins * along), kBins - 1);
  }
  /// Takes the cheapest split between bins. Its cost is intensity times measure of directions times area.
  void find_cheapest(std::span<const LightTree::Entry> entries);
};

/// Joins for the cost of a split, where the cone of a two-sided sum does not count.
void join_for_cost(LightBounds& sum, const LightBounds& other) {
  if (sum.intensity > 0.0f && (sum.two_sided || other.two_sided))
    widen(sum, other);
  else
    sum = join(sum, other);
}

void Split::find_cheapest(std::span<const LightTree::Entry> entries) {
  const float longest = std::max({extent.x, extent.y, extent.z});
  const size_t step = std::max<size_t>(1, entries.size() / kSampled);
  float best_cost = kInfinity;
  for (int a = 0; a < 3; ++a) {
    if (!(extent[a] > 0.0f) || !std::isfinite(extent[a])) continue;
    std::array<LightBounds, kBins> bins, above;
    for (size_t i = 0; i < entries.size(); i += step)
      join_for_cost(bins[size_t(bin_of(entries[i], a))], entries[i].bounds);
    above[kBins - 1] = bins[kBins - 1];
    for (int b = kBins - 2; b > 0; --b) {
      above[size_t(b)] = bins[size_t(b)];
      join_for_cost(above[size_t(b)], above[size_t(b) + 1]);
    }
    LightBounds below;
    for (int b = 0; b + 1 < kBins; ++b) {
      join_for_cost(below, bins[size_t(b)]);
      const LightBounds& rest = above[size_t(b) + 1];
      if (!(below.intensity > 0.0f) || !(rest.intensity > 0.0f)) continue;
      // Thin slices make needle-shaped nodes, so their cost is scaled by their longest side.
      const float cost = longest / extent[a] *
                         (below.intensity * orientation_measure(below) * area_measure(below) +
                          rest.intensity * orientation_measure(rest) * area_measure(rest));
      if (cost < best_cost) {
        best_cost = cost;
        axis = a;
        bin = b;
      }
    }
  }
}

}  // namespace

LightTree::LightTree(std::vector<Entry> entries, uint32_t light_count) {
  if (entries.empty()) return;
  nodes_.resize(2 * entries.size() - 1);
  trails_.assign(light_count, kNoTrail);
  build(entries, 0, uint32_t(entries.size()), 0, 1);
}

uint64_t LightTree::fingerprint() const {
  uint64_t hash = hash64(nodes_.size());
  const auto add = [&](float x) { hash = hash64(hash ^ std::bit_cast<uint32_t>(x)); };
  for (const Node& node : nodes_) {
    for (const Vec3& v : {node.center, node.axis})
      for (int axis = 0; axis < 3; ++axis) add(v[axis]);
    for (const float x :
         {node.radius_squared, node.cos_normals, node.cos_beyond, node.intensity, node.growing.x, node.growing.y})
      add(x);
    hash = hash64(hash ^ node.second ^ (uint64_t(node.leaf) << 32) ^ (uint64_t(node.two_sided) << 33));
  }
  return hash;
}

void LightTree::set_bounds(Node& n, const LightBounds& bounds) {
  n.center = center_of(bounds);
  const Vec3 half = 0.5f * bounds.upper - 0.5f * bounds.lower;
  n.radius_squared = glm::dot(half, half);
  n.half = half;
  n.axis = bounds.axis;
  n.cos_normals = bounds.cos_normals;
  n.sin_normals = std::sqrt(std::max(0.0f, 1.0f - sqr(bounds.cos_normals)));
  n.cos_beyond = bounds.cos_beyond;
  n.intensity = std::max(bounds.intensity - bounds.grown, 0.0f);
  n.growing = bounds.growing;
  n.two_sided = bounds.two_sided;
}

LightBounds LightTree::build(std::vector<Entry>& entries, uint32_t begin, uint32_t end, uint32_t node, uint64_t trail) {
  Node& n = nodes_[node];
  n.leaf = end - begin == 1;
  if (n.leaf) {
    set_bounds(n, entries[begin].bounds);
    n.second = entries[begin].light;
    trails_[n.second] = trail;
    return entries[begin].bounds;
  }
  Vec3 lower(kInfinity), upper(-kInfinity);
  for (uint32_t i = begin; i < end; ++i) {
    const Vec3 c = center_of(entries[i].bounds);
    lower = glm::min(lower, c);
    upper = glm::max(upper, c);
  }
  const Vec3 extent = upper - lower;
  int depth = 0;
  for (uint64_t t = trail; t > 1; t >>= 1) ++depth;
  Split split{lower, extent};
  if (depth < kDeepestByCost) split.find_cheapest({entries.data() + begin, end - begin});
  const auto first = entries.begin() + begin, last = entries.begin() + end;
  uint32_t middle = begin + (end - begin) / 2;
  if (split.axis >= 0) {
    middle = uint32_t(
        std::partition(first, last, [&](const Entry& e) { return split.bin_of(e, split.axis) <= split.bin; }) -
        entries.begin());
  } else {
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
    std::nth_element(first, entries.begin() + middle, last, [axis](const Entry& a, const Entry& b) {
      const float ca = center_of(a.bounds)[axis], cb = center_of(b.bounds)[axis];
      return ca != cb ? ca < cb : a.light < b.light;
    });
  }
  const uint32_t second = node + 2 * (middle - begin);
  n.second = second;
  // The trail grows at its top: the bit that ends it moves up.
  const uint64_t end_bit = uint64_t(1) << depth, deeper = end_bit << 1;
  const uint64_t to_first = (trail ^ end_bit) | deeper, to_second = trail | deeper;
  LightBounds of_first, of_second;
  const auto build_first = [&] { of_first = build(entries, begin, middle, node + 1, to_first); };
  const auto build_second = [&] { of_second = build(entries, middle, end, second, to_second); };
  if (end - begin > kParallelBuild) {
    tbb::parallel_invoke(build_first, build_second);
  } else {
    build_first();
    build_second();
  }
  const LightBounds both = join(of_first, of_second);
  set_bounds(n, both);
  return both;
}

/// The intensity for a point at this squared distance.
float LightTree::strength(const Node& node, float distance2) {
  if (node.growing == Vec2(0.0f)) return node.intensity;
  return node.intensity + node.growing.x * std::sqrt(distance2) + node.growing.y * distance2;
}

float LightTree::importance(const Node& node, const Vec3& p, const Vec3& n) {
  const Vec3 d = node.center - p;
  const float distance2 = glm::dot(d, d);
  if (!(distance2 > node.radius_squared))
    return strength(node, node.radius_squared) / std::max(node.radius_squared, 1e-30f);
  const float inverse = 1.0f / std::sqrt(distance2);
  // `size` is the half-angle of the sphere around the lights, seen from p.
  const float sin2_size = node.radius_squared / distance2;
  const float cos_size = std::sqrt(1.0f - sin2_size), sin_size = std::sqrt(sin2_size);
  const float intensity = strength(node, distance2);
  float result = intensity / distance2;
  // If there are normals in all directions, one of them points to p.
  if (node.cos_normals > -1.0f) {
    float cos_axis = -glm::dot(node.axis, d) * inverse;
    if (node.two_sided) cos_axis = std::abs(cos_axis);
    if (cos_axis < node.cos_normals) {
      const float cos_out = cos_of_rest(cos_of_rest(cos_axis, node.cos_normals, node.sin_normals), cos_size, sin_size);
      if (cos_out < node.cos_beyond) return 0.0f;
      result = intensity * std::max(cos_out, 0.0f) / distance2;
    }
  }
  if (length_squared(n) > 0.0f)
    result *= std::max(cos_of_rest(glm::dot(n, d) * inverse, cos_size, sin_size), kMinReceiverCosine);
  return result;
}

float LightTree::importance(const Node& node, const LightStretch& stretch) {
  if (stretch.is_point()) return importance(node, stretch.origin, Vec3(0.0f));
  // v: from the centre of the lights to the origin of the ray. The ray is nearest at the distance `nearest`.
  const Vec3 v = stretch.origin - node.center;
  const float nearest = -glm::dot(v, stretch.direction);
  // Where a ray goes through the box, the mean of 1 / distance is that at half of its size across the ray.
  const float across2 = glm::dot(node.half * node.half, 1.0f - stretch.direction * stretch.direction);
  const float apart2 = std::max(length_squared(v + nearest * stretch.direction), std::max(0.25f * across2, 0.0f));
  const float apart = std::max(std::sqrt(apart2), 1e-15f);
  const float before = stretch.begin - nearest, after = before + stretch.reach;
  const float angle = angle_of(apart * stretch.reach, apart2 + before * after);  // between both ends, seen from there
  const float distance2_in_reach = apart2 + sqr(before > 0.0f ? before : std::min(after, 0.0f));
  const float mean = strength(node, distance2_in_reach) * angle / (apart * stretch.reach);
  if (!(node.cos_normals > -1.0f)) return mean;
  // The nearest point of the whole stretch, and the point that is seen from there in the direction nearest to the axis.
  const float distance2 = length_squared(v + glm::clamp(nearest, stretch.begin, stretch.end) * stretch.direction);
  if (!(distance2 > node.radius_squared)) return mean;
  const auto cosine_at = [&](float t) {
    const Vec3 to_point = v + t * stretch.direction;
    const float length = glm::length(to_point);
    const float cosine = length > 0.0f ? glm::dot(node.axis, to_point) / length : 1.0f;
    return node.two_sided ? std::abs(cosine) : cosine;
  };
  const float last = std::min(stretch.end, 1e15f);
  float cos_axis = std::max(cosine_at(stretch.begin), cosine_at(last));
  const float a = glm::dot(node.axis, v), b = glm::dot(node.axis, stretch.direction);
  const float extreme = (b * length_squared(v) + a * nearest) / (a + b * nearest);  // where the derivative is 0
  if (extreme > stretch.begin && extreme < last) cos_axis = std::max(cos_axis, cosine_at(extreme));
  if (cos_axis >= node.cos_normals) return mean;
  const float sin2_size = std::min(node.radius_squared / distance2, 1.0f);
  const float cos_out = cos_of_rest(cos_of_rest(cos_axis, node.cos_normals, node.sin_normals),
                                    std::sqrt(1.0f - sin2_size), std::sqrt(sin2_size));
  return cos_out < node.cos_beyond - kConeRounding ? 0.0f : mean * std::max(cos_out, kMinEmitterCosine);
}

template <class... Receiver>
float LightTree::first_share(uint32_t node, const Receiver&... receiver) const {
  const float first = importance(nodes_[node + 1], receiver...),
              second = importance(nodes_[nodes_[node].second], receiver...);
  const float sum = first + second;
  if (!(sum > 0.0f)) return -1.0f;
  if (std::isfinite(sum)) return first / sum;
  return std::isfinite(first) ? 0.0f : (std::isfinite(second) ? 1.0f : 0.5f);
}

template <class... Receiver>
LightTree::Choice LightTree::choose_for(uint32_t node, float u, const Receiver&... receiver) const {
  float pmf = 1.0f;
  while (!nodes_[node].leaf) {
    const float first = first_share(node, receiver...);
    if (first < 0.0f) return {0, 0.0f, u};
    if (u < first) {
      u = std::min(u / first, kOneMinusEpsilon);
      pmf *= first;
      ++node;
    } else {
      u = std::min((u - first) / (1.0f - first), kOneMinusEpsilon);
      pmf *= 1.0f - first;
      node = nodes_[node].second;
    }
  }
  return {nodes_[node].second, pmf, u};
}

LightTree::Choice LightTree::choose_below(uint32_t node, Vec3 p, Vec3 n, float u) const {
  return choose_for(node, u, p, n);
}

LightTree::Choice LightTree::choose(const LightStretch& stretch, float u) const { return choose_for(0, u, stretch); }

template <class... Receiver>
float LightTree::pmf_for(uint32_t top, uint32_t light, const Receiver&... receiver) const {
  if (!contains(light)) return 0.0f;
  float pmf = 1.0f;
  uint32_t node = 0;
  bool below = top == 0;
  for (uint64_t trail = trails_[light]; trail > 1; trail >>= 1) {
    const bool to_second = trail & 1;
    if (below) {
      const float first = first_share(node, receiver...);
      if (first < 0.0f) return 0.0f;
      pmf *= to_second ? 1.0f - first : first;
    }
    node = to_second ? nodes_[node].second : node + 1;
    below |= node == top;
  }
  return below ? pmf : 0.0f;
}

float LightTree::pmf_below(uint32_t top, Vec3 p, Vec3 n, uint32_t light) const { return pmf_for(top, light, p, n); }

float LightTree::pmf(const LightStretch& stretch, uint32_t light) const { return pmf_for(0, light, stretch); }

uint32_t LightTree::leaf_of(uint32_t light) const {
  uint32_t node = 0;
  for (uint64_t trail = trails_[light]; trail > 1; trail >>= 1) node = trail & 1 ? nodes_[node].second : node + 1;
  return node;
}

/// Importance for the most favourable point within `radius` of p with a normal at most half a radian from n.
float LightTree::importance_nearby(const Node& node, Vec3 p, float radius, Vec3 n) {
  constexpr float kBend = 0.5f;
  Node wide = node;
  wide.radius_squared = sqr(std::sqrt(node.radius_squared) + radius);
  float result = importance(wide, p, Vec3(0.0f));
  const Vec3 d = node.center - p;
  const float distance2 = glm::dot(d, d);
  if (n != Vec3(0.0f) && distance2 > wide.radius_squared) {
    const float angle = std::acos(glm::clamp(glm::dot(n, d) / std::sqrt(distance2), -1.0f, 1.0f)) -
                        std::asin(std::sqrt(wide.radius_squared / distance2)) - kBend;
    result *= std::max(std::cos(std::max(angle, 0.0f)), kMinReceiverCosine);
  }
  return result;
}

void LightTree::cut(Vec3 p, float radius, Vec3 n, int max_nodes, std::vector<CutNode>& nodes) const {
  nodes.clear();
  if (nodes_.empty()) return;
  const auto node = [&](uint32_t index) { return CutNode{index, importance_nearby(nodes_[index], p, radius, n)}; };
  nodes.push_back(node(0));
  while (int(nodes.size()) < max_nodes) {
    int next = -1;
    for (size_t i = 0; i < nodes.size(); ++i)
      if (!nodes_[nodes[i].node].leaf && (next < 0 || nodes[i].share > nodes[size_t(next)].share)) next = int(i);
    if (next < 0) break;
    const uint32_t split = nodes[size_t(next)].node;
    nodes[size_t(next)] = node(split + 1);
    nodes.insert(nodes.begin() + next + 1, node(nodes_[split].second));
  }
  // The importance of lights without extent at p itself is infinite.
  double sum = 0.0;
  for (CutNode& c : nodes) {
    if (!(c.share < 1e30f)) c.share = 1e30f;
    sum += double(c.share);
  }
  for (CutNode& c : nodes) c.share = sum > 0.0 ? float(double(c.share) / sum) : 1.0f / float(nodes.size());
}

}  // namespace ajar
