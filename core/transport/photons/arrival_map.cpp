#include "transport/photons/arrival_map.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

constexpr size_t kMaxArrivals = size_t(1) << 21;
constexpr double kGrowth = 1.5;  // the trees are rebuilt when the number of passes has grown by this factor
/// Nearest lookups in an estimate. Few, so that it follows an importance that varies within the radius. Its noise is
/// nearly independent at each photon.
constexpr int kNeighbours = 32;
/// Where lookups are few, most of the light is left to plain photons, whose factors are then not far below 0.
constexpr double kPrior = 4.0;

}  // namespace

size_t ArrivalMap::stored() const {
  size_t sum = 0;
  for (const auto& place : halves_)
    for (const Half& half : place) sum += half.points.size();
  return sum;
}

void ArrivalMap::add(const std::vector<ArrivalLog>& pass) {
  if (stored() >= kMaxArrivals) return;
  passes_ += 1.0;
  for (const ArrivalLog& part : pass)
    for (int place = 0; place < 2; ++place)
      for (const Arrival& arrival : part.at[place]) {
        Half& half = halves_[place][arrival.half & 1];
        half.points.push_back(arrival.point);
        half.throughputs.push_back(arrival.throughput);
      }
  if (passes_ < kGrowth * passes_built_) return;
  std::vector<uint32_t> order;
  for (auto& place : halves_)
    for (Half& half : place) {
      half.tree.build(half.points, order);
      half.tree_throughputs.resize(order.size());
      double sum = 0.0;
      for (size_t i = 0; i < order.size(); ++i) sum += double(half.tree_throughputs[i] = half.throughputs[order[i]]);
      half.mean_throughput = order.empty() ? 0.0 : sum / double(order.size());
    }
  passes_built_ = passes_;
}

template <class InLookup>
ArrivalMap::Estimate ArrivalMap::estimate(Place place, int half, const SurfacePoint& at, float radius,
                                          InLookup&& in_lookup) const {
  const Half& of = halves_[place][half];
  if (of.tree.empty()) return {0.0, 0.0};
  PointTree::Neighbours found;
  of.tree.nearest(at.position, unpack_direction(at.packed_normal), kNeighbours, radius, found, other_side(at));
  double sum = 0.0;
  for (int i = 0; i < found.count; ++i) {
    const uint32_t lookup = found.index[i];
    const float factor = in_lookup(of.tree[lookup].position, found.distance2[i], found.radius2);
    sum += double(of.tree_throughputs[lookup] * factor);
  }
  return {per_area(sum, double(found.radius2)), per_area(sum + kPrior * of.mean_throughput, double(found.radius2))};
}

double ArrivalMap::density(Place place, int half, const SurfacePoint& at, float radius) const {
  return estimate(place, half, at, radius, [](Vec3, float, float) { return 1.0f; }).density;
}

ArrivalMap::Factors ArrivalMap::factors(Place place, const PhotonMap::Weighable& photon, float radius,
                                        double chain_density, double plain_density) const {
  const SurfacePoint& at = photon.point();
  const SurfacePoint behind{at.position, pack_direction(-unpack_direction(at.packed_normal)) | other_side(at)};
  const auto in_lookup = [&](Vec3 position, float distance2, float radius2) {
    return photon.in_lookup(position, distance2, radius2);
  };
  Estimate w[2];
  for (int half = 0; half < 2; ++half) {
    w[half] = estimate(place, half, at, radius, in_lookup);
    if (!photon.has(Photon::kTransmits)) continue;
    const Estimate more = estimate(place, half, behind, radius, in_lookup);
    w[half].density += more.density, w[half].with_prior += more.with_prior;
  }
  Factors mean{0.0, 1.0};
  for (int half = 0; half < 2; ++half) {
    const double all = plain_density + chain_density * w[half].with_prior;
    const double of_chain = all > 0.0 ? chain_density / all : 0.0;
    mean.of_chain += 0.5 * of_chain;
    mean.plain -= 0.5 * of_chain * w[1 - half].density;
  }
  return mean;
}

}  // namespace ajar
