// The lights of a scene in a few groups, the components among which direct light learns to choose.
//
// A lamp, an emissive instance and the environment each are a group while there are few; many are gathered by
// place: the group of largest power times extent is split at its middle until there are enough. Distant lights stay
// apart. Inside a group a light is chosen by power. Fixed by the scene, so that groups mean the same in every
// iteration.
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
  /// About the share of a group in LightSet::choose for a point amid the scene; never nothing, and 1 in all.
  float prior(int group) const { return groups_[size_t(group)].prior; }
  /// -1 for lights that belong to none: nothing is known of their power.
  int group_of(uint32_t light) const { return group_of_[light]; }
  float pmf_in_group(uint32_t light) const { return pmf_[light]; }
  uint32_t choose(int group, float u) const;
  /// What choosing leaves of u, uniform again.
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
