#include "transport/point_tree.h"

#include <algorithm>
#include <numeric>

#include <tbb/parallel_invoke.h>

namespace ajar {

namespace {

constexpr uint32_t kLeaf = 8;             // points; ranges up to this long are searched in order
constexpr uint32_t kParallel = 8192;      // points; longer ranges are built by two tasks
constexpr uint32_t kAxisShift = 30;

/// Restore the heap below `root`: a parent is no nearer than its children.
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

float sign_not_zero(float x) { return x < 0.0f ? -1.0f : 1.0f; }

}  // namespace

uint32_t pack_direction(Vec3 d) {
  const float scale = 1.0f / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  float x = d.x * scale, y = d.y * scale;
  if (d.z < 0.0f) {
    const float fold_x = (1.0f - std::abs(y)) * sign_not_zero(x), fold_y = (1.0f - std::abs(x)) * sign_not_zero(y);
    x = fold_x;
    y = fold_y;
  }
  // An even number of steps, so that the axes are represented exactly.
  const auto quantise = [](float v) { return uint32_t(std::lround((std::clamp(v, -1.0f, 1.0f) + 1.0f) * 16383.0f)); };
  return quantise(x) | quantise(y) << 15;
}

Vec3 unpack_direction(uint32_t packed) {
  const float x = float(int(packed & 0x7fffu) - 16383) / 16383.0f, y = float(int(packed >> 15 & 0x7fffu) - 16383) / 16383.0f;
  Vec3 d(x, y, 1.0f - std::abs(x) - std::abs(y));
  if (d.z < 0.0f) {
    d.x = (1.0f - std::abs(y)) * sign_not_zero(x);
    d.y = (1.0f - std::abs(x)) * sign_not_zero(y);
  }
  return glm::normalize(d);
}

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
    // Ties go by index: one order only, whatever the algorithm and the threads do.
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
  std::iota(order.begin(), order.end(), 0u);
  std::vector<uint8_t> axis(n, 0);
  Builder{points.data(), order.data(), axis.data()}.split(0, n);
  points_.resize(n);
  for (uint32_t i = 0; i < n; ++i) {
    points_[i] = points[order[i]];
    points_[i].packed_normal = (points_[i].packed_normal & ((1u << kAxisShift) - 1)) | uint32_t(axis[i]) << kAxisShift;
  }
}

/// Calls `visit(index, distance2)` for every point nearer than radius2, which visit may shrink.
template <class Visit>
void PointTree::search(Vec3 p, Vec3 normal, float& radius2, Visit&& visit) const {
  struct Range {
    uint32_t begin, end;
    float distance2;      // of the splitting plane; the range may be left out when it is further
  };
  Range stack[40];
  int depth = 0;
  stack[depth++] = {0, uint32_t(points_.size()), 0.0f};
  const auto test = [&](uint32_t i) {
    const Vec3 offset = points_[i].position - p;
    const float along = glm::dot(offset, normal);
    const float distance2 = length_squared(offset) + (kFlatness * kFlatness - 1.0f) * along * along;
    if (!(distance2 < radius2)) return;
    if (glm::dot(unpack_direction(points_[i].packed_normal), normal) < kMinNormalCosine) return;
    visit(i, distance2);
  };
  while (depth > 0) {
    Range range = stack[--depth];
    if (!(range.distance2 < radius2)) continue;
    while (range.end - range.begin > kLeaf) {
      const uint32_t middle = range.begin + (range.end - range.begin) / 2;
      const int axis = int(points_[middle].packed_normal >> kAxisShift);
      const float offset = p[axis] - points_[middle].position[axis];
      test(middle);
      if (offset < 0.0f) {
        stack[depth++] = {middle + 1, range.end, offset * offset};
        range.end = middle;
      } else {
        stack[depth++] = {range.begin, middle, offset * offset};
        range.begin = middle + 1;
      }
    }
    for (uint32_t i = range.begin; i != range.end; ++i) test(i);
  }
}

void PointTree::nearest(Vec3 p, Vec3 normal, int k, float radius, Neighbours& found) const {
  found.count = 0;
  found.radius2 = radius * radius;
  if (points_.empty()) return;
  search(p, normal, found.radius2, [&](uint32_t i, float distance2) {
    if (found.count < k) {
      found.index[found.count] = i;
      found.distance2[found.count++] = distance2;
      if (found.count < k) return;
      // Full: from now on a heap, its root the furthest.
      for (int root = k / 2 - 1; root >= 0; --root) sift_down(found, root);
    } else {
      found.index[0] = i;
      found.distance2[0] = distance2;
      sift_down(found, 0);
    }
    found.radius2 = found.distance2[0];
  });
  if (found.count == k) {
    // The k-th marks the edge and is not inside.
    --found.count;
    found.index[0] = found.index[found.count];
    found.distance2[0] = found.distance2[found.count];
  }
}

int PointTree::nearest(Vec3 p, Vec3 normal, float radius) const {
  if (points_.empty()) return -1;
  int best = -1;
  float radius2 = radius * radius;
  search(p, normal, radius2, [&](uint32_t i, float distance2) {
    best = int(i);
    radius2 = distance2;
  });
  return best;
}

}  // namespace ajar
