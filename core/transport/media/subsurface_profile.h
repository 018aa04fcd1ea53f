// Subsurface scattering by a profile: the light that leaves an object at a distance from the point where it enters
// [Christensen and Burley 2015, "Approximate Reflectance Profiles for Efficient Subsurface Scattering", eq. 3].
//
// The exit is found by a probe ray through a disk around the entry [King, Kulla, Conty and Fajardo 2013, "BSSRDF
// Importance Sampling"], along the normal or across it, with the power heuristic over the three axes. As in Cycles, the
// profile is taken at the distance of the exit while its density on the disk is that of the distance from the axis, so
// that curved surfaces are brighter or darker than the profile alone would make them.
#pragma once

#include "transport/media/subsurface_walk.h"

namespace ajar {

/// The profile of width d, integrated over the directions around the entry: a density over distances up to the end of
/// the profile, 16 d. `u` is uniform.
float profile_density(float d, float distance);
float sample_profile(float d, float u);

/// As walk_below_surface, by the profile of the widths `shading.medium.radius`.
bool scatter_by_profile(const Scene& scene, const EntryPoint& entry, Pcg32& rng, ShadingPoint& point,
                        SurfaceShading& shading, Color& weight, uint64_t& rays);

}  // namespace ajar
