// A binary tree over local lights, from which one is chosen for a point in O(log n) by how much it may light that
// point.
//
// Each node bounds its lights: a box around where they are, a cone around where they shine, and the sum of their
// intensities. The importance of a node for point p with normal n is an estimate of the largest irradiance it sends,
// intensity cos cos / distance^2, with angles made as favourable as its bounds allow; a branch is taken in proportion
// [Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"]. It is 0 only where
// nothing below can shine: no light that reaches p has no probability. Occlusion is not known.
//
// Choosing inverts one random number: what is left of it is handed back, and numbers that are stratified stay so.
#pragma once

#include <cstdint>
#include <vector>

#include "lights/light_bounds.h"

namespace ajar {

class LightTree {
 public:
  struct Entry {
    uint32_t light;
    LightBounds bounds;
  };
  struct Choice {
    uint32_t light;
    float pmf;  ///< 0: the branch taken holds nothing that reaches the point; this sample is worth 0
    float u_remapped;
  };

  LightTree() = default;
  /// `light_count` is one more than the largest index. Entries must have finite bounds and positive intensity.
  LightTree(std::vector<Entry> entries, uint32_t light_count);

  bool empty() const { return nodes_.empty(); }
  bool contains(uint32_t light) const { return light < trails_.size() && trails_[light] != kNoTrail; }
  /// n = 0: light counts from all sides.
  Choice choose(Vec3 p, Vec3 n, float u) const { return choose_below(0, p, n, u); }
  /// Exactly the pmf that `choose` reports for this light.
  float pmf(Vec3 p, Vec3 n, uint32_t light) const { return pmf_below(0, p, n, light); }
  /// A cut: nodes that together hold every light once, in ascending order, and their shares of the light that reaches a
  /// neighbourhood of p, as far as the tree can tell. What sends most is split first, until there are `most`.
  struct CutNode {
    uint32_t node;
    float share;
  };
  void cut(Vec3 p, float radius, Vec3 n, int most, std::vector<CutNode>& nodes) const;
  /// The same as choose and pmf among the lights below a node.
  Choice choose_below(uint32_t node, Vec3 p, Vec3 n, float u) const;
  float pmf_below(uint32_t node, Vec3 p, Vec3 n, uint32_t light) const;
  /// Node of a light: the node of a cut that holds it is the last one not after it.
  uint32_t leaf_of(uint32_t light) const;
  /// Estimate of the irradiance all lights send to p.
  float importance(Vec3 p, Vec3 n) const { return nodes_.empty() ? 0.0f : importance(nodes_[0], p, n); }
  /// Two trees with the same one choose alike; nodes mean the same lights in both.
  uint64_t fingerprint() const;
  size_t memory_bytes() const { return nodes_.size() * sizeof(Node) + trails_.size() * sizeof(uint64_t); }

 private:
  struct Node {
    Vec3 center, axis;
    float radius_squared;  // of the sphere around the box
    float cos_normals, sin_normals, cos_beyond;
    float intensity;
    uint32_t second;  // inner: index of the second child, the first one follows; leaf: the light
    bool leaf, two_sided;
  };
  static constexpr uint64_t kNoTrail = 0;

  static float importance(const Node& node, const Vec3& p, const Vec3& n);
  static float importance_nearby(const Node& node, Vec3 p, float radius, Vec3 n);
  /// Probability of the first child. Negative: neither reaches p.
  float first_share(uint32_t node, const Vec3& p, const Vec3& n) const;
  void build(std::vector<Entry>& entries, uint32_t begin, uint32_t end, uint32_t node, uint64_t trail);

  std::vector<Node> nodes_;
  // By light: the branches from the root to it, lowest bit first, above them a bit that ends them. 0: not in the tree.
  std::vector<uint64_t> trails_;
};

}  // namespace ajar
