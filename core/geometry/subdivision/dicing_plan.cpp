#include "geometry/subdivision/dicing_plan.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace ajar {

namespace {

constexpr int kUneven = 0;  // the pieces of an edge whose halves have their own
constexpr int kMaxDepth = 40;
constexpr float kMaxRatio = 1.5f;  // of the numbers of pieces of opposite sides
constexpr int kManyPieces = 8;     // below, the ratio does not matter

class Planner {
 public:
  Planner(const SubdivisionDescription& subdivision, std::span<const SurfacePatch> patches, const LimitSurface& surface,
          const DicingRate& rate)
      : s_(subdivision), patches_(patches), surface_(surface), rate_(rate) {}

  DicingPlan run() {
    vertex_of_corner_.reserve(s_.face_sizes.size());
    for (uint32_t i = 0; i < patches_.size(); i += patches_[i].whole() ? 1 : patches_[i].size) {
      divide_face(i);
      if (plan_.parts.size() > rate_.max_triangles) {
        plan_.is_complete = false;
        return std::move(plan_);
      }
    }
    number();
    return std::move(plan_);
  }

 private:
  uint32_t vertex_at(const SurfacePatch& patch, uint32_t k) const {
    return s_.corner_vertices[patch.first_corner + k % patch.size];
  }
  static uint64_t key(uint32_t a, uint32_t b) { return uint64_t(std::min(a, b)) << 32 | std::max(a, b); }

  uint32_t new_point(PatchPoint point) {
    plan_.points.push_back(point);
    return uint32_t(plan_.points.size() - 1);
  }
  /// The diced vertex of a vertex of the mesh.
  uint32_t corner_point(uint32_t vertex, PatchPoint point) {
    const auto [found, is_new] = vertex_of_corner_.try_emplace(vertex, kNoVertex);
    if (is_new) found->second = new_point(point);
    return found->second;
  }

  /// Longest allowed number of pieces between two points of a patch.
  int most_pieces(const DicedEdge& edge) const {
    const float whole = std::ldexp(1.0f, rate_.max_subdivisions - (patches_[edge.patch].whole() ? 0 : 1));
    return std::max(1, int(whole * glm::length(edge.to - edge.from)));
  }

  /// The number of pieces of an edge, or kUneven.
  int count_pieces(const DicedEdge& edge) const {
    constexpr int kTests = 2;
    Vec3 p[kTests + 1];
    for (int i = 0; i <= kTests; ++i)
      p[i] = surface_.position({edge.patch, edge.from + (edge.to - edge.from) * (float(i) / kTests)});
    float fewest = 0.0f, most = 0.0f;
    const auto measure = [&](const Vec3* at) {
      float sum = 0.0f, longest = 0.0f;
      for (int i = 0; i < kTests; ++i) {
        const float size = rate_.pixels ? rate_.pixels->at(0.5f * (at[i] + at[i + 1])) : 1.0f;
        const float length = glm::length(at[i + 1] - at[i]) / size;
        sum += length;
        longest = std::max(longest, length);
      }
      fewest = std::max(fewest, std::ceil(sum / rate_.edge_length));
      most = std::max(most, std::ceil(float(kTests) * longest / rate_.edge_length));
    };
    if (!rate_.pixels) {
      measure(p);
    } else {
      for (const Mat4& matrix : rate_.world_from_object) {
        const Vec3 at[kTests + 1] = {transform_point(matrix, p[0]), transform_point(matrix, p[1]),
                                     transform_point(matrix, p[2])};
        measure(at);
      }
    }
    const int limit = most_pieces(edge);
    if (limit <= 1 || !(most > 1.0f)) return 1;
    if (most - fewest > 1.0f) return kUneven;
    return int(std::min(most, float(limit)));
  }

  uint32_t new_edge(uint32_t start, uint32_t end, uint32_t patch, Vec2 from, Vec2 to) {
    DicedEdge edge;
    edge.start = start;
    edge.end = end;
    edge.patch = patch;
    edge.from = from;
    edge.to = to;
    edge.pieces = count_pieces(edge);
    plan_.edges.push_back(edge);
    return uint32_t(plan_.edges.size() - 1);
  }

  /// Gives an edge its halves, at a vertex near its middle.
  void halve(uint32_t index) {
    const DicedEdge edge = plan_.edges[index];
    if (edge.first_half >= 0) return;
    const int before = edge.pieces / 2;
    const float split = edge.pieces == kUneven ? 0.5f : float(before) / float(edge.pieces);
    const Vec2 at = edge.from + (edge.to - edge.from) * split;
    const uint32_t middle = new_point({edge.patch, at});
    const auto half = [&](uint32_t start, uint32_t end, Vec2 from, Vec2 to, int pieces) {
      if (edge.pieces == kUneven) {
        new_edge(start, end, edge.patch, from, to);
        return;
      }
      DicedEdge part;
      part.start = start;
      part.end = end;
      part.patch = edge.patch;
      part.from = from;
      part.to = to;
      part.pieces = pieces;
      plan_.edges.push_back(part);
    };
    plan_.edges[index].first_half = int(plan_.edges.size());
    plan_.edges[index].split = split;
    half(edge.start, middle, edge.from, at, before);
    half(middle, edge.end, at, edge.to, edge.pieces - before);
  }

