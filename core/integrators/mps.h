// Metropolis photon sampling [Fan 2006, chapter 4; Fan, Chenney and Lai 2005].
//
// Chains of mutations sample complete paths from the lights to the eye in proportion to their luminance, and leave a
// photon on each where the final gather looks (path_photons.h): photons only where the picture needs them. As many
// plain photons are traced, and both weighed by their densities. Direct light is sampled, caustics come from a caustic
// map, all else from a final gather, as in photon mapping.
//
// Consistent: runs in passes with maps of their own whose radii shrink [Knaus and Zwicker 2011], with an error of the
// order of passes^(-1/3). Prefer it to photon mapping where most light never reaches the camera; what noise it leaves
// is the final gather's. Does not handle volumes.
//
// Departures from the thesis: photons carry the share of their path's way to the eye among all ways from their place
// (arrival_map.h), without which their powers are wrong; and plain photons stand in where few lookups are known, so
// that no power grows beyond theirs and no light is lost [after Veach 1997, section 9.2, the balance heuristic, by
// place].
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_mps();

}  // namespace ajar
