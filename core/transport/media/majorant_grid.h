// The cells of the majorants of a medium that varies: a grid over the bounds of an object, or over an endless medium.
//
// The grid of an endless medium has even cells from the middle to the distance `half` along each axis. They take half
// of the cells; beyond, the borders are at powers of half, up to kOctaves doublings. A ray that leaves the grid has left
// the medium: at the end of the octaves everything that scatters noticeably is opaque.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "math/types.h"

namespace ajar {

class MajorantGrid {
 public:
  MajorantGrid() = default;
  /// Flat bounds get a small thickness.
  MajorantGrid(Vec3 lower, Vec3 upper)
      : lower_(lower), extent_(glm::max(upper - lower, Vec3(1e-6f * max_component(upper - lower) + 1e-30f))) {}
  static MajorantGrid endless(Vec3 middle, float half) {
    MajorantGrid grid(middle - Vec3(half), middle + Vec3(half));
    grid.endless_ = true;
    return grid;
  }

  bool is_endless() const { return endless_; }
  /// Of the grid, or of the even cells of an endless medium.
  Vec3 extent() const { return extent_; }
  const std::array<int, 3>& cells() const { return cells_; }
  size_t count() const { return size_t(cells_[0]) * size_t(cells_[1]) * size_t(cells_[2]); }
  /// `cells`: along each axis, multiples of 4 if the medium is endless.
  void divide(const std::array<int, 3>& cells) {
    cells_ = cells;
    for (int axis = 0; axis < 3; ++axis) {
      size_[axis] = extent_[axis] / (endless_ ? 0.5f * float(cells[size_t(axis)]) : float(cells[size_t(axis)]));
      inverse_size_[axis] = 1.0f / size_[axis];
    }
  }
  bool is_divided() const { return inverse_size_.x > 0.0f; }

  size_t index(const std::array<int, 3>& cell) const {
    return size_t((cell[2] * cells_[1] + cell[1]) * cells_[0] + cell[0]);
  }
  std::array<int, 3> cell(size_t index) const {
    const size_t nx = size_t(cells_[0]), ny = size_t(cells_[1]);
    return {int(index % nx), int(index / nx % ny), int(index / (nx * ny))};
  }
  /// The place of a coordinate in cells; outside of the grid it is negative, or at least the number of cells. With
  /// `kEndless`, which must be is_endless(), loops over the cells along a ray have no branches.
  template <bool kEndless>
  float place(int axis, float x) const {
    const float even = (x - lower_[axis]) * inverse_size_[axis];
    return kEndless ? warped(even, float(cells_[size_t(axis)])) : even;
  }
  float place(int axis, float x) const { return endless_ ? place<true>(axis, x) : place<false>(axis, x); }
  /// The coordinate of the lower border of a cell.
  template <bool kEndless>
  float border(int axis, int cell) const {
    return lower_[axis] + size_[axis] * (kEndless ? unwarped(float(cell), float(cells_[size_t(axis)])) : float(cell));
  }
  float border(int axis, int cell) const { return endless_ ? border<true>(axis, cell) : border<false>(axis, cell); }
  template <bool kEndless>
  float size(int axis, int cell) const {
    return kEndless ? border<true>(axis, cell + 1) - border<true>(axis, cell) : size_[axis];
  }
  float size(int axis, int cell) const { return endless_ ? size<true>(axis, cell) : size<false>(axis, cell); }
  Vec3 lower(const std::array<int, 3>& cell) const {
    return {border(0, cell[0]), border(1, cell[1]), border(2, cell[2])};
  }
  Vec3 size(const std::array<int, 3>& cell) const { return {size(0, cell[0]), size(1, cell[1]), size(2, cell[2])}; }
  /// Mean length of the sides of a cell.
  float side(const std::array<int, 3>& cell) const { return glm::length(size(cell)) / std::sqrt(3.0f); }
  /// Whether a cell is one of the even ones.
  bool is_even(const std::array<int, 3>& cell) const {
    const auto outside = [&](int axis) {
      const int at = 4 * cell[size_t(axis)] + 2, n = cells_[size_t(axis)];
      return at < n || at > 3 * n;
    };
    return !endless_ || !(outside(0) || outside(1) || outside(2));
  }

 private:
  static constexpr float kOctaves = 20.0f;
  /// `even`: from 0 to n / 2 across the even cells. The result is from n / 4 to 3 n / 4 there.
  static float warped(float even, float n) {
    const float quarter = 0.25f * n, distance = (even - quarter) / quarter, a = std::abs(distance);
    if (a <= 1.0f) return quarter + even;
    return 2.0f * quarter + std::copysign(quarter * (1.0f + std::log2(a) / kOctaves), distance);
  }
  static float unwarped(float place, float n) {
    const float quarter = 0.25f * n, distance = (place - 2.0f * quarter) / quarter, a = std::abs(distance);
    if (a <= 1.0f) return place - quarter;
    return quarter + std::copysign(quarter * std::exp2((a - 1.0f) * kOctaves), distance);
  }

  Vec3 lower_{0.0f}, extent_{0.0f}, size_{0.0f}, inverse_size_{0.0f};
  std::array<int, 3> cells_{};
  bool endless_ = false;
};

}  // namespace ajar
