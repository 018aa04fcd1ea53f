// Metropolis light transport in path space [Veach 1997, chapter 11; Veach and Guibas 1997]: chains visit complete paths
// in proportion to their luminance on the film, relative to the luminance of the film at that position
// (pilot_importance.h). The mutations include the artist's light hints (mutations/hint_mutation.h).
//
// Consistent: starting paths are drawn from bidirectional samples in proportion to their luminance, which makes the
// expectation of a chain exact for the brightness of these samples. Further samples continue to improve the brightness.
// The remaining bias is of the order of one over the number of samples and vanishes with time. Light that is seen
// directly or scattered once (LS*E, L(D)S*E) is sampled separately, without chains. With vertex merging this also
// applies to paths that cannot be connected (transport/bidirectional/vertex_merging.h).
//
// Prefer it where a few difficult paths matter (light through a door ajar, caustics, glass lamps). In scenes with
// simple lighting, path tracing has less noise in the same time. Limits, clamping and kinds of rays are as in bdpt.h.
// Media, subsurface scattering and motion are as in erpt.h; the bidirectional mutation also changes the time of a path.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_metropolis();

}  // namespace ajar
