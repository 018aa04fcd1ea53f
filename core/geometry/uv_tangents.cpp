#include "geometry/uv_tangents.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <tuple>

namespace ajar {

namespace {

constexpr int kNone = -1;

bool is_significant(float x) { return std::abs(x) > FLT_MIN; }

Vec3 unit_or_zero(Vec3 v) {
  const float length = std::sqrt(length_squared(v));
  return is_significant(length) ? v / length : Vec3(0.0f);
}

Vec3 in_plane(Vec3 v, Vec3 normal) { return unit_or_zero(v - normal * glm::dot(normal, v)); }

/// Coordinates of a mesh without a UV map.
Vec2 on_sphere(Vec3 p) {
  const float length = std::sqrt(length_squared(p));
  if (!(length > 0.0f)) return Vec2(0.0f);
  const float u = p.x == 0.0f && p.y == 0.0f ? 0.0f : 0.5f - std::atan2(p.x, p.y) / (2.0f * kPi);
  return {u, 1.0f - std::acos(glm::clamp(p.z / length, -1.0f, 1.0f)) * kInvPi};
}

class TangentSpace {
 public:
  TangentSpace(std::span<const Vec3> positions, std::span<const UVec3> triangles, std::span<const Vec3> normals,
               std::span<const Vec2> uvs)
      : positions_(positions), triangles_(triangles), normals_(normals), uvs_(uvs), count_(int(triangles.size())) {}

  std::vector<Vec4> compute() {
    weld();
    derive();
    connect();
    group();
    return average();
  }

 private:
  struct Triangle {
    Vec3 tangent{0.0f};
    bool positive = false;                             ///< its orientation in the UV map
    bool without_uv = true;                            ///< it has no area there
    bool degenerate = false;                           ///< two of its corners have the same position
    std::array<int, 3> neighbor{kNone, kNone, kNone};  ///< across the edge from corner k to corner k + 1
  };
  struct Group {
    int vertex;
    bool positive;
    Vec3 sum{0.0f};
  };

  Vec3 position(int corner) const { return positions_[triangles_[size_t(corner / 3)][corner % 3]]; }
  Vec2 uv(int corner) const { return uvs_.empty() ? on_sphere(position(corner)) : uvs_[size_t(corner)]; }

  /// Numbers the vertices: the first corner of all equal ones.
  void weld() {
    const size_t corners = 3 * triangles_.size();
    using Key = std::array<float, 8>;
    const auto key_of = [&](int corner) {
      const Vec3 p = position(corner), n = normals_[size_t(corner)];
      const Vec2 t = uv(corner);
      Key key{p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y};
      for (float& x : key) x += 0.0f;  // -0 equals 0
      return key;
    };
    std::vector<int> table(std::bit_ceil(2 * corners + 1), kNone);
    vertex_.resize(corners);
    for (int corner = 0; corner < int(corners); ++corner) {
      const Key key = key_of(corner);
      uint64_t hash = 0x9e3779b97f4a7c15u;
      for (const float x : key) {
        hash = (hash ^ std::bit_cast<uint32_t>(x)) * 0xff51afd7ed558ccdu;
        hash ^= hash >> 32;
      }
      size_t place = hash & (table.size() - 1);
      while (table[place] != kNone && key_of(table[place]) != key) place = (place + 1) & (table.size() - 1);
      if (table[place] == kNone) table[place] = corner;
      vertex_[size_t(corner)] = table[place];
    }
  }

  /// The derivative of the position along u of each triangle.
  void derive() {
    parts_.resize(triangles_.size());
    for (int t = 0; t < count_; ++t) {
      Triangle& part = parts_[size_t(t)];
      const Vec3 p0 = position(3 * t), p1 = position(3 * t + 1), p2 = position(3 * t + 2);
      part.degenerate = p0 == p1 || p1 == p2 || p2 == p0;
      const Vec2 a = uv(3 * t + 1) - uv(3 * t), b = uv(3 * t + 2) - uv(3 * t);
      const float area = a.x * b.y - a.y * b.x;
      part.positive = area > 0.0f;
      if (!is_significant(area)) continue;
      const Vec3 along_u = b.y * (p1 - p0) - a.y * (p2 - p0), along_v = a.x * (p2 - p0) - b.x * (p1 - p0);
      const float u = std::sqrt(length_squared(along_u)), v = std::sqrt(length_squared(along_v));
      if (is_significant(u)) part.tangent = along_u * ((part.positive ? 1.0f : -1.0f) / u);
      part.without_uv = !is_significant(u / std::abs(area)) || !is_significant(v / std::abs(area));
    }
  }

