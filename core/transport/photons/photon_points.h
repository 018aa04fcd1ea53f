// The photons of a pass, to be looked at [Fan 2006, figures 4.2 and 4.4].
#pragma once

#include <cstdint>
#include <vector>

#include "math/types.h"

namespace ajar {

struct PhotonPoints {
  std::vector<Vec3> positions;  ///< world space
  std::vector<Color> powers;    ///< watts that each photon brings
  uint64_t stored = 0;          ///< photons of that pass, of which these are spread evenly over space

  /// Only every n-th of so many photons is shown where there are more than `most`.
  static uint64_t stride(uint64_t stored, uint64_t most) { return most > 0 ? stored / most + (stored % most != 0) : 0; }
};

}  // namespace ajar
