// Ray queries on the built geometry. accel.cpp alone includes Embree.
//
// A hit names the instance (index into Scene::instances) and the triangle of its mesh. Baked meshes
// sit in the top-level structure, others behind Embree instances that share one structure per mesh.
// Lamps with extent live in a structure of their own, since they never block a ray.
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
  /// Builds everything; throws Cancelled when `stop` is raised, SceneError when Embree fails (out of memory).
  /// The arrays of `meshes` and `instances` must outlive this object: Embree reads them in place. Meshes that bring a
  /// structure, made by `previous`, keep it. The structure over all of `previous` is taken over where no more than half
  /// of its instances, `previous_instances`, have changed.
  Accel(std::vector<BuiltMesh>& meshes, const std::vector<BuiltInstance>& instances, const std::atomic<bool>* stop,
        Accel* previous, const std::vector<BuiltInstance>& previous_instances);
  ~Accel();
  void build_lamps(const LightSet& lights);

  void intersect(const Ray& ray, uint32_t ray_kind, Hit& hit) const;
  bool occluded(const Ray& ray) const;
  /// By this instance alone, whoever sees it. Baked meshes have no structure of their own, and are in nobody's way
  /// here.
  bool occluded_by(const BuiltInstance& instance, const BuiltMesh& mesh, const Ray& ray) const;
  void intersect_lamp(const Ray& ray, uint32_t ray_kind, LampHit& hit) const;
  bool has_lamps() const;
  size_t placed_instances() const;  ///< those put into the structure over all; the others were in that of before
  uint64_t memory_bytes() const;
  /// Bounds of everything that is not empty; min > max when there is nothing.
  void bounds(Vec3& lower, Vec3& upper) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Of the libraries found at run time.
std::string embree_version();
std::string tbb_version();

}  // namespace ajar
