// Subsurface scattering by a random walk, from the point where a path enters an object to the point where it leaves
// [Chiang, Kutz and Burley 2016].
//
// The single scattering albedo of the medium is computed from the surface albedo that the artist sets, by the fit of
// Kulla and Chiang (with anisotropy; Blender's coefficients), or since Blender 5.2 by the equation of d'Eon. Steps are
// sampled for one channel, most of them towards the surface [Krivanek and d'Eon 2014], and weighted by the balance
// heuristic. After ten steps, an anisotropic medium is replaced by the isotropic one of equal diffusion (similarity;
// Wyman et al. 1989). Walks of more than 256 steps, and walks that leave the object through a hole, contribute nothing.
// Both as in Cycles.
#pragma once

#include "math/random.h"
#include "scene/scene.h"

namespace ajar {

/// Coefficients of the medium below the surface, from the surface albedo and the mean free path.
struct WalkMedium {
  Color extinction{0.0f};   ///< per metre
  Color albedo{0.0f};       ///< single scattering albedo
  float anisotropy = 0.0f;  ///< mean cosine of scattering
  Color factor{1.0f};       ///< factor on the result of the walk; less than 1 if `albedo` had to be raised
};
WalkMedium walk_medium(const SubsurfaceMedium& medium);
/// The isotropic medium in which light diffuses in the same way.
WalkMedium similar_isotropic(const WalkMedium& medium);

/// Where a walk goes below the surface.
struct EntryPoint {
  uint32_t instance;
  Vec3 normal;   ///< of the subsurface lobes
  float choice;  ///< a stratified number that chooses the way of sampling
};

/// A walk inside the instance that is entered at `point`. Returns true if the walk leaves the object. Then `point` is
/// the exit, with normals outwards, `shading.bsdf` is the lobe by which the light leaves, and `weight` is multiplied by
/// the throughput of the walk per weight of the subsurface lobes over `shading.medium.albedo`.
bool walk_below_surface(const Scene& scene, const EntryPoint& entry, Pcg32& rng, ShadingPoint& point,
                        SurfaceShading& shading, Color& weight, uint64_t& rays);

/// The first surface of this instance along the ray. Surfaces of other instances are ignored.
Hit find_own_surface(const Scene& scene, uint32_t instance, Ray ray, uint64_t& rays);
/// Makes the surface a diffuse lobe by which light leaves at `point`. The normal of the lobe is that of the closures
/// with subsurface scattering there. `seen_from`: the direction for which they are evaluated; bumped normals are bent so
/// that this direction could be reflected. As in Cycles, it is that in which a walk goes on.
void leave_surface(const ShaderProgram& program, const ShadingPoint& point, Vec3 seen_from, SurfaceShading& shading);

/// Random numbers for the choice below, and for the walk.
struct SubsurfaceNumbers {
  float u;
  uint32_t stream;
};
/// Either scatters below the surface at `point`, which becomes the exit (walk_below_surface or scatter_by_profile), or
/// stays with its other lobes. `beta` is weighted by the probability of the choice. False if the walk is lost, or no other lobes remain.
bool walk_below_or_stay(const Scene& scene, uint32_t instance, SubsurfaceNumbers numbers, ShadingPoint& point,
                        SurfaceShading& shading, Color& beta, uint64_t& rays);

}  // namespace ajar
