// The learned distributions by position and normal: a binary tree, refined where there are many samples.
//
// A cell is a box in position and normal. All its points receive similar light, so the distribution can include the
// cosine. Cells are divided at the mean of their samples: by normals as long as these differ much, otherwise by the
// widest axis of position. Volumes have cells of their own, by position alone. The guide is trained between iterations,
// from samples in a fixed order, each cell separately. So the tree does not depend on the number of threads.
#pragma once

#include <vector>

#include "transport/guiding/guide_lobes.h"

namespace ajar {

class GuideTree {
 public:
  /// Factors on the past samples: in a training step, and in the step at the end of a frame, from which the next frame
  /// starts.
  static constexpr float kPastShare = 0.5f, kPastShareAtEnd = 0.75f;

  /// Pseudo-samples of uniform directions that widen each lobe. Paths do best with narrow lobes. Gather rays find the
  /// noise of photon maps too, and need wider ones (docs/research/path_guiding.md).
  static constexpr float kWidthPriorOfPaths = 0.3f, kWidthPriorOfGatherRays = 1.5f;
  explicit GuideTree(float width_prior = kWidthPriorOfPaths) : width_prior_(width_prior) {}

  /// Returns null if nothing is known.
  const GuideDistribution* find(Vec3 position, Vec3 normal) const { return find(kSurfaces, position, normal); }
  const GuideDistribution* find_in_volume(Vec3 position) const { return find(kVolumes, position, Vec3(0.0f)); }

  /// A training step from `samples`. Earlier samples count with the factor `past_share`.
  void learn(const std::vector<GuideSample>& samples, float past_share = kPastShare);
  size_t cell_count() const { return cells_.size(); }
  size_t memory_bytes() const { return nodes_.capacity() * sizeof(Node) + cells_.capacity() * sizeof(Cell); }

 private:
  struct Node {
    float split = 0.0f;
    int32_t axis = -1;   ///< 0 to 2: position; 3 to 5: normal; -1: a leaf
    uint32_t child = 0;  ///< index of the first of two children; for a leaf: index of its cell + 1, 0 for none
  };
  struct Cell {
    GuideDistribution distribution;
    float past_share = 0.0f;
  };
  static constexpr uint32_t kSurfaces = 0, kVolumes = 1;  ///< roots
  static uint32_t root_of(const GuideSample& sample) { return sample.kind == GuideKind::Volume ? kVolumes : kSurfaces; }
  const GuideDistribution* find(uint32_t root, Vec3 position, Vec3 normal) const {
    const float at[6] = {position.x, position.y, position.z, normal.x, normal.y, normal.z};
    const Node* node = nodes_.data() + root;
    while (node->axis >= 0) node = nodes_.data() + node->child + (at[node->axis] >= node->split ? 1 : 0);
    return node->child != 0 ? &cells_[node->child - 1].distribution : nullptr;
  }
  void divide(uint32_t leaf, const GuideSample** begin, const GuideSample** end, int depth);

 public:
  static constexpr size_t kBytesPerCell = sizeof(Cell) + 2 * sizeof(Node);
  /// Memory per sample during a training step, without the sample itself.
  static constexpr size_t kBytesPerSample = sizeof(uint32_t) + sizeof(const GuideSample*);

 private:
  float width_prior_;
  std::vector<Node> nodes_{Node{}, Node{}};
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
