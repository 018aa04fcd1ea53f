#include "transport/direct/light_groups.h"

#include <algorithm>
#include <numeric>

namespace ajar {

namespace {

/// Minimum prior relative to an equal share. Lamps that face away from the scene's centre can still light the visible
/// part.
constexpr float kMinPrior = 0.25f;

struct Cluster {
  std::vector<LightSet::SourceRange> sources;
  double power = 0.0;
  Vec3 lower{kInfinity}, upper{-kInfinity};
  bool distant = false;
  double priority() const {
    return sources.size() < 2 ? -1.0 : power * double(glm::length(upper - lower)) + 1e-12 * double(sources.size());
  }
};

double power_of(const LightSet& lights, const LightSet::SourceRange& source) {
  double power = 0.0;
  for (uint32_t i = 0; i < source.count; ++i) power += double(lights.power_pmf(source.first + i));
  return power;
}

Cluster make_cluster(const LightSet& lights, std::vector<LightSet::SourceRange> sources) {
  Cluster cluster;
  cluster.distant = sources.front().distant;
  for (const LightSet::SourceRange& source : sources) {
    cluster.power += power_of(lights, source);
    cluster.lower = glm::min(cluster.lower, source.center);
    cluster.upper = glm::max(cluster.upper, source.center);
  }
  cluster.sources = std::move(sources);
  return cluster;
}

/// Splits a cluster into two of about equal size, along its longest axis. Ties keep the order of the description.
std::pair<Cluster, Cluster> split(const LightSet& lights, Cluster cluster) {
  const Vec3 extent = cluster.upper - cluster.lower;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
  auto& sources = cluster.sources;
  std::stable_sort(sources.begin(), sources.end(),
                   [&](const auto& a, const auto& b) { return a.center[axis] < b.center[axis]; });
  const auto middle = sources.begin() + std::ptrdiff_t(sources.size() / 2);
  return {make_cluster(lights, {sources.begin(), middle}), make_cluster(lights, {middle, sources.end()})};
}

}  // namespace

LightGroups::LightGroups(const LightSet& lights, int max_groups, Vec3 scene_center)
    : group_of_(lights.size(), int8_t(-1)), pmf_(lights.size(), 0.0f) {
  std::vector<LightSet::SourceRange> near, far;
  for (const LightSet::SourceRange& source : lights.sources()) (source.distant ? far : near).push_back(source);
  std::vector<Cluster> clusters;
  if (!near.empty()) clusters.push_back(make_cluster(lights, std::move(near)));
  if (!far.empty()) clusters.push_back(make_cluster(lights, std::move(far)));
  while (int(clusters.size()) < max_groups && !clusters.empty()) {
    const auto next = std::max_element(clusters.begin(), clusters.end(),
                                       [](const Cluster& a, const Cluster& b) { return a.priority() < b.priority(); });
    if (next->priority() < 0.0) break;
    auto [low, high] = split(lights, std::move(*next));
    *next = std::move(low);
    clusters.push_back(std::move(high));
  }
  // Few groups keep the order of the description, which the debug passes need.
  std::stable_sort(clusters.begin(), clusters.end(), [](const Cluster& a, const Cluster& b) {
    return a.sources.front().first < b.sources.front().first;
  });
  for (const Cluster& cluster : clusters) {
    Group group;
    std::vector<double> weights;
    for (const LightSet::SourceRange& source : cluster.sources) {
      for (uint32_t light = source.first; light < source.first + source.count; ++light) {
        const double power = double(lights.power_pmf(light));
        if (!(power > 0.0)) continue;
        group.lights.push_back(light);
        group.prior += lights.choice_pmf(scene_center, Vec3(0.0f), light);
        weights.push_back(power);
      }
    }
    if (group.lights.empty()) continue;
    group.by_power = DiscreteDistribution(weights);
    for (size_t i = 0; i < group.lights.size(); ++i) {
      group_of_[group.lights[i]] = int8_t(groups_.size());
      pmf_[group.lights[i]] = group.by_power.pmf(uint32_t(i));
    }
    groups_.push_back(std::move(group));
  }
  float sum = 0.0f;
  for (Group& group : groups_) sum += group.prior = std::max(group.prior, kMinPrior / float(groups_.size()));
  for (Group& group : groups_) group.prior /= sum;
}

uint32_t LightGroups::choose(int group, float u) const {
  const Group& g = groups_[size_t(group)];
  return g.lights[g.lights.size() == 1 ? 0 : g.by_power.sample(u).index];
}

float LightGroups::remapped(int group, float u) const { return groups_[size_t(group)].by_power.sample(u).u_remapped; }

}  // namespace ajar
