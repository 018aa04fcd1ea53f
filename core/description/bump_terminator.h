// How light fades at grazing angles on a surface with a bumped normal. Without this, diffuse light on a bumped normal
// would also arrive from below the smooth surface and end there in a hard edge.
#pragma once

#include <cstdint>

namespace ajar {

enum class BumpTerminator : uint8_t {
  Cubic,       ///< cubic of the cosines [Chiang, Li and Burley 2019, "Taming the Shadow Terminator"]; Blender until 4.4
  Microfacet,  ///< GGX shadowing [Conty Estevez, Lecocq and Stein 2019]; Blender since 4.5
  None         ///< does not fade: a material without Bump Map Correction
};

}  // namespace ajar
