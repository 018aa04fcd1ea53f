// The photons of a pass, for display [Fan 2006, figures 4.2 and 4.4].
#pragma once

#include <cstdint>
#include <vector>

#include "math/types.h"

namespace ajar {

struct PhotonPoints {
  std::vector<Vec3> positions;  ///< world space
  std::vector<Color> powers;    ///< flux of each photon in watts
  uint64_t stored = 0;          ///< photons of the pass; the listed ones are an even selection of them

  /// With more than `max_count` photons, only every n-th is shown. Returns n.
  static uint64_t stride(uint64_t stored, uint64_t max_count) {
    return max_count > 0 ? stored / max_count + (stored % max_count != 0) : 0;
  }
};

}  // namespace ajar
