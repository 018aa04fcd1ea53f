// Nearest-neighbour search for points on surfaces: a kd-tree in one flat array.
//
// There is one tree for each of the six axis directions. A point belongs to the tree of the direction that is closest
// to its normal, and a lookup skips the trees whose points cannot match its normal. In each tree the point in the
// middle of a range splits it: the points before it are on the low side, the points after it on the high side. The tree
// therefore needs no pointers and no nodes, and takes 16 bytes per point. Ranges of a few points are searched in order.
// The trees are built in parallel. Equal input gives an equal tree for any number of threads.
//
// A lookup finds the points in a ball that is cut by a slab around the plane of the query, so that it is nearly a disc
// [Jensen 2001, section 7.2.2]. The slab reaches 1/8 of the lookup's maximum radius above and below the plane. Heights
// beyond it count `kSteepness` times. Within the slab, distance is that in space: a ball around a point of a sphere
// contains exactly the area pi r^2 of the sphere, so that density estimates on curved surfaces are not too dark. (A
// flattened ball loses a share of about 4 (r / R)^2 on a sphere of radius R.) Points whose geometric normal differs from
// the query's by more than about 37 degrees are ignored. The other side of a thin wall faces away, so its light does not
// leak through. Light on a floor or ceiling that continues below the wall can still leak.
#pragma once

#include <cstdint>
#include <vector>

#include "math/types.h"

namespace ajar {

/// Unit vector in the low 28 bits: octahedral map (Cigolle et al. 2014), 14 bits for each coordinate.
uint32_t pack_direction(Vec3 direction);
Vec3 unpack_direction(uint32_t packed);
/// The same in the low 26 bits, with 13 bits for each coordinate.
uint32_t pack_direction_short(Vec3 direction);
Vec3 unpack_direction_short(uint32_t packed);

struct SurfacePoint {
  Vec3 position;
  /// Geometric, on the side of the lookups (seen_from): that of the light, if the surface reflects. Then kFront or kBack,
  /// if known: the normal is on this side of the face. The two high bits store the tree's splitting axis.
  uint32_t packed_normal;
  static constexpr uint32_t kFront = 1u << 28, kBack = 1u << 29, kSides = kFront | kBack;
};
/// The side of the face where the normal of the point is not; 0 if that is not known.
inline uint32_t other_side(const SurfacePoint& point) {
  const uint32_t side = point.packed_normal & SurfacePoint::kSides;
  return side ? side ^ SurfacePoint::kSides : 0u;
}

class PointTree {
 public:
  static constexpr int kMaxNeighbours = 128;
  /// The slab reaches 1 / (2 kFlatness) of the radius above and below the plane.
  static constexpr float kFlatness = 4.0f, kSteepness = 8.0f, kMinNormalCosine = 0.8f;

  /// `order[i]` becomes the index in `points` of tree point i.
  void build(std::vector<SurfacePoint> points, std::vector<uint32_t>& order);

  size_t size() const { return points_.size(); }
  bool empty() const { return points_.empty(); }
  const SurfacePoint& operator[](uint32_t i) const { return points_[i]; }

  struct Neighbours {
    int count = 0;
    float radius2;  ///< squared, in the distance of a lookup; all points that are nearer are in the list
    uint32_t index[kMaxNeighbours];
    float distance2[kMaxNeighbours];  ///< a heap with the furthest point first, once it is full
  };
  /// Up to `k` points nearest to p within `radius`. When there are k or more, `radius2` is that of the k-th point, and
  /// this point is excluded: (k - 1) / (pi r_k^2) is the unbiased estimate of a density, and k / (pi r_k^2) is biased.
  /// `not_side`: points on this side of their faces are left out (SurfacePoint::kFront or kBack). The normals on the
  /// inside of the one face of a thin pane and on the outside of the other face are equal.
  void nearest(Vec3 p, Vec3 normal, int k, float radius, Neighbours& found, uint32_t not_side = 0) const;
  /// The nearest point within `radius`, or -1.
  int nearest(Vec3 p, Vec3 normal, float radius) const;

 private:
  template <class Visit>
  void search(Vec3 p, Vec3 normal, float& radius2, uint32_t not_side, Visit&& visit) const;
  static constexpr int kFacings = 6;
  std::vector<SurfacePoint> points_;
  uint32_t begin_[kFacings + 1] = {};  ///< start of the tree of each axis direction, and the end of the last
};

}  // namespace ajar