  /// Finds the neighbours of each triangle. An edge connects two triangles that pass along it in opposite directions.
  void connect() {
    struct Edge {
      int low, high, triangle, side;
      bool upwards;
      bool operator<(const Edge& other) const {
        return std::tie(low, high, triangle) < std::tie(other.low, other.high, other.triangle);
      }
    };
    std::vector<Edge> edges;
    edges.reserve(3 * triangles_.size());
    for (int t = 0; t < count_; ++t)
      for (int k = 0; k < 3 && !parts_[size_t(t)].degenerate; ++k) {
        const int a = vertex_[size_t(3 * t + k)], b = vertex_[size_t(3 * t + (k + 1) % 3)];
        edges.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
      }
    std::sort(edges.begin(), edges.end());
    const auto neighbor = [&](const Edge& e) -> int& { return parts_[size_t(e.triangle)].neighbor[size_t(e.side)]; };
    for (size_t i = 0; i < edges.size(); ++i) {
      if (neighbor(edges[i]) != kNone) continue;
      for (size_t j = i + 1; j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high; ++j) {
        if (edges[j].upwards == edges[i].upwards || neighbor(edges[j]) != kNone) continue;
        neighbor(edges[i]) = edges[j].triangle;
        neighbor(edges[j]) = edges[i].triangle;
        break;
      }
    }
  }

  /// Assigns each corner to a group.
  void group() {
    group_.assign(vertex_.size(), kNone);
    std::vector<int> open;
    for (int corner = 0; corner < int(vertex_.size()); ++corner) {
      const Triangle& first = parts_[size_t(corner / 3)];
      if (first.degenerate || first.without_uv || group_[size_t(corner)] != kNone) continue;
      const int number = int(groups_.size()), vertex = vertex_[size_t(corner)];
      groups_.push_back({vertex, first.positive});
      open.assign(1, corner / 3);
      while (!open.empty()) {
        const int t = open.back();
        open.pop_back();
        int k = 0;
        while (k < 3 && vertex_[size_t(3 * t + k)] != vertex) ++k;
        if (k == 3 || group_[size_t(3 * t + k)] != kNone) continue;
        Triangle& part = parts_[size_t(t)];
        const bool is_free = group_[size_t(3 * t)] == kNone && group_[size_t(3 * t + 1)] == kNone &&
                             group_[size_t(3 * t + 2)] == kNone;
        if (part.without_uv && is_free) part.positive = groups_.back().positive;
        if (part.positive != groups_.back().positive) continue;
        group_[size_t(3 * t + k)] = number;
        for (const int side : {(k + 2) % 3, k})  // the last one is continued first
          if (part.neighbor[size_t(side)] != kNone) open.push_back(part.neighbor[size_t(side)]);
      }
    }
  }

  std::vector<Vec4> average() {
    for (int corner = 0; corner < int(vertex_.size()); ++corner) {
      const Triangle& part = parts_[size_t(corner / 3)];
      if (group_[size_t(corner)] == kNone || part.without_uv) continue;
      const int t = corner / 3 * 3, k = corner - t;
      const Vec3 normal = normals_[size_t(corner)], p = position(corner);
      const Vec3 before = in_plane(position(t + (k + 2) % 3) - p, normal);
      const Vec3 after = in_plane(position(t + (k + 1) % 3) - p, normal);
      groups_[size_t(group_[size_t(corner)])].sum += std::acos(glm::clamp(glm::dot(before, after), -1.0f, 1.0f)) *
                                                     in_plane(part.tangent, normal);
    }
    std::vector<Vec4> tangents(vertex_.size(), Vec4(1.0f, 0.0f, 0.0f, -1.0f));
    std::vector<int> any_corner(vertex_.size(), kNone);  // with a group, of each vertex; for degenerate triangles
    for (size_t corner = 0; corner < vertex_.size(); ++corner) {
      if (group_[corner] == kNone) continue;
      const Group& group = groups_[size_t(group_[corner])];
      tangents[corner] = Vec4(unit_or_zero(group.sum), group.positive ? 1.0f : -1.0f);
      int& any = any_corner[size_t(vertex_[corner])];
      if (any == kNone) any = int(corner);
    }
    for (size_t corner = 0; corner < vertex_.size(); ++corner)
      if (const int any = any_corner[size_t(vertex_[corner])]; parts_[corner / 3].degenerate && any != kNone)
        tangents[corner] = tangents[size_t(any)];
    return tangents;
  }

  std::span<const Vec3> positions_;
  std::span<const UVec3> triangles_;
  std::span<const Vec3> normals_;
  std::span<const Vec2> uvs_;
  int count_;
  std::vector<int> vertex_;  ///< of each corner
  std::vector<Triangle> parts_;
  std::vector<int> group_;  ///< of each corner, or kNone
  std::vector<Group> groups_;
};

}  // namespace

std::vector<Vec4> uv_tangents(std::span<const Vec3> positions, std::span<const UVec3> triangles,
                              std::span<const Vec3> normals, std::span<const Vec2> uvs) {
  return TangentSpace(positions, triangles, normals, uvs).compute();
}

}  // namespace ajar
