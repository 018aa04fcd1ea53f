// The photons that a complete path stores for final gathering [Fan 2006, section 4.2.2, with the correction of
// arrival_map.h].
//
// A path L(D|S)*DS*DS*E stores a photon in the global map at the second rough event from the eye. A path LS+DS*E stores
// one in the caustic map at the first. Other paths store none. Events are those of LobeSplit. A path whose vertices
// have both rough lobes and sharp lobes (other than deltas) belongs to several such expressions at once. It stores a
// photon for each of them, with its share of the path's scattering. Nothing is stored nearer to the light than a surface
// with subsurface scattering: lookups behind it follow walks below it, which chains do not know, and are not logged.
// Nothing is stored in the global map for gather rays that are shorter than a limit: they gather again and look up
// nothing. The density of lookups grows without bound in corners if they count. And nothing is stored there where the
// surface scatters light from one direction to few others (scatters_evenly): a photon's flux is divided by the scattering
// towards the eye of its own path, which can be smaller by any factor than that towards the eye of a lookup. A pane of
// frosted glass had lost a sixth of its light in this way. Plain photons bring all of this light.
#pragma once

#include "transport/paths/path.h"
#include "transport/photons/arrival_map.h"
#include "transport/photons/photon_map.h"

namespace ajar {

struct PathPhoton {
  ArrivalMap::Place place = ArrivalMap::kGathered;  ///< kSeen: for the caustic map
  /// Flux over cosine, without the factors brightness / states and the inverse density of lookups.
  Photon photon;
  const PathVertex* vertex = nullptr;
};

/// `shortest`: length of the shortest gather rays that look up the global map. Writes at most two photons for each inner
/// vertex of the path and returns their number. Photons without a finite flux are left out and added to `refused`. For
/// the brightness B of the chain's target and N states, the flux of a photon is B / N * weight of the state * flux in
/// `photon` * inverse density.
int photons_of(const PathSpace& space, const Path& path, float shortest, PathPhoton* out, uint64_t& refused);

}  // namespace ajar
