#include "transport/photons/arrival_map.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

constexpr size_t kMaxArrivals = size_t(1) << 21;
constexpr double kGrowth = 1.5;       // the trees are rebuilt when the number of passes has grown by this factor
constexpr double kNeighbours = 16.0;  // for lookups of one pass; grows with the square root of the passes

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
      for (size_t i = 0; i < order.size(); ++i) half.tree_throughputs[i] = half.throughputs[order[i]];
    }
  passes_built_ = passes_;
}

double ArrivalMap::inverse_density(Place place, int half, Vec3 position, Vec3 normal, float radius) const {
  const Half& of = halves_[place][half];
  PointTree::Neighbours found;
  found.radius2 = radius * radius;
  const int neighbours = int(
      std::min(kNeighbours * std::sqrt(std::max(passes_built_, 1.0)), double(PointTree::kMaxNeighbours)));
  of.tree.nearest(position, normal, neighbours, radius, found);
  double sum = 0.0;
  for (int i = 0; i < found.count; ++i) sum += double(of.tree_throughputs[found.index[i]]);
  if (!(sum > 0.0)) return 0.0;
  // A half has half of the lookups.
  return M_PI * double(found.radius2) * 0.5 * passes_built_ / (sum * (found.count + 1.0) / found.count);
}

ArrivalMap::Factors ArrivalMap::factors(Place place, const Spot& spot, float radius, double chain_density,
                                        double plain_density) const {
  double inverse[2], share[2];
  for (int half = 0; half < 2; ++half) {
    inverse[half] = inverse_density(place, half, spot.position, spot.normal, radius);
    if (spot.both_sides) {
      const double back = inverse_density(place, half, spot.position, -spot.normal, radius);
      inverse[half] = inverse[half] > 0.0 && back > 0.0 ? inverse[half] * back / (inverse[half] + back)
                                                        : inverse[half] + back;
    }
    // Where no lookups are known, plain photons have all light.
    const double all = chain_density + plain_density * inverse[half];
    share[half] = inverse[half] > 0.0 && all > 0.0 ? chain_density / all : 0.0;
  }
  return {0.5 * (inverse[0] * share[1] + inverse[1] * share[0]), 1.0 - 0.5 * (share[0] + share[1])};
}

}  // namespace ajar
