// What scattering at a surface with subsurface scattering is worth, as a property of whole paths.
//
// Where light enters such a surface, its lobe stands for a walk below the surface (media/subsurface_walk.h). Elsewhere
// it stands for diffuse reflection. In Cycles before Blender 5.0, light enters only if the path from the eye has not been
// scattered diffusely before, so that the value of the lobe depends on the history of the path from the eye.
//
// The space of paths is divided: paths with a walk, and paths without one. Only walks from the eye find the former
// (bidirectional.h). The latter are ordinary paths. All their vertices have all lobes (ShadingPoint::marks_subsurface),
// from which walks sample and whose densities count. The contribution of the path has the factor of this class: at a
// vertex where light would enter, the share of the lobes that stay at the surface. The bounces before are counted as the
// path tracer counts them, by the kinds of the lobes that it samples. A vertex with several kinds divides the path into
// several histories, with the probabilities of BounceCount.
#pragma once

#include <vector>

#include "transport/paths/path_vertex.h"

namespace ajar {

/// Whether light can enter the surface at a vertex, after a suitable history.
inline bool can_enter(const PathVertex& vertex) {
  return vertex.kind == VertexKind::Surface && vertex.shading.bsdf.has_subsurface() && !on_strand(vertex.point);
}
/// Whether it enters, `after_diffuse`: after a bounce by a diffuse lobe.
inline bool enters(const PathVertex& vertex, bool after_diffuse) {
  return can_enter(vertex) && (!after_diffuse || vertex.shading.medium.after_diffuse);
}

/// Vertices are added in the order from the eye.
class EyeHistory {
 public:
  /// `limits`: those of kinds of bounces; null if they do not matter for the path. They must outlive the history.
  explicit EyeHistory(const BounceLimits* limits) : limits_(limits), states_{State()} {}
  /// Starts at a point that a walk from the eye has reached, after this number of collisions in media.
  void start(const ShadingPoint& point, int collisions);
  /// Scattering at an inner vertex that is not the neighbour of the light.
  void add(const PathVertex& vertex, Vec3 to_eye, Vec3 to_light, bool specular);
  /// Scattering at the neighbour of the light, which is not counted.
  void end(const Scene& scene, const PathVertex& light, const PathVertex& vertex, Vec3 to_eye, Vec3 to_light,
           bool specular);
  Color factor() const;

 private:
  struct State {
    int diffuse = 0, glossy = 0, transmission = 0;
    bool after_diffuse = false;
    Color factor{1.0f};
  };
  void extend(std::vector<State>& next, State state) const;

  const BounceLimits* limits_;
  int collisions_ = 0;
  std::vector<State> states_;
};

}  // namespace ajar
