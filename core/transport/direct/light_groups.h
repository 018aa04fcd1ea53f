// The lights of a scene in a few groups, which are the components from which direct light learns to choose.
//
// If there are few, each lamp, each emissive instance and the environment is a group. Otherwise they are clustered by
// position: the group with the largest power times extent is split in the middle until there are enough groups. Distant
// lights have groups of their own. Inside a group, a light is chosen by power. The groups depend only on the scene, so
// they have the same meaning in every iteration.
#pragma once

#include <vector>

#include "lights/light_set.h"
#include "math/distribution.h"

namespace ajar {

class LightGroups {
 public:
  LightGroups() = default;
  LightGroups(const LightSet& lights, int max_groups, Vec3 scene_center);

  int size() const { return int(groups_.size()); }
  /// The approximate share of a group in LightSet::choose for a point in the middle of the scene. It is always
  /// positive. The sum is 1.
  float prior(int group) const { return groups_[size_t(group)].prior; }
  /// -1 for lights of unknown power, which are in no group
  int group_of(uint32_t light) const { return group_of_[light]; }
  float pmf_in_group(uint32_t light) const { return pmf_[light]; }
  uint32_t choose(int group, float u) const;
  /// The rest of u after the choice, which is uniform again.
  float remapped(int group, float u) const;
  const std::vector<uint32_t>& lights(int group) const { return groups_[size_t(group)].lights; }

 private:
  struct Group {
    std::vector<uint32_t> lights;
    DiscreteDistribution by_power;
    float prior = 0.0f;
  };
  std::vector<Group> groups_;
  std::vector<int8_t> group_of_;
  std::vector<float> pmf_;
};

}  // namespace ajar
