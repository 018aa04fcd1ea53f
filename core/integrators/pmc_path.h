// Population Monte Carlo path tracing: a population of paths that moves, learns, and is resampled [Fan 2006, section
// 5.5]. It is built as a sequential Monte Carlo sampler [Del Moral, Doucet and Jasra 2006], because kernels of bounded
// support make the published estimator biased.
//
// Unbiased; consistent with vertex merging (transport/bidirectional/vertex_merging.h). Two independent populations
// (transport/chains/path_population.h) run generations: new bidirectional samples are added, members are resampled by
// weight, all move by Metropolis-Hastings steps, and every step contributes to the estimate of the image. After the
// first generations, each population uses what the other one has learned: the shares of the mutations, and the
// luminance of the film, so that dark parts get more samples. Light that is seen directly or scattered once (LS*E,
// L(D)S*E) is sampled separately. The proposals of members include the artist's light hints
// (mutations/hint_mutation.h).
//
// Prefer it where light is hard to find and the image has bright and dark parts. In scenes with simple lighting, path
// tracing has less noise in the same time. The number of members bounds the memory. Limits, clamping and kinds of rays
// are as in bdpt.h. Media, subsurface scattering and motion are as in metropolis.h.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_pmc_path();

}  // namespace ajar
