// Energy redistribution path tracing: short chains redistribute the energy of stratified samples [Cline, Talbot and
// Egbert 2005; Fan 2006, section 3.4.2.7].
//
// Unbiased, without the filters of the paper; consistent with vertex merging
// (transport/bidirectional/vertex_merging.h). Every bidirectional sample starts a number of chains in proportion to its
// energy, rounded at random. Every step of every chain deposits the same energy, divided between the old path and the
// proposal by the expectation of the decision. The first quantum is computed from samples that start no chain. Light
// that is seen directly or scattered once (LS*E, L(D)S*E) is sampled separately.
//
// Unlike in the paper, the target of the chains is luminance times the importance of the film
// (transport/paths/film_luminance.h), for even relative errors. The importance and the quantum are learned from all
// earlier samples whenever their number has doubled. Given the earlier samples, the expectation of every sample is the
// image, and all samples have the same weight.
//
// Spreads the noise of path tracing over the neighbourhood. Prefer it to bdpt for caustics and for light through narrow
// openings. The chains are too short to compensate for paths that are rarely found (metropolis and pmc_pt can). Limits,
// clamping, kinds of rays and the artist's light hints are as in bdpt.h. Chains visit vertices in media. Light that
// media emit is sampled separately (transport/bidirectional/direct_pass.h). Subsurface scattering is approximated.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_erpt();

}  // namespace ajar
