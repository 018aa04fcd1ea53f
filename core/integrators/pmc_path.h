// Population Monte Carlo path tracing: a population of light paths that moves, learns, and is drawn again [Fan 2006,
// section 5.5], built as a sequential Monte Carlo sampler [Del Moral, Doucet and Jasra 2006] since kernels of bounded
// support make the published estimator biased.
//
// Unbiased; consistent with vertex merging (transport/bidirectional/vertex_merging.h). Two populations that know
// nothing of one another (transport/chains/path_population.h) go through generations: new bidirectional samples enter,
// members are drawn by weight, all move by Metropolis-Hastings steps, and every step is an estimate of the image. After
// the first generations each goes on with what the other has learned by then: how often to use which mutation, and
// where the film is dark, to dwell there longer. Light seen or scattered once on its way (LS*E, L(D)S*E) is sampled
// apart. The artist's light paths are among what its members propose (mutations/hint_mutation.h).
//
// Prefer it where light is hard to find and the picture has bright and dark parts. In easily lit scenes path tracing
// has less noise for the time. Memory is bounded by the number of members. Limits, clamping and kinds of rays as in
// bdpt.h. No volumes.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_pmc_path();

}  // namespace ajar
