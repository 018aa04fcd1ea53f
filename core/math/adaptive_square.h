// A density on the unit square that is learned from weighted points: a quadtree, refined where there are many points.
//
// The mass of a cell is divided among its quarters by the weights of their points, with half a point more for each
// quarter. Cells with few points are therefore nearly uniform. Each point gives a part of its weight to a copy at a
// distance whose logarithm is uniform, so that the density falls with the square of the distance from the points, and not
// at the edges of cells. Equal points in equal order give an equal tree.
#pragma once

#include <vector>

#include "math/types.h"

namespace ajar {

class AdaptiveSquare {
 public:
  struct Point {
    Vec2 at;  ///< points outside [0, 1)^2 are left out
    float weight;
  };
  AdaptiveSquare() = default;
  explicit AdaptiveSquare(std::vector<Point> points);

  /// Without points of positive weight; such a square must not be sampled.
  bool empty() const { return nodes_.empty(); }
  /// A point of [0, 1)^2. Keeps the stratification of u.
  Vec2 sample(Vec2 u) const;
  /// Density per area; 0 outside the square.
  float density(Vec2 at) const;
  size_t memory_bytes() const { return nodes_.capacity() * sizeof(Node); }

 private:
  /// Quarter 2 y + x.
  struct Node {
    float share[4];
    uint32_t child[4];  ///< 0: a leaf
  };
  uint32_t divide(Point* begin, Point* end, int depth);

  std::vector<Node> nodes_;
};

}  // namespace ajar
