// What passes need of the surfaces on a path from the eye: data of the first hit, guides of a denoiser, and data of all
// surfaces that the camera ray sees through transparent ones.
//
// The first hit is the first surface that the camera ray sees whose alpha is at least the threshold of the view layer, as
// in Cycles. AOV Output nodes write at this surface and at those before it, times the throughput.
#pragma once

#include "film/film.h"
#include "scene/scene.h"
#include "transport/paths/eye_walk.h"

namespace ajar {

/// Whether the walk may pass the surface straight and then find another one. Walks that choose at once whether they
/// stop at a transparent surface find only one.
enum class BehindFirst : uint8_t { Found, NotFound };

/// The part of record_vertex for paths with a pass.
SampleAux* record_surface(const Scene& scene, const ShadingPoint& point, const Bsdf& bsdf, Color beta,
                          BehindFirst behind, SampleAux*& aux);

/// Records what the passes need of a surface on a path from the eye with the throughput `beta`. Returns `aux` at the
/// first hit, else null. `aux` becomes null when nothing more is needed.
inline SampleAux* record_vertex(const Scene& scene, const ShadingPoint& point, const Bsdf& bsdf, Color beta,
                                SampleAux*& aux, BehindFirst behind = BehindFirst::Found) {
  return aux ? record_surface(scene, point, bsdf, beta, behind, aux) : nullptr;
}

/// Records what the guides of a denoiser need of a medium on a path from the eye. Its light scatters there, or passes;
/// the throughput was `before` and becomes `after`.
void record_medium(Vec3 direction, Color before, Color after, bool scatters, SampleAux* aux);
/// The same for a path that is split: a part of its light scatters, and a part passes. `u` decides whether this sample
/// shows the surface behind in passes that have no weights.
void record_split(Vec3 direction, Color before, Color scattered, Color passing, float u, SampleAux* aux);

/// The part of record_background for paths with AOVs.
void record_world(const Scene& scene, Vec3 direction, Color beta, SampleAux& aux);
/// Records the AOVs of the world for a ray that leaves the scene, `seen` if it comes from the camera.
inline void record_background(const Scene& scene, Vec3 direction, bool seen, Color beta, SampleAux* aux) {
  if (aux && aux->extras && aux->extras->aov_passes && seen) record_world(scene, direction, beta, *aux);
}

/// The same for a walk. Returns the alpha of what it sees there.
inline float record_nothing(const Scene& scene, const EyeWalk& walk, Color beta, SampleAux* aux) {
  record_background(scene, walk.ray.direction, walk.seen_directly(), beta, aux);
  return walk.alpha_of_nothing(beta);
}

}  // namespace ajar
