#include "geometry/mesh_analysis.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <numeric>
#include <utility>

#include "math/hash.h"

namespace ajar {
namespace {

/// Disjoint sets (union by rank, path halving). The representative of a set depends on the order of the joins.
class DisjointSets {
 public:
  explicit DisjointSets(size_t count) : parent_(count), rank_(count, 0) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  uint32_t find(uint32_t x) {
    while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
    return x;
  }
  void join(uint32_t a, uint32_t b) {
    a = find(a), b = find(b);
    if (a == b) return;
    if (rank_[a] < rank_[b]) std::swap(a, b);
    parent_[b] = a;
    if (rank_[a] == rank_[b]) ++rank_[a];
  }

 private:
  std::vector<uint32_t> parent_;
  std::vector<uint8_t> rank_;
};

/// Two vertices are welded if their squared distance and the difference of their sums of coordinates are below these.
constexpr float kSamePlaceSquared = FLT_EPSILON, kSameSum = 3.0f * FLT_EPSILON;

float sum_of(Vec3 p) { return p.x + p.y + p.z; }

/// For each vertex the representative of all vertices at its position.
std::vector<uint32_t> welded(std::span<const Vec3> positions) {
  const float reach = std::sqrt(kSamePlaceSquared);
  std::vector<uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return std::pair(sum_of(positions[a]), a) < std::pair(sum_of(positions[b]), b);
  });
  DisjointSets places(positions.size());
  for (size_t begin = 0, end; begin < order.size(); begin = end) {
    // A range of vertices whose sums follow each other closely. It is sorted by x, so that many vertices with equal
    // sums cost little.
    for (end = begin + 1;
         end < order.size() && sum_of(positions[order[end]]) - sum_of(positions[order[end - 1]]) <= kSameSum;)
      ++end;
    std::sort(order.begin() + begin, order.begin() + end,
              [&](uint32_t a, uint32_t b) { return std::pair(positions[a].x, a) < std::pair(positions[b].x, b); });
    for (size_t i = begin; i < end; ++i) {
      const Vec3 p = positions[order[i]];
      for (size_t k = i + 1; k < end && positions[order[k]].x - p.x < reach; ++k) {
        const Vec3 q = positions[order[k]];
        if (std::abs(sum_of(q) - sum_of(p)) <= kSameSum && length_squared(q - p) < kSamePlaceSquared)
          places.join(order[i], order[k]);
      }
    }
  }
  std::vector<uint32_t> standing(positions.size());
  for (uint32_t v = 0; v < positions.size(); ++v) standing[v] = places.find(v);
  return standing;
}

/// Each pair of connected welded vertices once.
std::vector<std::pair<uint32_t, uint32_t>> distinct(std::span<const MeshEdge> edges,
                                                    const std::vector<uint32_t>& standing) {
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  pairs.reserve(edges.size());
  for (const MeshEdge edge : edges) {
    if (edge.x >= standing.size() || edge.y >= standing.size()) continue;
    const auto [low, high] = std::minmax(standing[edge.x], standing[edge.y]);
    if (low != high) pairs.emplace_back(low, high);
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

Vec3 direction_of(Vec3 v) {
  const float length = glm::length(v);
  return length > 0.0f ? v / length : Vec3(0.0f);
}

}  // namespace

std::vector<float> random_per_island(size_t vertex_count, std::span<const MeshEdge> edges) {
  DisjointSets islands(vertex_count);
  for (const MeshEdge edge : edges)
    if (edge.x < vertex_count && edge.y < vertex_count) islands.join(edge.x, edge.y);
  std::vector<float> random(vertex_count);
  for (uint32_t v = 0; v < vertex_count; ++v) {
    const uint32_t key[] = {islands.find(v)};
    random[v] = float(nodes::hash_words(key)) * 0x1p-32f;
  }
  return random;
}

std::vector<float> pointiness(std::span<const Vec3> positions, std::span<const Vec3> normals,
                              std::span<const MeshEdge> edges) {
  const size_t count = std::min(positions.size(), normals.size());
  positions = positions.first(count);
  const std::vector<uint32_t> standing = welded(positions);
  const auto pairs = distinct(edges, standing);

  std::vector<Vec3> normal(count, Vec3(0.0f)), towards(count, Vec3(0.0f));
  std::vector<uint32_t> neighbours(count, 0);
  for (size_t v = 0; v < count; ++v) normal[standing[v]] += normals[v];
  for (const auto& [a, b] : pairs) {
    const Vec3 edge = direction_of(positions[b] - positions[a]);
    towards[a] += edge, towards[b] -= edge;
    ++neighbours[a], ++neighbours[b];
  }
  std::vector<float> angle(count, 0.0f);
  for (size_t v = 0; v < count; ++v) {
    if (neighbours[v] == 0) continue;
    const float cosine = glm::dot(direction_of(normal[v]), towards[v] / float(neighbours[v]));
    angle[v] = std::acos(glm::clamp(cosine, -1.0f, 1.0f)) * kInvPi;
  }
  std::vector<float> blurred = angle;
  for (const auto& [a, b] : pairs) blurred[a] += angle[b], blurred[b] += angle[a];
  std::vector<float> result(count);
  for (size_t v = 0; v < count; ++v) result[v] = blurred[standing[v]] / float(neighbours[standing[v]] + 1);
  return result;
}

}  // namespace ajar
