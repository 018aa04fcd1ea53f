// Emissive meshes with many instances. An instance is one entry of the tree of the scene, a cluster; the instances of a
// mesh share a tree and a table of powers of its triangles, in object space.
//
// 6,000 instances of a mesh of 7,000 emissive triangles are 42 million lights. A tree of all of them takes 5 GB, and
// tables of so many powers cannot give each a probability of its own. With clusters, time and memory grow with the number
// of instances plus that of triangles.
//
// A light of a cluster is chosen in the shared tree for the point in object space. On which side of a plane the point is
// does not depend on the space, so a triangle that reaches the point keeps a positive probability, also if the instance
// is not scaled evenly.
//
// The entries of the tree of the scene are numbered in the order of the lights. With clusters, these numbers differ.
#pragma once

#include <vector>

#include "geometry/geometry.h"
#include "lights/light_tree.h"
#include "math/distribution.h"

namespace ajar {

class LightClusters {
 public:
  /// What the instances of an emissive mesh share. Light `t` of the tree is triangle `t`.
  struct Shared {
    LightTree tree;
    DiscreteDistribution by_power;
    LightBounds bounds;  ///< of all triangles, object space
    double watts = 0.0;  ///< to which the intensity of the bounds belongs
  };
  struct Choice {
    uint32_t light;
    float pmf, u_remapped;
  };

  /// Makes the shared data of triangles that emit these watts in object space. Returns its number, or -1 if no triangle
  /// has a usable power.
  int share(const BuiltMesh& mesh, const BuiltInstance& instance, const std::vector<double>& watts);
  /// Adds the `count` lights of an instance in the order of the lights. `shared` -1: each light is an entry.
  void add(uint32_t first_light, uint32_t count, const BuiltInstance& instance, int shared);
  bool empty() const { return shared_.empty(); }

  /// The entry that is this light or its cluster, and the first light of an entry.
  uint32_t entry_of(uint32_t light) const;
  uint32_t light_of(uint32_t entry) const;
  /// Chooses a light of an entry for p, or by power.
  Choice choose(uint32_t entry, Vec3 p, Vec3 n, float u) const;
  Choice choose(uint32_t entry, const LightStretch& stretch, float u) const;
  Choice choose_by_power(uint32_t entry, float u) const;
  /// The probabilities of these choices, given the entry of the light. 1 outside clusters.
  float pmf(uint32_t light, Vec3 p, Vec3 n) const;
  float pmf(uint32_t light, const LightStretch& stretch) const;
  float power_pmf(uint32_t light) const;

  /// Bounds in world space of an instance that emits `watts`.
  LightBounds bounds_of(int shared, const BuiltInstance& instance, float watts) const;
  uint64_t fingerprint() const;
  size_t memory_bytes() const;

 private:
  struct Range {
    uint32_t first_light, first_entry, count, entries;
    int shared;
    const BuiltInstance* instance;
  };
  /// The last range that starts at or before a light or an entry. Null if there is none.
  template <uint32_t Range::*kFirst>
  const Range* range_from(uint32_t index) const;
  const Range* cluster_of_light(uint32_t light) const;
  const Range* cluster_of_entry(uint32_t entry) const;
  Vec3 nearest_to(const Range& range, const LightStretch& stretch) const;

  std::vector<Shared> shared_;
  std::vector<Range> ranges_;
};

/// The instance without its transform: its triangles in object space.
BuiltInstance in_object_space(BuiltInstance instance);

}  // namespace ajar
