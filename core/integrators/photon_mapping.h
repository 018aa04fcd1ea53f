// Photon mapping with final gather, in passes that make it consistent.
//
// Computes direct light by light sampling, caustics from a caustic map at the surface seen, all other light by gather
// rays whose hits look up a global map [Jensen 2001]. Each sample of a pixel has maps of its own, and their radii
// shrink from pass to pass [Knaus and Zwicker 2011], so the mean of all passes converges to the image of the path
// tracer, with an error of the order of passes^(-1/3). One pass is biased: blurred over the radius, dark at edges.
// Prefer it where caustics of small lights matter and all of the scene is in view; photons do not know where the camera
// is, but follow the artist's light paths (transport/hints/hint_guide.h). Does not handle volumes. Bounce limits hold
// on each side of the map, not on the whole path.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_photon_mapping();

}  // namespace ajar
