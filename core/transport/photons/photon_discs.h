// The surface around each photon that can receive its light.
//
// A density estimate divides by the area of a disc. Where the disc extends over the edge of an object, part of it
// contains no surface, and the estimate is too dark. Where it extends below the foot of a wall, the light of the next
// room leaks through. Here the disc of each photon is divided into eight sectors. A ray from above the photon to a
// point of the sector finds the surface (also a surface that is nearly parallel and lower or higher by at most 1/8 of
// the radius), a wall, or nothing. On curved surface, this ray meets other places than the one below the point: there a
// second, perpendicular ray decides. Only lookups on such surface, and in front of the wall of their sector, see the
// photon. Its density there is (tested + 0.35) / (found + 0.35) times that of the whole disc, which is nearly the
// reciprocal of the share p of the surface on average [after Hey and Purgathofer 2002, "Advanced radiance estimation
// for photon map global illumination", who compute that share from the triangles].
//
// On narrow surfaces all eight rays often find nothing. Then further rays count the failures before the first success,
// whose expectation is (1 - p) / p, up to kMaxFurther. The factor is 9 plus these failures. Lookups around such a
// photon test with a ray of their own whether they are on the surface that the disc's point sees.
//
// Where photons are dense, lookups need only a few of them and their discs are small. The rays of a photon are traced in
// a disc of about this size, so that they meet the edges and walls that matter.
//
// All this affects the bias only: for small radii every disc is whole. The rays of a photon are traced at its first
// lookup. The result takes 16 bytes per photon.
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
  /// receives its light; 0 when `position` is outside that area. `reach()` is the radius of a lookup at the photon. It is
  /// called at the first lookup. The result does not depend on earlier calls or on the thread.
  template <class Reach>
  float inverse_share(uint32_t photon, const SurfacePoint& at, Vec3 position, float radius2, Reach&& reach) const {
    const Around& around = around_[photon];
    uint64_t known = around.sectors.load(std::memory_order_acquire);
    if (known == 0) known = look_around(photon, at, reach());
    return inverse_share(known, around, at, position, radius2);
  }
  size_t memory_bytes() const { return photons_ * sizeof(Around); }

 private:
  /// What the rays around a photon found.
  struct Around {
    /// Six bits for each sector, the failures of further rays, the size of the disc, and flags; 0: unknown.
    std::atomic<uint64_t> sectors;
    std::atomic<uint64_t> walls;  ///< directions to the walls, a byte for each sector
  };
  struct Look;
  uint64_t look_around(uint32_t photon, const SurfacePoint& at, float reach) const;
  float inverse_share(uint64_t known, const Around& around, const SurfacePoint& at, Vec3 position, float radius2) const;
  bool sees(const SurfacePoint& at, Vec3 normal, Vec3 position, float height) const;

  const Scene* scene_ = nullptr;
  size_t photons_ = 0;
  float radius_ = 0.0f, time_ = 0.0f;
  uint32_t seed_ = 0;
  mutable std::unique_ptr<Around[]> around_;
};

}  // namespace ajar
