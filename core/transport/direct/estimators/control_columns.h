// The columns of the control variates: for each sample of a mixture, the ratios z_j = p_j / K of the densities of its
// components [Fan 2006, section 6.3]. Ratios are over directions: the sum over all lights crossed, hidden or not,
// because their integrals are then 1.
//
// Columns: the lobes, those that the surface does not have with the ratio 1, which corrects nothing; then the groups of
// lights. Every light that could be chosen must be intersected at every sample, so this is possible for few lights
// only.
#pragma once

#include <optional>
#include <vector>

#include "sampling/control_variates.h"
#include "transport/direct/light_mixture.h"

namespace ajar {

constexpr int kMaxControlSamples = 256;  ///< of an estimate

class ControlColumns {
 public:
  /// `lump`: all lights are one column, for a single control variate.
  ControlColumns(const Scene& scene, const LightGroups& groups, bool lump);

  /// Are there few enough lights?
  bool possible() const { return possible_; }
  /// Columns for lights.
  int light_columns() const { return light_columns_; }
  /// `lobe_columns`: at least as many as the surface has lobes.
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
  std::vector<Light> lights_;  // those of the groups, for intersection
  std::vector<uint32_t> light_indices_;
};

}  // namespace ajar
