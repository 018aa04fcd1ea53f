// How much surface there is around each photon for its light to be spread over.
//
// A density estimate divides by the area of a disc. Where the disc reaches over the edge of a board, part of it is no
// surface that light could lie on, and the estimate is too dark; where it reaches below the foot of a wall, the light
// of the next room shows. Here each photon looks around itself in eight sectors: a ray from above it to a place of its
// own in the sector finds surface there, a wall before it, or nothing. The light is spread over the part of the disc
// that was found, (8 + 1) / (found + 1) times as dense (the mean of which is right but for the probability to find
// none), and not behind walls that were met [after Hey and Purgathofer 2002, "Advanced radiance estimation for photon
// map global illumination", who find that part from the triangles].
//
// Bias only: in the limit of small radii every disc is whole. Photons look around when they are first asked for; eight
// bytes each.
#pragma once

#include <atomic>
#include <memory>

#include "transport/photons/point_tree.h"

namespace ajar {

class Scene;

class PhotonDiscs {
 public:
  /// Of so many photons, for lookups within `radius`. The scene must outlive this.
  void start(const Scene& scene, size_t photons, float radius, uint32_t seed);
  bool started() const { return scene_ != nullptr; }
  /// Area of a whole disc of squared radius `radius2` around photon number `photon`, which lies `at`, over that of the
  /// part its light is spread over; 0 when `position` is not in that part. The same whatever was asked for before, from
  /// any thread.
  float inverse_share(uint32_t photon, const SurfacePoint& at, Vec3 position, float radius2) const;
  size_t memory_bytes() const { return photons_ * sizeof(uint64_t); }

 private:
  uint64_t look_around(uint32_t photon, const SurfacePoint& at) const;

  const Scene* scene_ = nullptr;
  size_t photons_ = 0;
  float radius_ = 0.0f;
  uint32_t seed_ = 0;
  mutable std::unique_ptr<std::atomic<uint64_t>[]> known_;  ///< a byte a sector
};

}  // namespace ajar
