// What light paths are made of: vertices, the edges between them, and scattering, with their densities.
//
// A path's vertices go from the light (0) to the eye (count - 1).
// Everything is written for light that travels to the eye. At a vertex, `to_light` and `to_eye` are the directions to
// its neighbours, and its scattering is the radiance form f |cos(to_light)| whichever side the vertex was found from,
// so that a path has one contribution and no adjoint appears (shading normals included; Veach 1997, section 5.3).
//
// Measures [Veach 1997, section 8.2]. Densities of vertices are per area; of a light at infinity per solid angle of
// its direction. Edge i joins vertices i and i + 1. With to_light_area(i) = |cos at the light end| / d^2,
//
//   f(x) = Le  prod_i scattering[i].f  prod_i transmittance[i] to_light_area[i]  W,
//
// W being pixels^2 per solid angle, averaged over the lens: the integral of f is the sum of all pixels (before their
// filters). A walk from the eye has density pdf_to_light * to_light_area for its next vertex, one from the light
// pdf_to_eye * to_eye_area.
//
// Specular vertices: f, pdf_to_light and pdf_to_eye are the factors of one delta function, the one over
// to_light given to_eye; they cancel in every ratio [Veach, section 8.3.3]. pdf_to_eye therefore holds the Jacobian
// d(to_light) / d(to_eye) of refraction.
//
// Surfaces that let light straight through are no vertices there. A walk passes each with a probability that depends on
// the surface only; an edge carries the product of those probabilities beside its transmittance.
#pragma once

#include <optional>
#include <vector>

#include "sampling/sampler.h"
#include "scene/scene.h"

namespace ajar {

class LightWalkGuide;

enum class VertexKind : uint8_t { Surface, Light, Lens };

struct PathVertex {
  VertexKind kind = VertexKind::Surface;
  bool specular = false;                   ///< scatters by a delta lobe in its path
  bool distant = false;                    ///< light at infinity, or the lens of an orthographic camera
  bool delta = false;                      ///< light that no ray can hit
  int light = -1;                          ///< Light: which. Surface: its own, when it emits
  float pass = 0.0f;                       ///< probability that a walk goes straight through instead of stopping here
  const ShaderProgram* program = nullptr;  ///< of surfaces and emissive triangles
  /// Surface: as shaded. Light, Lens: position and ng (outward; for distant ones the direction away from it).
  ShadingPoint point;
  SurfaceShading shading;  ///< made for point.wo; lobes without transparency

  Vec3 position() const { return point.position; }
  bool connectable() const { return kind != VertexKind::Surface || shading.bsdf.has_non_delta(); }
  bool emits() const { return !is_black(shading.emission); }
};

struct PathEdge {
  Vec3 to_eye{0.0f};                               ///< unit direction from the light end to the eye end
  float inverse_square = 1.0f;                     ///< 1 / d^2; 1 when one end is at infinity
  float cos_light_end = 1.0f, cos_eye_end = 1.0f;  ///< |ng . direction|; 1 where there is no surface
  float pass = 1.0f;                               ///< probability that a walk passes all surfaces in between
  Color transmittance{1.0f};

