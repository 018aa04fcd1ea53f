// Where an image looks up photon maps: a few of its camera rays and gather rays, and the density of their ends.
#pragma once

#include "transport/media/path_media.h"
#include "transport/photons/arrival_map.h"

namespace ajar {

class PhotonLookups {
 public:
  PhotonLookups() = default;
  /// Of the full frame, so that a region is rendered by the same photons. `media`: of the scene; null if it has none.
  PhotonLookups(const Scene& scene, const PathMedia* media, uint32_t seed);

  using Place = ArrivalMap::Place;
  bool empty() const { return points_[ArrivalMap::kSeen].empty() && points_[ArrivalMap::kGathered].empty(); }
  const std::vector<SurfacePoint>& points(Place place) const { return points_[place]; }
  /// Mean number of lookups per area for each camera ray. A rough estimate, from the nearest few.
  double density(Place place, Vec3 position, Vec3 normal) const;
  /// The mean of the points of gather rays, or of camera rays if there are none.
  Vec3 middle() const;

 private:
  std::vector<SurfacePoint> points_[2];
  PointTree trees_[2];
  float reach_[2] = {0.0f, 0.0f};  ///< largest radius of an estimate
};

}  // namespace ajar
