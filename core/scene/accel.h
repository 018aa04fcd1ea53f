// Ray queries on the built geometry.
//
// A hit names the instance (index into Scene::instances) and the triangle of its mesh. Baked meshes and the instances of
// very small ones (instance_crowds.h) are in the top-level structure. Other meshes have one structure each, which Embree
// instances share. Lamps with extent have a separate structure, because they never block rays.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "geometry/geometry.h"
#include "lights/light_set.h"

namespace ajar {

struct Hit;
struct LampHit;

class Accel {
 public:
  /// Builds everything. With `compact`, the structure of triangles takes about half of the memory, and rays need more time:
  /// boxes have bounds of 8 bits, and triangles refer to their vertices. Throws Cancelled if `stop` is set, and SceneError if Embree fails (out of memory).
  /// The arrays of `meshes` and `instances` must outlive this object, because Embree reads them in place. Meshes keep a
  /// structure that `previous` has made. The top-level structure of `previous` is taken over if no more than half of
  /// its instances, `previous_instances`, have changed.
  /// A structure that is compact and one that is not share nothing.
  Accel(std::vector<BuiltMesh>& meshes, const std::vector<BuiltInstance>& instances, bool compact,
        const std::atomic<bool>* stop, Accel* previous, const std::vector<BuiltInstance>& previous_instances);
  ~Accel();
  void build_lamps(const LightSet& lights);

  void intersect(const Ray& ray, uint32_t ray_kind, Hit& hit) const;
  bool occluded(const Ray& ray) const;
  /// Occlusion by this instance alone, whatever its visibility. Baked meshes have no structure of their own and never
  /// occlude here.
  bool occluded_by(const BuiltInstance& instance, const BuiltMesh& mesh, const Ray& ray) const;
  /// The nearest hit on this instance alone, whatever its visibility, and never on baked meshes. It fills all of `hit` but
  /// the instance.
  bool intersect_own(const BuiltInstance& instance, const BuiltMesh& mesh, const Ray& ray, Hit& hit) const;
  void intersect_lamp(const Ray& ray, uint32_t ray_kind, LampHit& hit) const;
  bool has_lamps() const;
  size_t placed_instances() const;  ///< those put into the top-level structure; the others were in the previous one
  uint64_t memory_bytes() const;
  /// Bounds of everything that is not empty; min > max if there is nothing.
  void bounds(Vec3& lower, Vec3& upper) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Versions of the libraries that are loaded at run time.
std::string embree_version();
std::string tbb_version();

}  // namespace ajar