  /// Solid angle at one end to area at the other.
  float to_light_area() const { return cos_light_end * inverse_square; }
  float to_eye_area() const { return cos_eye_end * inverse_square; }
};

/// What happens at an inner vertex for one pair of directions; densities per solid angle.
struct Scattering {
  Color f{0.0f};                 ///< f |cos(to_light)|; the weight when specular
  float pdf_to_light = 0.0f;     ///< of a walk from the eye, over to_light
  float pdf_to_eye = 0.0f;       ///< of a walk from the light by the BSDF, over to_eye
  float pdf_walk_to_eye = 0.0f;  ///< the same of one that may follow hints (light_walk_guide.h)
  /// Specular only: the same for walks that keep the kind of bounce (Bsdf::follow_specular).
  float follow_to_light = 0.0f, follow_to_eye = 0.0f;
};

/// Geometry of the edge between two vertices, visibility not looked at.
PathEdge join(const PathVertex& light_end, const PathVertex& eye_end);

/// Scattering at a surface vertex, exact for both directions of travel whichever the vertex was found from.
Scattering scatter(const PathVertex& vertex, Vec3 to_eye, Vec3 to_light, bool specular, const LightWalkGuide* guide);

/// A direction for a walk that arrives from `wo`, from the lobes as made for it.
std::optional<BsdfSample> sample_direction(const PathVertex& vertex, Vec3 wo, float u_lobe, Vec2 u);
/// The same for a walk that repeats a specular bounce of this kind.
std::optional<BsdfSample> follow_direction(const PathVertex& vertex, Vec3 wo, bool transmitted, float u_lobe);

/// Probability with which walks pass a surface that lets `transparency` through.
float pass_probability(const ShaderProgram& program, Color transparency);

/// Whether photons leave from here. Paths from other lights are nobody's but the walk's.
inline bool sends_photons(const Scene& scene, const PathVertex& light) {
  return light.light >= 0 && !light.distant && scene.lights().power_pmf(uint32_t(light.light)) > 0.0f;
}

/// What light end and camera contribute to a path, and with what densities they are found.
struct LightEnd {
  Color radiance{0.0f};       ///< emitted along the first edge
  float pdf_origin = 0.0f;    ///< of vertex 0 for walks from lights, probability of the light included
  float pdf_by_power = 0.0f;  ///< the same for walks that know no hints
  /// of the first edge for such walks: per solid angle; per area across it for distant lights
  float pdf_direction = 0.0f;
  float pdf_sampled = 0.0f;  ///< of vertex 0 for light sampling at vertex 1
  bool can_be_hit = false;   ///< by walks from the eye
};
LightEnd light_end(const Scene& scene, const PathVertex& light, const PathVertex& next, const PathEdge& edge,
                   const LightWalkGuide* guide);

/// Pixels^2 per solid angle along the last edge (see Camera::film_density).
inline float lens_density(const Scene& scene, const PathEdge& last) {
  return scene.camera().film_density(-last.to_eye);
}

/// Surfaces between the two ends: fills transmittance and pass; false when nothing gets through. Counts its rays.
bool look_along(const Scene& scene, const PathVertex& light_end, const PathVertex& eye_end, PathEdge& edge,
                uint64_t& rays);
/// What look_along found blocked, or black by `f_cos`, between a light and the vertex that sampled it, but lies beyond
/// the terminator: f |cos| times radiance, transmittance and the edge's geometry.
Color light_beyond_terminator(const Scene& scene, const PathVertex& light, const PathVertex& vertex,
                              const PathEdge& edge, const LightEnd& end, Color f_cos, uint64_t& rays);

constexpr int kMaxPathVertices = 34;  ///< longer paths are left out by all integrators that work on whole paths

/// Vertices a path may have under the scene's limits.
inline int max_path_vertices(const BounceLimits& limits) {
  return std::min(kMaxPathVertices, std::max(0, limits.total) + 3);
}

/// Can a walk from the eye be joined to nothing but the light, if at all? True when no two neighbours among the path's
/// vertices scatter otherwise than by delta lobes, the lens counted among those that do, but for the light and its
/// neighbour: E S+ (D S+)+ L and E S+ (D S+)+ D L, S being a delta lobe. E S+ L and E S+ D L, which the eye finds at
/// once, are not counted. `specular(i)` tells of inner vertex i from the light, 1 to count - 2.
template <class Specular>
bool is_unconnectable(int count, Specular&& specular) {
  if (count < 5 || !specular(count - 2)) return false;
  if (!specular(1) && (count < 6 || !specular(2))) return false;
  bool any_rough = false;
  for (int i = 2; i < count - 2; ++i) {
    if (specular(i)) continue;
    if (!specular(i - 1)) return false;
    any_rough = true;
  }
  return any_rough;
}

/// Whether a path respects the limits for each kind of bounce, as a factor in [0, 1]: the path tracer counts the kinds
/// of the lobes it draws, so a vertex with several kinds of lobes passes with the probability of having drawn the right
/// ones. Every scattering counts but the one next to the light. (`total` limits the number of vertices.)
class BounceCount {
 public:
  explicit BounceCount(const BounceLimits& limits, int diffuse = 0, int glossy = 0, int transmission = 0)
      : limits_(limits), states_{{diffuse, glossy, transmission, 1.0f}} {}
  /// Do the limits need counting for this many counted scatterings?
  static bool matters(const BounceLimits& limits, int bounces) {
    return bounces > limits.diffuse || bounces > limits.glossy || bounces > limits.transmission;
  }
  void add(const PathVertex& vertex, Vec3 to_eye, Vec3 to_light, bool specular);
  float factor() const;

 private:
  struct State {
    int diffuse, glossy, transmission;
    float probability;
  };
  BounceLimits limits_;
  std::vector<State> states_;
};

}  // namespace ajar
