// Bidirectional path tracing: walks from the eye and from the lights, connected in all ways and weighted by multiple
// importance sampling over all of them [Veach 1997, chapter 10; Lafortune and Willems 1993].
//
// Unbiased; consistent with vertex merging (transport/bidirectional/vertex_merging.h). Prefer it where most light is
// indirect (lamps in shades, caustics that are seen directly). It is less efficient than path tracing where lights are
// visible, because each sample costs several more rays. Without merging, caustics of small lights that are seen through
// glass are found only with small probability. Bounce limits have the same meaning as in the path tracer, up to
// kMaxPathVertices. Clamping is ignored, because direct and indirect light are not separated. If a vertex was found
// from the light, its visibility by kind of ray and the Light Path node are evaluated for a diffuse bounce. Walks from
// lights follow the artist's light hints (transport/hints/hint_guide.h). Vertices can be in media. Subsurface
// scattering is approximated by diffuse reflection. A camera at which film points and directions do not
// correspond one to one is not connected to paths from lights.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_bdpt();

}  // namespace ajar
