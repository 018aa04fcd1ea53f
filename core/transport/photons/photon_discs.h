// The surface around each photon that can receive its light.
//
// A density estimate divides by the area of a disc. Where the disc extends over the edge of an object, part of it
// contains no surface, and the estimate is too dark. Where it extends below the foot of a wall, the light of the next
// room leaks through. Here the disc of each photon is divided into eight sectors. A ray from above the photon to a
// point of the sector finds surface, a wall in front of it, or nothing. The light is spread over the part of the disc
// that was found, and not behind walls that were hit. Its density there is (8 + 1) / (found + 1) times that of the
// whole disc. The expectation of this factor is correct except for the probability of finding nothing [after Hey and
// Purgathofer 2002, "Advanced radiance estimation for photon map global illumination", who compute that part from the
// triangles].
//
// This affects the bias only: for small radii every disc is whole. The rays of a photon are traced at its first lookup.
// The result takes eight bytes per photon.
#pragma once

#include <atomic>
#include <memory>

#include "transport/photons/point_tree.h"

namespace ajar {

class Scene;

class PhotonDiscs {
 public:
  /// For this number of photons and lookups within `radius`, at one time. The scene must outlive this object.
  void start(const Scene& scene, size_t photons, float radius, float time, uint32_t seed);
  bool started() const { return scene_ != nullptr; }
  /// Area of a whole disc of squared radius `radius2` around photon number `photon` at `at`, over the area that
  /// receives its light; 0 when `position` is outside that area. The result does not depend on earlier calls or on the
  /// thread.
  float inverse_share(uint32_t photon, const SurfacePoint& at, Vec3 position, float radius2) const;
  size_t memory_bytes() const { return photons_ * sizeof(uint64_t); }

 private:
  uint64_t look_around(uint32_t photon, const SurfacePoint& at) const;

  const Scene* scene_ = nullptr;
  size_t photons_ = 0;
  float radius_ = 0.0f, time_ = 0.0f;
  uint32_t seed_ = 0;
  mutable std::unique_ptr<std::atomic<uint64_t>[]> known_;  ///< one byte for each sector
};

}  // namespace ajar
