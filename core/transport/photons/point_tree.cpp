#include "transport/photons/point_tree.h"

#include <algorithm>

#include <tbb/parallel_invoke.h>

namespace ajar {

namespace {

constexpr uint32_t kLeaf = 8;         // points; ranges of at most this length are searched in order
constexpr uint32_t kParallel = 8192;  // points; longer ranges are built by two tasks
constexpr uint32_t kAxisShift = 30;

/// Restores the heap below `root`: a parent is at least as far as its children.
void sift_down(PointTree::Neighbours& heap, int root) {
  const float distance2 = heap.distance2[root];
  const uint32_t index = heap.index[root];
  for (int child = 2 * root + 1; child < heap.count; child = 2 * root + 1) {
    if (child + 1 < heap.count && heap.distance2[child + 1] > heap.distance2[child]) ++child;
    if (!(heap.distance2[child] > distance2)) break;
    heap.distance2[root] = heap.distance2[child];
    heap.index[root] = heap.index[child];
    root = child;
  }
  heap.distance2[root] = distance2;
  heap.index[root] = index;
}

/// The axis direction that is closest to a normal: twice the axis, plus 1 for the negative direction.
int facing(Vec3 n) {
  const Vec3 a = glm::abs(n);
  const int axis = a.x >= a.y && a.x >= a.z ? 0 : (a.y >= a.z ? 1 : 2);
  return 2 * axis + (n[axis] < 0.0f ? 1 : 0);
}

/// Cosine between n and the nearest direction that has this facing.
float cosine_to(int facing, Vec3 n) {
  const int axis = facing / 2;
  const float along = (facing & 1) ? -n[axis] : n[axis];
  const float b = std::abs(n[(axis + 1) % 3]), c = std::abs(n[(axis + 2) % 3]), across = std::max(b, c),
              min_across = std::min(b, c);
  if (along >= across) return 1.0f;
  // The nearest direction is on the border `along = across`, or on its end `along = across = min_across`.
  const float middle = 0.5f * (along + across);
  return middle >= min_across ? std::sqrt(2.0f * middle * middle + min_across * min_across)
                              : (along + across + min_across) / std::sqrt(3.0f);
}

float sign_not_zero(float x) { return x < 0.0f ? -1.0f : 1.0f; }

/// The number of steps is even, so that the axes are represented exactly.
constexpr int half_steps(int bits) { return (1 << (bits - 1)) - 1; }

template <int Bits>
uint32_t pack(Vec3 d) {
  const float scale = 1.0f / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  float x = d.x * scale, y = d.y * scale;
  if (d.z < 0.0f) {
    const float fold_x = (1.0f - std::abs(y)) * sign_not_zero(x), fold_y = (1.0f - std::abs(x)) * sign_not_zero(y);
    x = fold_x;
    y = fold_y;
  }
  const auto quantise = [](float v) {
    return uint32_t(std::lround((std::clamp(v, -1.0f, 1.0f) + 1.0f) * float(half_steps(Bits))));
  };
  return quantise(x) | quantise(y) << Bits;
}

/// The packed direction with a length between 1/sqrt(3) and 1.
template <int Bits>
Vec3 unpack_unnormalised(uint32_t packed) {
  constexpr uint32_t kMask = (1u << Bits) - 1u;
  constexpr int kHalf = half_steps(Bits);
  const float x = float(int(packed & kMask) - kHalf) / float(kHalf),
              y = float(int(packed >> Bits & kMask) - kHalf) / float(kHalf);
  Vec3 d(x, y, 1.0f - std::abs(x) - std::abs(y));
  if (d.z < 0.0f) {
    d.x = (1.0f - std::abs(y)) * sign_not_zero(x);
    d.y = (1.0f - std::abs(x)) * sign_not_zero(y);
  }
  return d;
}

}  // namespace

uint32_t pack_direction(Vec3 d) { return pack<14>(d); }
uint32_t pack_direction_short(Vec3 d) { return pack<13>(d); }

Vec3 unpack_direction(uint32_t packed) { return glm::normalize(unpack_unnormalised<14>(packed)); }
Vec3 unpack_direction_short(uint32_t packed) { return glm::normalize(unpack_unnormalised<13>(packed)); }

namespace {

struct Builder {
  const SurfacePoint* points;
  uint32_t* order;
  uint8_t* axis;

