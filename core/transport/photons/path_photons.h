// The photons that a complete path leaves for a final gather [Fan 2006, section 4.2.2, with the correction of
// arrival_map.h].
//
// Paths L(D|S)*DS*DS*E leave one in the global map at the second rough event from the eye, paths LS+DS*E one in the
// caustic map at the first; others none. Events are those of LobeSplit. A path whose vertices have both rough and sharp
// lobes (that are no deltas) stands for several such strings at once and leaves a photon for each place, with its
// share.
#pragma once

#include "transport/paths/path.h"
#include "transport/photons/arrival_map.h"
#include "transport/photons/photon_map.h"

namespace ajar {

struct PathPhoton {
  ArrivalMap::Place place = ArrivalMap::kGathered;  ///< seen: for the caustic map
  /// flux over cosine still to be multiplied with brightness / states, and the inverse density of lookups
  Photon photon;
  const PathVertex* vertex = nullptr;
};

/// At most two photons for each inner vertex of the path; returns how many. With brightness B of a chain's target and N
/// states a photon's flux is B / N * weight of the state * photon's * inverse density.
int photons_of(const PathSpace& space, const Path& path, PathPhoton* out);

}  // namespace ajar
