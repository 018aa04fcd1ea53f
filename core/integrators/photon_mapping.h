// Photon mapping with final gathering, in passes that make it consistent.
//
// Computes direct light by light sampling, caustics from a caustic map at the visible surface, and all other light by
// gather rays that look up a global map at their hits [Jensen 2001]. Each sample of a pixel has its own maps, and their
// radii shrink from pass to pass [Knaus and Zwicker 2011]. The mean of all passes therefore converges to the image of
// the path tracer, with an error of the order of passes^(-1/3). One pass is biased: blurred over the radius, and dark
// at edges. Prefer it where caustics of small lights matter and the whole scene is visible. The distribution of photons
// does not depend on the camera, but photons follow the artist's light hints (transport/hints/hint_guide.h), and where
// few of them would matter also learned starts (transport/hints/emission_training.h). Media,
// hair and walks below surfaces are path traced from the eye up to the next surface that stores photons; photons pass
// them too. Gather rays also start where a medium scatters a camera ray. All photons and samples of a pass have the
// same time. Bounce limits apply to the whole path (transport/photons/bounces_left.h), but that of transparent surfaces to
// each side of the map. Not handled: sharp lobes that a material has for some directions of view only (Layer Weight)
// scatter no photons that arrive from the others.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_photon_mapping();

}  // namespace ajar
