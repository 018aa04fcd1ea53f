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

float area_measure(const LightBounds& b) {
  const Vec3 d = b.upper - b.lower;
  return d.x * d.y + d.y * d.z + d.z * d.x;
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
  if (entries.size() == 2) {  // half of all nodes: the only split costs least along the longest side
    axis = extent.x == longest ? 0 : extent.y == longest ? 1 : 2;
    if (!(longest > 0.0f) || !std::isfinite(longest)) axis = -1;
    return;
  }
  const size_t step = std::max<size_t>(1, entries.size() / kSampled);
  float best_cost = kInfinity;
  for (int a = 0; a < 3; ++a) {
    if (!(extent[a] > 0.0f) || !std::isfinite(extent[a])) continue;
    std::array<LightBounds, kBins> bins, above;
    uint32_t used = 0;  // a bit for each bin
    for (size_t i = 0; i < entries.size(); i += step) {
      const int b = bin_of(entries[i], a);
      used |= 1u << b;
      join_for_cost(bins[size_t(b)], entries[i].bounds);
    }
    // Most nodes have few lights, so most bins are empty.
    std::array<int, kBins> filled;
    size_t count = 0;
    for (; used != 0; used &= used - 1) filled[count++] = std::countr_zero(used);
    for (size_t k = count - 1; k > 0; --k) {
      above[k] = bins[size_t(filled[k])];
      if (k + 1 < count) join_for_cost(above[k], above[k + 1]);
    }
    LightBounds below;
    for (size_t k = 0; k + 1 < count; ++k) {
      join_for_cost(below, bins[size_t(filled[k])]);
      const LightBounds& rest = above[k + 1];
      // Thin slices make needle-shaped nodes, so their cost is scaled by their longest side.
      const float cost = longest / extent[a] *
                         (below.intensity * orientation_measure(below) * area_measure(below) +
                          rest.intensity * orientation_measure(rest) * area_measure(rest));
      if (cost < best_cost) {
        best_cost = cost;
        axis = a;
        bin = filled[k];
      }
    }
  }
}

}  // namespace

LightTree::LightTree(std::vector<Entry> entries, uint32_t light_count) {
  if (entries.empty()) return;
  lamps_ = uint32_t(std::partition(entries.begin(), entries.end(), [](const Entry& e) { return !e.bounds.two_sided; }) -
                    entries.begin());
  std::vector<LightLanes::Lane> lanes(lamps_ > 1 ? lamps_ : 0);
  nodes_.resize(2 * entries.size() - 1);
  trails_.assign(light_count, kNoTrail);
  build(entries, 0, uint32_t(entries.size()), 0, 1, lanes);
  if (lamps_ > 1) divide(lamps_ < entries.size() ? 1 : 0, lanes);
  lanes_ = LightLanes(lanes);
}

uint64_t LightTree::fingerprint() const {
  uint64_t hash = hash64(nodes_.size());
  const auto add = [&](float x) { hash = hash64(hash ^ std::bit_cast<uint32_t>(x)); };
  for (const Node& node : nodes_) {
    for (const Vec3& v : {Vec3(node.center), Vec3(node.axis)})
      for (int axis = 0; axis < 3; ++axis) add(v[axis]);
    for (const float x :
         {node.radius_squared, node.cos_normals, node.cos_beyond, node.intensity, node.growing, node.growing_squared})
      add(x);
    hash = hash64(hash ^ node.second ^ (uint64_t(node.leaf) << 32) ^ (uint64_t(node.two_sided) << 33));
  }
  return hash;
}

