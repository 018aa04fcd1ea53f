// Energy redistribution path tracing: what stratified samples find is spread by short chains [Cline, Talbot and Egbert
// 2005; Fan 2006, section 3.4.2.7].
//
// Unbiased, without the filters of the paper; consistent with vertex merging
// (transport/bidirectional/vertex_merging.h). Every bidirectional sample starts a number of chains in proportion to its
// energy, rounded at random; every step of every chain deposits the same energy, shared between old path and proposal
// as the decision expects. The first quantum is fixed by samples that start no chain. Light seen or scattered once on
// its way (LS*E, L(D)S*E) is sampled apart.
//
// Unlike the paper's, chains follow luminance times the importance of the film (transport/paths/film_luminance.h), for
// even relative errors: learned, with the quantum, from all samples before, whenever their number has doubled. Given
// the past every sample's expectation is the picture, and all count alike.
//
// Spreads the noise of path tracing over the neighbourhood; prefer it to bdpt for caustics and light through narrow
// openings. Chains are too short to make up for paths that are rarely found (metropolis, pmc_pt do). Limits, clamping,
// kinds of rays and the artist's light paths as in bdpt.h. No volumes.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_erpt();

}  // namespace ajar
