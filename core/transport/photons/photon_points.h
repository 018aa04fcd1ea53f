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

  /// With more than `most` photons, only every n-th is shown. Returns n.
  static uint64_t stride(uint64_t stored, uint64_t most) { return most > 0 ? stored / most + (stored % most != 0) : 0; }
};

}  // namespace ajar
