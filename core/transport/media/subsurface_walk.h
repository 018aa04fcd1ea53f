// Light below the surface by a random walk: from where a path enters an object to where it leaves [Chiang, Kutz and
// Burley 2016].
//
// The medium's albedo of single scattering follows from the surface albedo that the artist asks for, by the fit of
// Kulla and Chiang (with anisotropy; Blender's numbers). Distances are drawn for one channel and weighed by the balance
// heuristic over all three. Walks of more than 256 steps, and those that leave the object through a hole in it, are
// lost, as in Cycles.
#pragma once

#include "math/random.h"
#include "scene/scene.h"

namespace ajar {

/// Coefficients of the medium inside, from the surface albedo and the mean free path of the reduced medium.
struct WalkMedium {
  Color extinction{0.0f};  ///< per metre
  Color albedo{0.0f};      ///< of single scattering
  Color factor{1.0f};      ///< on what the walk brings back; less than 1 where `albedo` had to be raised
};
WalkMedium walk_medium(const SubsurfaceMedium& medium);

/// From `point` on `entered`, whose lobes have this normal, through the inside of the same instance. True when the walk
/// leaves: `point` is then the exit, turned outwards, `bsdf` lets the light out, and `weight` is multiplied with what
/// it brings per unit of the subsurface lobes' weight over `medium.albedo`.
bool walk_below_surface(const Scene& scene, const Hit& entered, Vec3 normal, const SubsurfaceMedium& medium, Pcg32& rng,
                        ShadingPoint& point, Bsdf& bsdf, Color& weight, uint64_t& rays);

}  // namespace ajar
