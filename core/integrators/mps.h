// Metropolis photon sampling [Fan 2006, chapter 4; Fan, Chenney and Lai 2005].
//
// Markov chains sample complete paths from the lights to the eye in proportion to their luminance. Each path stores
// photons where final gathering looks them up (path_photons.h), so photons are only where the image needs them. The
// same number of plain photons is traced, and both kinds are weighted by their densities. Direct light is sampled,
// caustics come from a caustic map, and all other light from final gathering, as in photon mapping.
//
// Consistent: passes have their own maps with shrinking radii [Knaus and Zwicker 2011], and the error is of the order
// of passes^(-1/3). Prefer it to photon mapping where most light never reaches the camera. The remaining noise is that
// of final gathering. Media, hair and walks below surfaces are path traced from the eye up to the next surface that
// stores photons. All samples of a pass have the same time. Where objects move, the importance is averaged over the
// shutter interval, and the image is biased.
//
// Differences from the thesis: the flux of a photon contains the share of its eye subpath among all eye subpaths from
// its position (arrival_map.h); without this factor the flux is wrong. Plain photons have the light that the weighted
// photons of chains leave, in the expectation (balance heuristic for each position) [after Veach 1997, section 9.2].
// Their weights can be negative, and so can single samples of the image.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_mps();

}  // namespace ajar
