// Where which learned density holds: a binary tree over positions and normals, refined where samples are many.
//
// A cell is a box in space and in normals, so that it holds places that see alike: what is learned there may contain
// the cosine. Cells are divided at the mean of their samples, across normals while these differ much, else across the
// widest axis of space. Learning happens between iterations, from samples in a fixed order, each cell by itself: any
// number of threads, the same tree.
#pragma once

#include <vector>

#include "transport/guiding/guide_lobes.h"

namespace ajar {

class GuideTree {
 public:
  /// What the past counts in a lesson, and in the one at the end of a frame, from which the next frame begins.
  static constexpr float kPastShare = 0.5f, kPastShareAtEnd = 0.75f;

  /// Null where nothing is known.
  const GuideDistribution* find(Vec3 position, Vec3 normal) const {
    const float at[6] = {position.x, position.y, position.z, normal.x, normal.y, normal.z};
    const Node* node = nodes_.data();
    while (node->axis >= 0) node = nodes_.data() + node->child + (at[node->axis] >= node->split ? 1 : 0);
    return node->child != 0 ? &cells_[node->child - 1].distribution : nullptr;
  }

  /// Everything in `samples` becomes the past; of what was the past before, such a share counts.
  void learn(const std::vector<GuideSample>& samples, float past_share = kPastShare);
  size_t cell_count() const { return cells_.size(); }
  size_t memory_bytes() const { return nodes_.capacity() * sizeof(Node) + cells_.capacity() * sizeof(Cell); }

 private:
  struct Node {
    float split = 0.0f;
    int32_t axis = -1;   ///< 0 to 2: position, 3 to 5: normal; -1: a leaf
    uint32_t child = 0;  ///< the first of two; of a leaf: its cell + 1, 0 for none
  };
  struct Cell {
    GuideDistribution distribution;
    float past_share = 0.0f;
  };
  void divide(uint32_t leaf, const GuideSample** begin, const GuideSample** end, int depth);

 public:
  static constexpr size_t kBytesPerCell = sizeof(Cell) + 2 * sizeof(Node);
  /// While it learns, of each sample besides the sample.
  static constexpr size_t kBytesPerSample = sizeof(uint32_t) + sizeof(const GuideSample*);

 private:
  std::vector<Node> nodes_{Node{}};
  std::vector<Cell> cells_;
  struct Task {
    uint32_t cell;
    const GuideSample** begin;
    const GuideSample** end;
    bool fresh;
  };
  std::vector<Task> tasks_;
};

}  // namespace ajar
