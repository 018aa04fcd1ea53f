// A binary tree over local lights. It chooses a light for a point in O(log n), by an estimate of its contribution.
//
// Each node bounds its lights: a box of their positions, a cone of their directions, and the sum of their intensities.
// The importance of a node for point p with normal n is an estimate of the maximum irradiance that it sends: intensity
// cos cos / distance^2, with the most favourable angles that its bounds allow; that of a lamp, the mean over its extent.
// A branch is chosen in proportion [Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
// Splitting"]. The importance is 0 only if nothing below can illuminate p, so every light that reaches p has a positive
// probability. Occlusion is not considered.
//
// For a part of a ray in a medium, the mean of intensity / distance^2 along it counts, in closed form [Kulla and Fajardo
// 2012, eq. 7, integrated], with the most favourable angle of all its points.
//
// Lamps have a subtree of their own, beside that of the emissive triangles: the bounds of a spot lamp and of the glowing
// lens beside it would allow a strong beam in all directions. A node of lamps is chosen by the sum of the importances of
// its parts, and then one part of it by these: all of its lamps if they are at most kParts, else nodes below it.
//
// The choice inverts one random number and returns the remainder of it, so stratified numbers stay stratified.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lights/light_aim.h"
#include "lights/light_stretch.h"

namespace ajar {

class LightTree {
 public:
  struct Entry {
    uint32_t light;
    LightBounds bounds;
  };
  struct Choice {
    uint32_t light;
    float pmf;  ///< 0: nothing in the chosen branch reaches the point; the contribution of this sample is 0
    float u_remapped;
  };

  LightTree() = default;
  /// `light_count` is one more than the largest index. Entries must have finite bounds and positive intensity.
  LightTree(std::vector<Entry> entries, uint32_t light_count);

  bool empty() const { return nodes_.empty(); }
  bool contains(uint32_t light) const { return light < trails_.size() && trails_[light] != kNoTrail; }
  /// n = 0: light from all sides counts.
  Choice choose(Vec3 p, Vec3 n, float u) const { return choose_below(0, p, n, u); }
  Choice choose(const LightStretch& stretch, float u) const;
  /// Exactly the pmf that `choose` reports for this light.
  float pmf(Vec3 p, Vec3 n, uint32_t light) const { return pmf_below(0, p, n, light); }
  float pmf(const LightStretch& stretch, uint32_t light) const;
  /// A cut: nodes that together hold every light once, in ascending order, and estimates of their shares of the light
  /// that reaches a neighbourhood of p. The node that sends most is split first, until there are `max_nodes`.
  struct CutNode {
    uint32_t node;
    float share;
  };
  void cut(Vec3 p, float radius, Vec3 n, int max_nodes, std::vector<CutNode>& nodes) const;
  /// The same as choose and pmf, for the lights below a node.
  Choice choose_below(uint32_t node, Vec3 p, Vec3 n, float u) const;
  float pmf_below(uint32_t node, Vec3 p, Vec3 n, uint32_t light) const;
  /// Leaf of a light. In a cut, the last node that is not after this one holds the light.
  uint32_t leaf_of(uint32_t light) const;
  /// Estimate of the irradiance that all lights send to p.
  float importance(Vec3 p, Vec3 n) const;
  /// The mean of that along a stretch.
  float importance(const LightStretch& stretch) const;
  /// Trees with equal fingerprints make equal choices, and their nodes hold the same lights.
  uint64_t fingerprint() const;
  size_t memory_bytes() const {
    return nodes_.size() * sizeof(Node) + trails_.size() * sizeof(uint64_t) + lanes_.memory_bytes();
  }

 private:
  struct Node : LightAim {
    uint32_t second;  // inner node: index of the second child (the first one follows the node); leaf: the light
    // Of lamps: the parts of the node are these lanes; 0: it has no parts.
    uint32_t lane : 23, parts : 7, leaf : 1, two_sided : 1;
  };
  static constexpr uint32_t kParts = 64, kMaxLanes = 1u << 23;
  using Importances = std::array<float, kParts + LightLanes::kAtOnce>;
  static constexpr uint64_t kNoTrail = 0;

  static float importance(const Node& node, const Vec3& p, const Vec3& n) {
    return irradiance_estimate<true>(node, node.two_sided, Triple(p), Triple(n));
  }
  static float importance(const Node& node, const LightStretch& stretch);
  static float importance_nearby(const Node& node, Vec3 p, float radius, Vec3 n);
  /// Importances of the parts of a node, and their sum, which is finite.
  float importances(uint32_t node, Importances& values, const Vec3& p, const Vec3& n) const;
  float importances(uint32_t node, Importances& values, const LightStretch& stretch) const;
  static float finite_sum(Importances& values, uint32_t count);
  template <class... Receiver>
  float importance_of(uint32_t node, const Receiver&... receiver) const;
  template <class... Receiver>
  float importance_of_all(const Receiver&... receiver) const;
  /// Probability of the first child; negative if neither reaches the receiver: a point and its normal, or a stretch.
  template <class... Receiver>
  float first_share(uint32_t node, const Receiver&... receiver) const;
  template <class... Receiver>
  Choice choose_for(uint32_t node, float u, const Receiver&... receiver) const;
  /// The choice of a part of a node by their importances. Its `light` is the node of the part.
  template <class... Receiver>
  Choice choose_part(uint32_t node, float u, const Receiver&... receiver) const;
  /// The part that holds a leaf.
  uint32_t part_of(uint32_t node, uint32_t leaf) const;
  template <class... Receiver>
  float pmf_for(uint32_t top, uint32_t light, const Receiver&... receiver) const;
  /// Returns the bounds of these entries.
  LightBounds build(std::vector<Entry>& entries, uint32_t begin, uint32_t end, uint32_t node, uint64_t trail,
                    std::vector<LightLanes::Lane>& lanes);
  /// Gives parts to a node of lamps and to those of its parts that have more than kParts lamps.
  void divide(uint32_t node, std::vector<LightLanes::Lane>& lanes);

  std::vector<Node> nodes_;
  // For each light: the branches from the root to it, lowest bit first, and above them a bit that marks the end. 0: not
  // in the tree.
  std::vector<uint64_t> trails_;
  // First the lamps, in the order of their leaves, then the parts of nodes with more than kParts lamps.
  LightLanes lanes_;
  uint32_t lamps_ = 0;  // number of lamps
};

}  // namespace ajar
