// Surfaces that depend on the kind of the ray: they scatter light, or let it pass, in another way for rays of another kind
// or after other bounces. Their materials follow a Light Path node (window panes that are transparent for shadow rays,
// lamps that the camera does not see), or have no transparent shadows. Objects that shadow rays see and diffuse rays do
// not, or the reverse, have such surfaces too (Scene::shadow_rays_differ): those that are hidden from shadow rays are as
// RayKinds::Shadow, with a transparency of 1, and those that are hidden from diffuse rays are as RayKinds::All.
//
// Path tracing from the eye knows the kind of each ray, so it defines the image. A walk from a light does not know what
// kind of ray the path from the eye would have at a surface.
//
// RayKinds::Shadow: only shadow rays differ. Paths by such surfaces are those of any other surface, except where the edge
// to the light passes one straight on. There, light samples and rays that hit the light find different light; the weights
// of multiple importance sampling in path tracing define how much of either counts. Other techniques find the former by
// light samples and by walks from lights that pass as shadow rays, and the latter by hits alone.
// RayKinds::All: only walks from the eye can go by way of such a surface (an *eye-only* surface).
//
// See transport/bidirectional/bidirectional.h and transport/photons/photon_gather.h.
#pragma once

#include <cstdint>

#include "description/scene_description.h"

namespace ajar {

/// The kinds of rays that differ from others at a surface.
enum class RayKinds : uint8_t { None, Shadow, All };
/// Those at the surface of this material, whatever rays see the object. Emission alone may depend on the kind of the
/// ray.
RayKinds ray_kinds_of(const MaterialDescription& material);

}  // namespace ajar
