// Points on surfaces, found again by nearness: a kd-tree laid out flat in one array.
//
// One tree for each of the six axes that normals turn to most: a lookup leaves those alone that it could not see. In
// each, the point at the middle of a range splits it; what lies before is on its low side, what lies after on its high
// side, so the tree needs no pointers and no nodes: 16 bytes a point. Ranges of a few points are searched in order.
// Built in parallel; equal input gives an equal tree for any number of threads.
//
// Nearness is measured in a disc rather than in a ball: distance along the query's normal counts `kFlatness` times
// [Jensen 2001, section 7.2.2], and points whose geometric normal turns away from the query's by more than about
// 37 degrees are not seen at all. A thin wall's other side faces away, so its light does not bleed through; what
// remains is light on a floor or ceiling that continues below the wall.
#pragma once

#include <cstdint>
#include <vector>

#include "math/types.h"

namespace ajar {

/// Unit vector in 30 bits: octahedral map (Cigolle et al. 2014), 15 bits a coordinate, in the low bits.
uint32_t pack_direction(Vec3 direction);
Vec3 unpack_direction(uint32_t packed);

struct SurfacePoint {
  Vec3 position;
  uint32_t packed_normal;  ///< geometric, on the side that counts; the two high bits are the tree's
};

class PointTree {
 public:
  static constexpr int kMaxNeighbours = 128;
  static constexpr float kFlatness = 4.0f, kMinNormalCosine = 0.8f;

  /// Takes the points; `order[i]` is the index that tree point i had in `points`.
  void build(std::vector<SurfacePoint> points, std::vector<uint32_t>& order);

  size_t size() const { return points_.size(); }
  bool empty() const { return points_.empty(); }
  const SurfacePoint& operator[](uint32_t i) const { return points_[i]; }

  struct Neighbours {
    int count = 0;
    float radius2;  ///< all points nearer than this, in the disc's distance, are among them
    uint32_t index[kMaxNeighbours];
    float distance2[kMaxNeighbours];  ///< a heap, the furthest first, once it is full
  };
  /// At most `k` points nearest to p within `radius`. When there are more, `radius2` is that of the k-th, and it is
  /// left out: (k - 1) / (pi r_k^2) is the unbiased estimate of a density, k / (pi r_k^2) is not.
  void nearest(Vec3 p, Vec3 normal, int k, float radius, Neighbours& found) const;
  /// The nearest point within `radius`, or -1.
  int nearest(Vec3 p, Vec3 normal, float radius) const;

 private:
  template <class Visit>
  void search(Vec3 p, Vec3 normal, float& radius2, Visit&& visit) const;
  static constexpr int kFacings = 6;
  std::vector<SurfacePoint> points_;
  uint32_t begin_[kFacings + 1] = {};  ///< of the tree of each facing, and the end
};

}  // namespace ajar
