// Bidirectional path tracing: walks from the eye and from the lights, joined in every way and weighted by multiple
// importance sampling over all of them [Veach 1997, chapter 10; Lafortune and Willems 1993].
//
// Unbiased; consistent with vertex merging (transport/bidirectional/vertex_merging.h). The choice where light arrives
// indirectly everywhere (lamps in shades, caustics seen directly); worse than path tracing where lights are easily
// seen, for each sample costs several rays more. Caustics of small lights seen through glass remain luck without
// merging. Bounce limits mean what they do in the path tracer, up to kMaxPathVertices. Clamping is ignored (it would
// not know direct from indirect). Visibility by kind of ray and the Light Path node are answered for a diffuse bounce
// where a vertex was found from the light. Walks from lights follow the artist's light paths
// (transport/hints/hint_guide.h). No volumes.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_bdpt();

}  // namespace ajar