  void split(uint32_t begin, uint32_t end) const {
    if (end - begin <= kLeaf) return;
    Vec3 lower(kInfinity), upper(-kInfinity);
    for (uint32_t i = begin; i != end; ++i) {
      lower = glm::min(lower, points[order[i]].position);
      upper = glm::max(upper, points[order[i]].position);
    }
    const Vec3 extent = upper - lower;
    const int a = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
    const uint32_t middle = begin + (end - begin) / 2;
    // Equal coordinates are ordered by index, so that the order depends neither on the algorithm nor on the threads.
    std::nth_element(order + begin, order + middle, order + end, [&](uint32_t i, uint32_t j) {
      const float x = points[i].position[a], y = points[j].position[a];
      return x < y || (x == y && i < j);
    });
    axis[middle] = uint8_t(a);
    if (end - begin > kParallel) {
      tbb::parallel_invoke([&] { split(begin, middle); }, [&] { split(middle + 1, end); });
    } else {
      split(begin, middle);
      split(middle + 1, end);
    }
  }
};

}  // namespace

void PointTree::build(std::vector<SurfacePoint> points, std::vector<uint32_t>& order) {
  const uint32_t n = uint32_t(points.size());
  order.resize(n);
  std::vector<uint8_t> axis(n, 0);
  std::vector<uint8_t> facings(n);
  uint32_t counts[kFacings] = {};
  for (uint32_t i = 0; i < n; ++i) ++counts[facings[i] = uint8_t(facing(unpack_direction(points[i].packed_normal)))];
  for (int f = 0; f < kFacings; ++f) begin_[f + 1] = begin_[f] + counts[f];
  uint32_t next[kFacings];
  std::copy(begin_, begin_ + kFacings, next);
  for (uint32_t i = 0; i < n; ++i) order[next[facings[i]]++] = i;
  const Builder builder{points.data(), order.data(), axis.data()};
  for (int f = 0; f < kFacings; ++f) builder.split(begin_[f], begin_[f + 1]);
  points_.resize(n);
  for (uint32_t i = 0; i < n; ++i) {
    points_[i] = points[order[i]];
    points_[i].packed_normal = (points_[i].packed_normal & ((1u << kAxisShift) - 1)) | uint32_t(axis[i]) << kAxisShift;
  }
}

/// Calls `visit(index, distance2)` for every point nearer than radius2. `visit` may reduce radius2.
template <class Visit>
void PointTree::search(Vec3 p, Vec3 normal, float& radius2, uint32_t not_side, Visit&& visit) const {
  struct Range {
    uint32_t begin, end;
    Vec3 offset;  // from p to the box between the splitting planes, for each axis
  };
  Range stack[40 + kFacings];
  int depth = 0;
  for (int f = 0; f < kFacings; ++f)
    if (begin_[f] < begin_[f + 1] && cosine_to(f, normal) > kMinNormalCosine - 1e-3f)
      stack[depth++] = {begin_[f], begin_[f + 1], Vec3(0.0f)};
  const float slab = std::sqrt(radius2) / (2.0f * kFlatness);
  const auto test = [&](uint32_t i) {
    const Vec3 offset = points_[i].position - p;
    const float outside = std::max(0.0f, std::abs(glm::dot(offset, normal)) - slab);
    const float distance2 = length_squared(offset) + (kSteepness * kSteepness - 1.0f) * outside * outside;
    if (!(distance2 < radius2)) return;
    if (points_[i].packed_normal & not_side) return;
    const Vec3 facing = unpack_unnormalised<14>(points_[i].packed_normal);
    const float cosine = glm::dot(facing, normal);
    if (!(cosine > 0.0f) || cosine * cosine < kMinNormalCosine * kMinNormalCosine * length_squared(facing)) return;
    visit(i, distance2);
  };
  while (depth > 0) {
    Range range = stack[--depth];
    if (!(length_squared(range.offset) < radius2)) continue;
    while (range.end - range.begin > kLeaf) {
      const uint32_t middle = range.begin + (range.end - range.begin) / 2;
      const int axis = int(points_[middle].packed_normal >> kAxisShift);
      const float offset = p[axis] - points_[middle].position[axis];
      test(middle);
      Range& other = stack[depth++];
      other.offset = range.offset;
      other.offset[axis] = offset;
      if (offset < 0.0f) {
        other.begin = middle + 1, other.end = range.end;
        range.end = middle;
      } else {
        other.begin = range.begin, other.end = middle;
        range.begin = middle + 1;
      }
    }
    for (uint32_t i = range.begin; i != range.end; ++i) test(i);
  }
}

void PointTree::nearest(Vec3 p, Vec3 normal, int k, float radius, Neighbours& found, uint32_t not_side) const {
  found.count = 0;
  found.radius2 = radius * radius;
  if (points_.empty()) return;
  search(p, normal, found.radius2, not_side, [&](uint32_t i, float distance2) {
    if (found.count < k) {
      found.index[found.count] = i;
      found.distance2[found.count++] = distance2;
      if (found.count < k) return;
      // The list is full. From here on it is a heap with the furthest point as its root.
      for (int root = k / 2 - 1; root >= 0; --root) sift_down(found, root);
    } else {
      found.index[0] = i;
      found.distance2[0] = distance2;
      sift_down(found, 0);
    }
    found.radius2 = found.distance2[0];
  });
  if (found.count == k) {
    // The k-th point defines the radius and is excluded.
    --found.count;
    found.index[0] = found.index[found.count];
    found.distance2[0] = found.distance2[found.count];
  }
}

int PointTree::nearest(Vec3 p, Vec3 normal, float radius) const {
  if (points_.empty()) return -1;
  int best = -1;
  float radius2 = radius * radius;
  search(p, normal, radius2, 0, [&](uint32_t i, float distance2) {
    best = int(i);
    radius2 = distance2;
  });
  return best;
}

}  // namespace ajar
