#include "transport/photons/arrival_map.h"

namespace ajar {

namespace {

constexpr size_t kMaxArrivals = size_t(1) << 21;
constexpr double kGrowth = 1.5;  // the trees are rebuilt when the number of passes has grown by this factor
constexpr int kNeighbours = 16;

}  // namespace

void ArrivalMap::add(const std::vector<ArrivalLog>& pass) {
  if (points_[kSeen].size() + points_[kGathered].size() >= kMaxArrivals) return;
  passes_ += 1.0;
  for (const ArrivalLog& part : pass)
    for (int place = 0; place < 2; ++place)
      for (const Arrival& arrival : part.at[place]) {
        points_[place].push_back(arrival.point);
        throughputs_[place].push_back(arrival.throughput);
      }
  if (passes_ < kGrowth * passes_built_) return;
  std::vector<uint32_t> order;
  for (int place = 0; place < 2; ++place) {
    trees_[place].build(points_[place], order);
    tree_throughputs_[place].resize(order.size());
    for (size_t i = 0; i < order.size(); ++i) tree_throughputs_[place][i] = throughputs_[place][order[i]];
  }
  passes_built_ = passes_;
}

double ArrivalMap::inverse_density(Place place, Vec3 position, Vec3 normal, float radius) const {
  PointTree::Neighbours found;
  found.radius2 = radius * radius;
  trees_[place].nearest(position, normal, kNeighbours, radius, found);
  double sum = 0.0;
  for (int i = 0; i < found.count; ++i) sum += double(tree_throughputs_[place][found.index[i]]);
  if (!(sum > 0.0)) return 0.0;
  return M_PI * double(found.radius2) * passes_built_ / (sum * (found.count + 1.0) / found.count);
}

double ArrivalMap::inverse_density_of_both_sides(Place place, Vec3 position, Vec3 normal, float radius) const {
  const double front = inverse_density(place, position, normal, radius),
               back = inverse_density(place, position, -normal, radius);
  return front > 0.0 && back > 0.0 ? front * back / (front + back) : front + back;
}

}  // namespace ajar
