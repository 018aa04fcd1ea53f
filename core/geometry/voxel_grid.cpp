#include "geometry/voxel_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "math/hash.h"

namespace ajar {

namespace {

/// Positions farther away, in voxels, are outside every grid.
constexpr float kFarthest = 1e9f;
constexpr int kShift = 3, kMask = VolumeGrid::kBrick - 1;
static_assert(VolumeGrid::kBrick == 1 << kShift);

size_t slot_of(std::array<int, 3> brick) {
  return size_t(nodes::hash_words<3>({uint32_t(brick[0]), uint32_t(brick[1]), uint32_t(brick[2])}));
}

}  // namespace

VoxelGrid::VoxelGrid(VolumeGrid description)
    : grid_(std::move(description)),
      index_from_object_(to_matrix(grid_.index_from_object)),
      object_from_index_(glm::affineInverse(index_from_object_)),
      table_(std::bit_ceil(2 * grid_.bricks.size() + 1), kNone) {
  for (size_t i = 0; i < grid_.bricks.size(); ++i) {
    size_t slot = slot_of(grid_.bricks[i]) & (table_.size() - 1);
    while (table_[slot] != kNone) slot = (slot + 1) & (table_.size() - 1);
    table_[slot] = uint32_t(i);
  }
}

uint32_t VoxelGrid::find(std::array<int, 3> brick) const {
  for (size_t slot = slot_of(brick);; ++slot) {
    const uint32_t found = table_[slot & (table_.size() - 1)];
    if (found == kNone || grid_.bricks[found] == brick) return found;
  }
}

Vec3 VoxelGrid::center(size_t brick, int x, int y, int z) const {
  const std::array<int, 3>& first = grid_.bricks[brick];
  constexpr float n = float(VolumeGrid::kBrick);
  return transform_point(object_from_index_, Vec3(n * float(first[0]) + float(x), n * float(first[1]) + float(y),
                                                  n * float(first[2]) + float(z)));
}

Vec4 VoxelGrid::at(Vec3 position) const {
  const Vec3 place = transform_point(index_from_object_, position);
  if (!(max_component(glm::abs(place)) < kFarthest)) return Vec4(0.0f, 0.0f, 0.0f, 1.0f);
  const Vec3 floor = glm::floor(place), fraction = place - floor;
  const std::array<int, 3> voxel{int(floor.x), int(floor.y), int(floor.z)};
  const int components = grid_.components;
  std::array<int, 3> found_brick{};
  uint32_t found = kNone;
  Vec4 sum(0.0f);
  for (int corner = 0; corner < 8; ++corner) {
    std::array<int, 3> at;
    float weight = 1.0f;
    for (int axis = 0; axis < 3; ++axis) {
      const int upper = corner >> axis & 1;
      at[size_t(axis)] = voxel[size_t(axis)] + upper;
      weight *= upper ? fraction[axis] : 1.0f - fraction[axis];
    }
    const std::array<int, 3> brick{at[0] >> kShift, at[1] >> kShift, at[2] >> kShift};
    // Most corners are in the brick of the corner before.
    if (corner == 0 || brick != found_brick) found = find(found_brick = brick);
    if (found == kNone || weight == 0.0f) continue;
    const size_t in_brick = size_t((((at[2] & kMask) << kShift | (at[1] & kMask)) << kShift) | (at[0] & kMask));
    const float* value = grid_.values.data() + (size_t(found) * VolumeGrid::kVoxels + in_brick) * size_t(components);
    sum += weight *
           (components == 1 ? Vec4(value[0]) : Vec4(value[0], value[1], value[2], components == 4 ? value[3] : 1.0f));
  }
  if (components != 4) return {Vec3(sum), 1.0f};
  constexpr float kSmallest = 1e-6f;
  return sum.w > kSmallest ? Vec4(Vec3(sum) / sum.w, sum.w) : sum;
}

Vec3 VoxelGrid::largest() const {
  Vec3 result(0.0f);
  for (size_t i = 0; i + 3 <= grid_.values.size(); i += 3)
    for (int axis = 0; axis < 3; ++axis)
      result[axis] = std::max(result[axis], std::abs(grid_.values[i + size_t(axis)]));
  return result;
}

size_t VoxelGrid::memory_bytes() const {
  return grid_.bricks.size() * sizeof(grid_.bricks[0]) + grid_.values.size() * sizeof(float) +
         table_.size() * sizeof(uint32_t);
}

}  // namespace ajar
