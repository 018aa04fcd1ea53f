// The columns of the control variates: for each sample of a mixture, the ratios z_j = p_j / K of the densities of its
// components [Fan 2006, section 6.3]. The densities are over directions: they are summed over all lights along the
// direction, visible or occluded, because their integrals are then 1.
//
// The columns are the lobes, then the groups of lights. Lobes that the surface does not have are columns with the ratio
// 1, which correct nothing. Every light that can be chosen must be intersected for every sample, so this is possible
// only for few lights.
#pragma once

#include <optional>
#include <vector>

#include "sampling/control_variates.h"
#include "transport/direct/light_mixture.h"

namespace ajar {

constexpr int kMaxControlSamples = 256;  ///< of one estimate

class ControlColumns {
 public:
  /// `lump`: all lights together are one column, for a single control variate.
  ControlColumns(const Scene& scene, const LightGroups& groups, bool lump);

  /// Whether the scene has few enough lights.
  bool possible() const { return possible_; }
  /// Number of columns for lights.
  int light_columns() const { return light_columns_; }
  /// `lobe_columns`: at least the number of lobe components of the surface.
  ControlSample sample(const DirectLightContext& c, const LightMixture::Kernel& k, int lobe_columns, int component,
                       const LightMixture::Draw& draw) const;

 private:
  struct Crossing {
    float distance;
    Vec3 normal;
  };
  static std::optional<Crossing> cross(const Light& light, Vec3 position, Vec3 wi);

  const Scene& scene_;
  const LightGroups& groups_;
  bool lump_, possible_ = false;
  int light_columns_;
  std::vector<Light> lights_;  // lights of the groups, for intersection
  std::vector<uint32_t> light_indices_;
};

}  // namespace ajar