  /// Halves an edge until all pieces are counted.
  void settle(uint32_t index) {
    if (plan_.edges[index].pieces == kUneven) halve(index);
    const int first = plan_.edges[index].first_half;
    if (first < 0) return;
    settle(uint32_t(first));
    settle(uint32_t(first) + 1);
  }

  /// A quarter of a face: from one of its corners to the middle of the next edge, the middle of the face, and the middle
  /// of the previous edge.
  struct Quarter {
    uint32_t patch;
    Vec2 corners[4];
  };
  Quarter quarter_of_face(uint32_t first, uint32_t k) const {
    if (!patches_[first].whole()) return {first + k, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    constexpr Vec2 kCorners[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const Vec2 here = kCorners[k], next = kCorners[(k + 1) % 4], previous = kCorners[(k + 3) % 4];
    return {first, {here, 0.5f * (here + next), Vec2(0.5f), 0.5f * (previous + here)}};
  }

  /// Divides a face into quarters, one for each corner, which meet at its middle, and these further. Faces with four
  /// corners too: each of their edges has at least two pieces, as in Cycles.
  void divide_face(uint32_t first) {
    const uint32_t size = patches_[first].size;
    std::vector<Quarter> quarters(size);
    for (uint32_t k = 0; k < size; ++k) quarters[k] = quarter_of_face(first, k);
    const uint32_t centre = new_point({quarters[0].patch, quarters[0].corners[2]});
    std::vector<SideOfPart> halves(2 * size);  // of each edge of the face, in its direction
    std::vector<uint32_t> middles(size), spokes(size);
    for (uint32_t k = 0; k < size; ++k) {
      const Quarter &here = quarters[k], &next = quarters[(k + 1) % size];
      const uint32_t a = vertex_at(patches_[first], k), b = vertex_at(patches_[first], k + 1);
      const uint32_t start = corner_point(a, {here.patch, here.corners[0]});
      const uint32_t end = corner_point(b, {next.patch, next.corners[0]});
      const auto [found, is_new] = edges_.try_emplace(key(a, b), 0);
      if (is_new) found->second = new_halved_edge(here, next, start, end);
      const DicedEdge& edge = plan_.edges[found->second];
      const bool reversed = edge.start != start;
      const uint32_t half = uint32_t(edge.first_half);
      halves[2 * k] = {half + (reversed ? 1 : 0), reversed};
      halves[2 * k + 1] = {half + (reversed ? 0 : 1), reversed};
      middles[k] = plan_.edges[half].end;
      spokes[k] = new_edge(middles[k], centre, here.patch, here.corners[1], here.corners[2]);
    }
    for (uint32_t k = 0; k < size; ++k) {
      const uint32_t previous = (k + size - 1) % size;
      DicedPart part;
      part.patch = quarters[k].patch;
      std::copy_n(quarters[k].corners, 4, part.corners);
      part.sides[0] = halves[2 * k];
      part.sides[1] = {spokes[k], false};
      part.sides[2] = {spokes[previous], true};
      part.sides[3] = halves[2 * previous + 1];
      divide(part, 0);
    }
  }

  /// The edge of a face between the corners of two quarters. Its halves have their own pieces.
  uint32_t new_halved_edge(const Quarter& here, const Quarter& next, uint32_t start, uint32_t end) {
    DicedEdge edge;
    edge.start = start;
    edge.end = end;
    edge.patch = here.patch;
    edge.pieces = kUneven;
    const uint32_t index = uint32_t(plan_.edges.size());
    edge.first_half = int(index) + 1;
    plan_.edges.push_back(edge);
    const uint32_t middle = new_point({here.patch, here.corners[1]});
    new_edge(start, middle, here.patch, here.corners[0], here.corners[1]);
    new_edge(middle, end, next.patch, next.corners[3], next.corners[0]);
    return index;
  }

  bool is_uneven(const SideOfPart& side) const { return plan_.edges[side.edge].pieces == kUneven; }
  bool can_halve(const SideOfPart& side) const {
    const DicedEdge& edge = plan_.edges[side.edge];
    return edge.first_half >= 0 || edge.pieces == kUneven || edge.pieces >= 2;
  }

  /// Whether a part should be divided across its sides k and k + 2.
  bool should_cut(const DicedPart& part, int k) const {
    if (is_uneven(part.sides[k]) || is_uneven(part.sides[k + 2])) return true;
    // Sides of very different lengths in the other direction: the longer one would decide for the whole part.
    const SideOfPart &a = part.sides[1 - k], &b = part.sides[3 - k];
    if (is_uneven(a) || is_uneven(b)) return false;
    const int fewest = std::min(plan_.edges[a.edge].pieces, plan_.edges[b.edge].pieces);
    const int most = std::max(plan_.edges[a.edge].pieces, plan_.edges[b.edge].pieces);
    return fewest > kManyPieces && float(most) > kMaxRatio * float(fewest);
  }

  /// Divides a part until each of its sides has pieces of about the same size.
  void divide(DicedPart part, int depth) {
    bool cut[2];
    for (int k = 0; k < 2; ++k)
      cut[k] = depth < kMaxDepth && should_cut(part, k) && can_halve(part.sides[k]) && can_halve(part.sides[k + 2]);
    if (!cut[0] && !cut[1]) {
      for (const SideOfPart& side : part.sides) settle(side.edge);
      plan_.parts.push_back(part);
      return;
    }
    const int across = cut[0] && cut[1] ? depth % 2 : cut[0] ? 0 : 1;
    // The corners in an order in which the sides to cut are the first and the third.
    const auto corner = [&](int k) { return part.corners[(k + across) % 4]; };
    const SideOfPart low = part.sides[across], high = part.sides[across + 2];
    Vec2 at[2];
    uint32_t ends[2];
    SideOfPart before[2], after[2];
    const SideOfPart cuts[2] = {low, high};
    for (int i = 0; i < 2; ++i) {
      const SideOfPart& side = cuts[i];
      halve(side.edge);
      const DicedEdge& edge = plan_.edges[side.edge];
      const uint32_t first = uint32_t(edge.first_half);
      const float split = side.reversed ? 1.0f - edge.split : edge.split;
      at[i] = corner(2 * i) + (corner(2 * i + 1) - corner(2 * i)) * split;
      ends[i] = plan_.edges[first].end;
      before[i] = {side.reversed ? first + 1 : first, side.reversed};
      after[i] = {side.reversed ? first : first + 1, side.reversed};
    }
    const uint32_t between = new_edge(ends[0], ends[1], part.patch, at[0], at[1]);
    DicedPart left, right;
    left.patch = right.patch = part.patch;
    const Vec2 left_corners[4] = {corner(0), at[0], at[1], corner(3)};
    const Vec2 right_corners[4] = {at[0], corner(1), corner(2), at[1]};
    const SideOfPart left_sides[4] = {before[0], {between, false}, after[1], part.sides[(across + 3) % 4]};
    const SideOfPart right_sides[4] = {after[0], part.sides[across + 1], before[1], {between, true}};
    // In the original order, so that the depth decides about the direction of the next cut.
    for (int k = 0; k < 4; ++k) {
      const int to = (k + across) % 4;
      left.corners[to] = left_corners[k];
      right.corners[to] = right_corners[k];
      left.sides[to] = left_sides[k];
      right.sides[to] = right_sides[k];
    }
    divide(left, depth + 1);
    divide(right, depth + 1);
  }

  /// Gives vertices their numbers.
  void number() {
    plan_.vertices = plan_.points.size();
    for (DicedEdge& edge : plan_.edges) {
      if (edge.first_half >= 0) continue;
      edge.inner = uint32_t(plan_.vertices);
      plan_.vertices += size_t(std::max(0, edge.pieces - 1));
    }
    for (DicedPart& part : plan_.parts) {
      int pieces[4];
      for (int k = 0; k < 4; ++k) pieces[k] = plan_.pieces_of(part.sides[k]);
      const size_t mu = size_t(std::max(pieces[0], pieces[2])), mv = size_t(std::max(pieces[1], pieces[3]));
      part.first_inner = uint32_t(plan_.vertices);
      part.first_triangle = plan_.triangles;
      plan_.vertices += (mu - 1) * (mv - 1);
      if (mv == 1)
        plan_.triangles += size_t(pieces[0] + pieces[2]);
      else if (mu == 1)
        plan_.triangles += size_t(pieces[1] + pieces[3]);
      else
        plan_.triangles += 2 * (mu - 2) * (mv - 2) + 2 * (mu + mv - 4) +
                           size_t(pieces[0] + pieces[1] + pieces[2] + pieces[3]);
    }
    plan_.is_complete = plan_.triangles <= rate_.max_triangles && plan_.vertices < kNoVertex;
  }

  const SubdivisionDescription& s_;
  const std::span<const SurfacePatch> patches_;
  const LimitSurface& surface_;
  const DicingRate& rate_;
  DicingPlan plan_;
  std::unordered_map<uint64_t, uint32_t> edges_;             // of the faces, by their vertices
  std::unordered_map<uint32_t, uint32_t> vertex_of_corner_;  // of vertices of the mesh
};

}  // namespace

DicingPlan plan_dicing(const SubdivisionDescription& subdivision, std::span<const SurfacePatch> patches,
                       const LimitSurface& surface, const DicingRate& rate) {
  return Planner(subdivision, patches, surface, rate).run();
}

}  // namespace ajar
