// Metropolis light transport in path space [Veach 1997, chapter 11; Veach and Guibas 1997]: chains of
// mutations visit complete light paths in proportion to the luminance they bring to the film, relative to how bright
// the film is there (pilot_importance.h). The artist's light paths are among the mutations (mutations/hint_mutation.h).
//
// Consistent: the starting paths are drawn in proportion to their luminance from bidirectional samples, which makes a
// chain's expectation exact given the brightness of those samples; the brightness goes on being refined by more
// of them, so what remains is of the order of one over their number and vanishes with time. Light seen or scattered
// once on its way (LS*E, L(D)S*E) is sampled apart, without chains; with vertex merging also what no connection finds
// (transport/bidirectional/vertex_merging.h).
//
// Best where a few hard paths matter (light through a door ajar, caustics, glass lamps); in easily lit scenes path
// tracing has less noise for the time. Limits, clamping and kinds of rays as in bdpt.h. No volumes.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_metropolis();

}  // namespace ajar
