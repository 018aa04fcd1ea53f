// Metropolis photon sampling [Fan 2006, chapter 4; Fan, Chenney and Lai 2005].
//
// Chains of mutations sample complete paths from the lights to the eye in proportion to their luminance, and leave a photon
// on each where the final gather looks (path_photons.h): photons only where the picture needs them. Direct light is sampled, caustics come
// from a caustic map, all else from a final gather, as in photon mapping.
//
// Consistent: runs in passes with maps of their own whose radii shrink [Knaus and Zwicker 2011], with an error of the order of
// passes^(-1/3). Prefer it to photon mapping where most light never reaches the camera; what noise it leaves is the final gather's.
// Does not handle volumes.
//
// Departures from the thesis: photons carry the share of their path's way to the eye among all ways from their place (arrival_map.h),
// without which their powers are wrong; and chains start over from new bidirectional samples several times a pass, because few long
// ones leave blotches.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_mps();

}  // namespace ajar