LightBounds LightTree::build(std::vector<Entry>& entries, uint32_t begin, uint32_t end, uint32_t node, uint64_t trail,
                             std::vector<LightLanes::Lane>& lanes) {
  Node& n = nodes_[node];
  const auto set_bounds = [&](const LightBounds& bounds) {
    static_cast<LightAim&>(n) = aim_of(bounds);
    n.two_sided = bounds.two_sided;
  };
  n.leaf = end - begin == 1;
  n.lane = begin % kMaxLanes;
  n.parts = !n.leaf && end <= std::min(lamps_, kMaxLanes) && end - begin <= kParts ? end - begin : 0;
  if (n.leaf) {
    set_bounds(entries[begin].bounds);
    n.second = entries[begin].light;
    trails_[n.second] = trail;
    if (begin < lanes.size()) lanes[begin] = {n, node};
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
  if (begin < lamps_ && lamps_ < end) {
    middle = lamps_;
  } else if (split.axis >= 0) {
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
  const auto build_first = [&] { of_first = build(entries, begin, middle, node + 1, to_first, lanes); };
  const auto build_second = [&] { of_second = build(entries, middle, end, second, to_second, lanes); };
  if (end - begin > kParallelBuild) {
    tbb::parallel_invoke(build_first, build_second);
  } else {
    build_first();
    build_second();
  }
  const LightBounds both = join(of_first, of_second);
  set_bounds(both);
  return both;
}

void LightTree::divide(uint32_t node, std::vector<LightLanes::Lane>& lanes) {
  if (nodes_[node].leaf || nodes_[node].parts > 0) return;
  const auto cost = [&](uint32_t index) {
    const Node& n = nodes_[index];
    LightBounds bounds;
    bounds.lower = -Vec3(n.half);
    bounds.upper = Vec3(n.half);
    bounds.cos_normals = n.cos_normals;
    bounds.cos_beyond = n.cos_beyond;
    const float cost = n.intensity * orientation_measure(bounds) * area_measure(bounds);
    return n.leaf ? -1.0f : (cost > 0.0f ? cost : 0.0f);  // 0 if it is not a number: only leaves cannot be divided
  };
  struct Part {
    uint32_t node;
    float cost;
  };
  std::vector<Part> parts{{node, 0.0f}};
  while (parts.size() < kParts) {
    const auto next = std::max_element(parts.begin(), parts.end(),
                                       [](const Part& a, const Part& b) { return a.cost < b.cost; });
    const uint32_t first = next->node + 1, second = nodes_[next->node].second;
    *next = {first, cost(first)};
    parts.insert(next + 1, {second, cost(second)});
  }
  if (lanes.size() + kParts > kMaxLanes) return;
  nodes_[node].lane = uint32_t(lanes.size());
  nodes_[node].parts = kParts;
  for (const Part& part : parts) lanes.push_back({nodes_[part.node], part.node});
  for (const Part& part : parts) divide(part.node, lanes);
}

namespace {

PlainStretch plain(const LightStretch& s) { return {Triple(s.origin), Triple(s.direction), s.begin, s.end, s.reach}; }

}  // namespace

float LightTree::importance(const Node& node, const LightStretch& stretch) {
  if (stretch.is_point()) return importance(node, stretch.origin, Vec3(0.0f));
  return fluence_estimate<true>(node, node.two_sided, plain(stretch));
}

/// Infinite importances count alike, and nothing beside them counts.
float LightTree::finite_sum(Importances& values, uint32_t count) {
  float sum = 0.0f;
  for (uint32_t i = 0; i < count; ++i) sum += values[i];
  if (std::isfinite(sum)) [[likely]]
    return sum;
  const bool any_infinite = std::any_of(values.begin(), values.begin() + count, [](float v) { return std::isinf(v); });
  sum = 0.0f;
  for (uint32_t i = 0; i < count; ++i) {
    values[i] = any_infinite ? float(std::isinf(values[i])) : values[i] / float(count);
    sum += values[i];
  }
  return sum;
}

float LightTree::importances(uint32_t node, Importances& values, const Vec3& p, const Vec3& n) const {
  lanes_.estimate(nodes_[node].lane, nodes_[node].parts, p, n, values.data());
  return finite_sum(values, nodes_[node].parts);
}

float LightTree::importances(uint32_t node, Importances& values, const LightStretch& stretch) const {
  if (stretch.is_point()) return importances(node, values, stretch.origin, Vec3(0.0f));
  lanes_.estimate(nodes_[node].lane, nodes_[node].parts, plain(stretch), values.data());
  return finite_sum(values, nodes_[node].parts);
}

template <class... Receiver>
float LightTree::importance_of(uint32_t node, const Receiver&... receiver) const {
  if (nodes_[node].parts == 0) [[likely]]
    return importance(nodes_[node], receiver...);
  Importances values;
  return importances(node, values, receiver...);
}

template <class... Receiver>
float LightTree::importance_of_all(const Receiver&... receiver) const {
  if (nodes_.empty()) return 0.0f;
  if (lamps_ == 0 || nodes_.size() + 1 == 2 * size_t(lamps_)) return importance_of(0, receiver...);
  return importance_of(1, receiver...) + importance_of(nodes_[0].second, receiver...);
}

float LightTree::importance(Vec3 p, Vec3 n) const { return importance_of_all(p, n); }

float LightTree::importance(const LightStretch& stretch) const { return importance_of_all(stretch); }

template <class... Receiver>
float LightTree::first_share(uint32_t node, const Receiver&... receiver) const {
  const float first = importance_of(node + 1, receiver...), second = importance_of(nodes_[node].second, receiver...);
  const float sum = first + second;
  if (!(sum > 0.0f)) return -1.0f;
  if (std::isfinite(sum)) return first / sum;
  return std::isfinite(first) ? 0.0f : (std::isfinite(second) ? 1.0f : 0.5f);
}

template <class... Receiver>
LightTree::Choice LightTree::choose_part(uint32_t node, float u, const Receiver&... receiver) const {
  Importances values;
  const float sum = importances(node, values, receiver...);
  if (!(sum > 0.0f)) return {0, 0.0f, u};
  uint32_t chosen = 0;
  float rest = u * sum;
  for (uint32_t i = 0; i < nodes_[node].parts; ++i) {
    if (!(values[i] > 0.0f)) continue;
    chosen = i;
    if (rest < values[i]) break;
    rest -= values[i];
  }
  return {lanes_.node(nodes_[node].lane + chosen), values[chosen] / sum,
          std::clamp(rest / values[chosen], 0.0f, kOneMinusEpsilon)};
}

template <class... Receiver>
LightTree::Choice LightTree::choose_for(uint32_t node, float u, const Receiver&... receiver) const {
  float pmf = 1.0f;
  while (!nodes_[node].leaf) {
    if (nodes_[node].parts > 0) {
      const Choice part = choose_part(node, u, receiver...);
      if (part.pmf == 0.0f) return part;
      node = part.light;
      pmf *= part.pmf;
      u = part.u_remapped;
      continue;
    }
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

uint32_t LightTree::part_of(uint32_t node, uint32_t leaf) const {
  uint32_t first = 0, end = nodes_[node].parts;
  while (end - first > 1) {
    const uint32_t middle = (first + end) / 2;
    (lanes_.node(nodes_[node].lane + middle) <= leaf ? first : end) = middle;
  }
  return first;
}

template <class... Receiver>
float LightTree::pmf_for(uint32_t top, uint32_t light, const Receiver&... receiver) const {
  if (!contains(light)) return 0.0f;
  float pmf = 1.0f;
  uint32_t node = 0, leaf = 0;
  bool below = top == 0, in_part = false;  // in_part: between a node with parts and its part, `part`
  uint32_t part = 0;
  for (uint64_t trail = trails_[light]; trail > 1; trail >>= 1) {
    const bool to_second = trail & 1;
    if (below && !in_part && nodes_[node].parts > 0) {
      if (leaf == 0) leaf = leaf_of(light);
      const uint32_t chosen = part_of(node, leaf);
      Importances values;
      const float sum = importances(node, values, receiver...);
      if (!(sum > 0.0f)) return 0.0f;
      pmf *= values[chosen] / sum;
      part = lanes_.node(nodes_[node].lane + chosen);
      if (part == leaf) return pmf;
      in_part = true;
    } else if (below && !in_part) {
      const float first = first_share(node, receiver...);
      if (first < 0.0f) return 0.0f;
      pmf *= to_second ? 1.0f - first : first;
    }
    node = to_second ? nodes_[node].second : node + 1;
    below |= node == top;
    in_part = in_part && node != part;
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
  const Vec3 d = Vec3(node.center) - p;
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
