// Many instances of a mesh with few triangles, such as leaves and blades of grass.
//
// Embree enters the space of each instance whose box a ray meets, and the boxes of leaves overlap. The triangles of such
// instances are therefore in the top-level structure, in world space: one geometry for all instances of a mesh that the
// same rays see. Its primitives are in the order of the instances. It takes more memory than the instances if the mesh has
// more than three triangles, so all crowds together have at most kMostOfAll triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/geometry.h"

struct RTCDeviceTy;  // of Embree
struct RTCSceneTy;

namespace ajar {

class InstanceCrowds {
 public:
  static constexpr size_t kMostTriangles = 8;  ///< of a mesh
  static constexpr size_t kFewest = 64;        ///< instances of a crowd
  static constexpr size_t kMostOfAll = size_t(1) << 23;

  InstanceCrowds() = default;
  /// Finds the crowds. Sets BuiltMesh::crowded.
  InstanceCrowds(std::vector<BuiltMesh>& meshes, const std::vector<BuiltInstance>& instances);
  bool operator==(const InstanceCrowds&) const = default;

  /// Attaches the geometries to a scene, after the numbers of the instances. Embree owns their buffers.
  void attach(RTCDeviceTy* device, RTCSceneTy* scene, const std::vector<BuiltMesh>& meshes,
              const std::vector<BuiltInstance>& instances) const;
  bool has(uint32_t instance) const { return !is_member_.empty() && is_member_[instance]; }
  size_t instance_count() const;
  /// Turns the numbers of a geometry and its primitive into those of an instance and its triangle.
  void resolve(uint32_t& geometry, uint32_t& primitive) const {
    if (geometry < first_) [[likely]]
      return;
    const Crowd& crowd = crowds_[geometry - first_];
    geometry = crowd.instances[primitive / crowd.triangles];
    primitive %= crowd.triangles;
  }

 private:
  struct Crowd {
    uint32_t mesh, visibility, triangles;
    std::vector<uint32_t> instances;
    bool operator==(const Crowd&) const = default;
  };
  std::vector<Crowd> crowds_;
  std::vector<bool> is_member_;  // by instance; empty without crowds
  uint32_t first_ = ~0u;         // the geometry of the first crowd
};

}  // namespace ajar
