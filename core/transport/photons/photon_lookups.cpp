#include "transport/photons/photon_lookups.h"

#include <algorithm>

#include <tbb/parallel_for.h>

#include "transport/paths/walk.h"
#include "transport/photons/photon_gather.h"

namespace ajar {

namespace {

constexpr uint32_t kRays = 4096, kBlock = 256;
constexpr int kNeighbours = 8;
constexpr size_t kReachProbes = 256;
constexpr double kReachQuantile = 0.9;  // of the distances to the last neighbour

}  // namespace

PhotonLookups::PhotonLookups(const Scene& scene, const PathMedia* media, uint32_t seed) {
  const Vec2 film_size(float(scene.settings().width), float(scene.settings().height));
  struct Ends {
    bool found = false;
    SurfacePoint at[2];
  };
  std::vector<Ends> ends(kRays);
  const PhotonMaps no_maps;
  const GatherSettings settings;
  tbb::parallel_for(uint32_t(0), kRays / kBlock, [&](uint32_t block) {
    PhotonGatherer gatherer(scene, media, no_maps, settings, hash_combine(seed, 0x6c6f6f6bU));
    for (uint32_t i = block * kBlock; i < (block + 1) * kBlock; ++i) {
      Sampler& sampler = gatherer.start(0, i);
      const Vec2 film = film_size * sampler.get_2d();
      const Vec2 u_lens = scene.camera().has_lens() ? sampler.get_2d() : Vec2(0.5f);
      const Ray ray = scene.camera().generate_ray(film, u_lens, sample_time(scene, sampler));
      if (sees_nothing(ray)) continue;
      ends[i].found = gatherer.probe(ray, ends[i].at[ArrivalMap::kSeen], ends[i].at[ArrivalMap::kGathered]);
    }
  });
  for (int place = 0; place < 2; ++place) {
    std::vector<SurfacePoint>& points = points_[place];
    for (const Ends& e : ends)
      if (e.found) points.push_back(e.at[place]);
    std::vector<uint32_t> order;
    trees_[place].build(points, order);
    std::vector<float> distances;
    for (size_t i = 0; i < points.size(); i += std::max<size_t>(1, points.size() / kReachProbes)) {
      PointTree::Neighbours found;
      const float widest = scene.radius();
      found.radius2 = sqr(widest);
      trees_[place].nearest(points[i].position, unpack_direction(points[i].packed_normal), kNeighbours, widest, found);
      if (found.count == kNeighbours - 1) distances.push_back(std::sqrt(found.radius2));
    }
    if (distances.empty()) continue;
    const auto at = distances.begin() + std::ptrdiff_t(kReachQuantile * double(distances.size() - 1));
    std::nth_element(distances.begin(), at, distances.end());
    reach_[place] = *at;
  }
}

double PhotonLookups::density(Place place, Vec3 position, Vec3 normal) const {
  const float reach = reach_[place];
  if (!(reach > 0.0f)) return 0.0;
  PointTree::Neighbours found;
  found.radius2 = sqr(reach);
  trees_[place].nearest(position, normal, kNeighbours, reach, found);
  return found.count / (M_PI * double(found.radius2) * double(kRays));
}

Vec3 PhotonLookups::middle() const {
  const auto& points = points_[points_[ArrivalMap::kGathered].empty() ? ArrivalMap::kSeen : ArrivalMap::kGathered];
  glm::dvec3 sum(0.0);
  for (const SurfacePoint& point : points) sum += glm::dvec3(point.position);
  return points.empty() ? Vec3(0.0f) : Vec3(sum / double(points.size()));
}

}  // namespace ajar
