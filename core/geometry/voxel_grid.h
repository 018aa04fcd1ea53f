// Sparse grids of voxels: the densities, temperatures and colours of a volume.
//
// Only bricks of 8 x 8 x 8 voxels that hold a value other than zero are stored. A hash table finds them, so that the
// extent of a grid costs nothing. Values between voxels are interpolated linearly along each axis.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

class VoxelGrid {
 public:
  /// The description must be valid (validate.h). Its bricks may be in any order.
  explicit VoxelGrid(VolumeGrid description);

  const std::string& name() const { return grid_.name; }
  /// The value at a position in object space. A grid of one component has the same value in red, green and blue. Alpha is
  /// 1, or the fourth component; then the colour is divided by it after the interpolation.
  Vec4 at(Vec3 position) const;
  /// The largest absolute value of each component of a grid with three.
  Vec3 largest() const;
  size_t brick_count() const { return grid_.bricks.size(); }
  /// Calls `visit(position)` for the centre of every `stride`-th voxel along each axis of a brick, in object space.
  template <class Visit>
  void for_each_voxel(size_t brick, int stride, Visit&& visit) const {
    constexpr int n = VolumeGrid::kBrick;
    for (int z = 0; z < n; z += stride)
      for (int y = 0; y < n; y += stride)
        for (int x = 0; x < n; x += stride) visit(center(brick, x, y, z));
  }
  size_t memory_bytes() const;

 private:
  static constexpr uint32_t kNone = ~0u;
  uint32_t find(std::array<int, 3> brick) const;
  Vec3 center(size_t brick, int x, int y, int z) const;

  VolumeGrid grid_;
  Mat4 index_from_object_, object_from_index_;
  std::vector<uint32_t> table_;  // open addressing; the size is a power of two
};

}  // namespace ajar
