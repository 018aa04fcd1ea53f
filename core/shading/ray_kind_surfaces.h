// Surfaces that depend on the kind of the ray: they scatter light, or let it pass, in another way for rays of another kind
// or after other bounces. Their materials follow a Light Path node (window panes that are transparent for shadow rays,
// lamps that the camera does not see), or have no transparent shadows.
//
// Path tracing from the eye knows the kind of each ray, so it defines the image. A walk from a light does not know what
// kind of ray the path from the eye would have at a surface. Therefore all other techniques find the paths by way of
// such surfaces with walks from the eye only (transport/bidirectional/bidirectional.h, transport/photons/photon_gather.h).
#pragma once

#include "description/scene_description.h"

namespace ajar {

/// Whether the surface of this material is such a surface. Emission alone may depend on the kind of the ray.
bool depends_on_ray_kind(const MaterialDescription& material);

}  // namespace ajar
