// The elements of paths: vertices, the edges between them, and scattering, with their densities.
//
// The vertices of a path go from the light (0) to the eye (count - 1). All quantities are those of light that travels
// to the eye. At a vertex, `to_light` and `to_eye` are the directions to its neighbours. Its scattering is the radiance
// form f |cos(to_light)|, no matter from which end the vertex was found. So a path has one contribution and no adjoint
// is needed, also with shading normals (Veach 1997, section 5.3).
//
// Measures [Veach 1997, section 8.2]: densities of vertices are per area; for a light at infinity they are per solid
// angle of its direction. Edge i joins vertices i and i + 1. With to_light_area(i) = |cos at the light end| / d^2,
//
//   f(x) = Le  prod_i scattering[i].f  prod_i transmittance[i] to_light_area[i]  W,
//
// where W is pixels^2 per solid angle, averaged over the lens. The integral of f is the sum of all pixels before their
// filters. A walk from the eye has the density pdf_to_light * to_light_area for its next vertex, a walk from the light
// pdf_to_eye * to_eye_area.
//
// Specular vertices: f, pdf_to_light and pdf_to_eye are the factors of one delta function, over to_light for a given
// to_eye. They cancel in every ratio [Veach 1997, section 8.3.3]. So pdf_to_eye contains the Jacobian d(to_light) /
// d(to_eye) of refraction.
//
// A medium vertex has densities per volume: its cosines are 1, its scattering f contains the scattering coefficient, and
// collisions have the density per metre of path_media.h.
//
// Surfaces through which light passes straight on are not vertices. A walk passes each with a probability that depends
// only on the surface. An edge stores the product of these probabilities and its transmittance.
#pragma once

#include <optional>
#include <vector>

#include "sampling/sampler.h"
#include "scene/scene.h"
#include "transport/media/path_media.h"

namespace ajar {

class LightWalkGuide;

enum class VertexKind : uint8_t { Surface, Medium, Light, Lens };

/// What walks and edges do at surfaces that depend on the kind of the ray (shading/ray_kind_surfaces.h). At those that
/// are not eye-only, walks scatter and pass as elsewhere, except on the first edge from a light.
enum class RayKindSurfaces : uint8_t {
  End,        ///< eye-only surfaces block edges, and walks end there; their emission is found
  Follow,     ///< of walks from the eye: they know the kind. Of an edge to a light: it is that of a shadow ray
  FromLight,  ///< as End, and a walk that would pass such a surface ends there
  AsShadow    ///< as FromLight, but a walk may pass as shadow rays do
};

/// What a vertex knows of media, in scenes that have some.
struct VertexMedia {
  bool present = false;
  MediaStack stack;                     ///< around the vertex; of a surface, on the side of point.ng
  MediumPoint at;                       ///< of a medium vertex
  uint32_t receiver_set = kEveryLight;  ///< of a medium vertex

  VertexMedia() = default;
  VertexMedia(const VertexMedia& other) { *this = other; }
  VertexMedia& operator=(const VertexMedia& other) {
    present = other.present;
    if (present) {
      stack = other.stack;
      at = other.at;
      receiver_set = other.receiver_set;
    }
    return *this;
  }
};

/// A scene and its media, if it has any.
struct PathScene {
  const Scene& scene;
  const PathMedia* media = nullptr;
};

struct PathVertex {
  VertexKind kind = VertexKind::Surface;
  bool specular = false;                   ///< the path scatters by a delta lobe here
  bool distant = false;                    ///< a light at infinity, or the lens of an orthographic camera
  bool delta = false;                      ///< a light that no ray can hit
  bool exit = false;                       ///< light leaves the surface here after a walk below it
  bool eye_only = false;                   ///< only walks from the eye go by way of the surface
  int light = -1;                          ///< Light: its index. Surface: its index as a light, if it emits
  float pass = 0.0f;                       ///< probability that a walk passes straight through instead of stopping here
  const ShaderProgram* program = nullptr;  ///< of surfaces and emissive triangles
  /// Surface: the shading point. Light, Lens: time, position and ng (outward; for distant ones the direction away from
  /// them). The barycentric coordinates of a lens vertex are its lens point (Camera::sample_lens).
  ShadingPoint point;
  SurfaceShading shading;  ///< made for point.wo; lobes without transparency; of a medium without lobes
  VertexMedia media;

  Vec3 position() const { return point.position; }
  bool connectable() const { return kind != VertexKind::Surface || shading.bsdf.has_non_delta(); }
  bool scatters() const { return kind == VertexKind::Medium || !shading.bsdf.empty(); }
  /// Whether photons are stored and looked up here.
  bool stores_photons() const {
    return kind == VertexKind::Surface && shading.bsdf.has_non_delta() && !on_strand_or_point(point) &&
           !excludes_photons();
  }
  /// Paths with such a vertex are never left to photons.
  bool excludes_photons() const {
    return kind == VertexKind::Surface && (exit || eye_only || shading.bsdf.has_subsurface() || is_on_sphere());
  }
  /// Whether the vertex is on a point of a cloud.
  bool is_on_sphere() const { return point.mesh && point.mesh->points; }
  /// Whether this direction leaves a point of a cloud inwards. Walks reach such points from outside only, so that none
  /// arrives from there, and light that reaches the eye does not leave in this direction.
  bool leaves_sphere_inwards(Vec3 direction) const {
    return is_on_sphere() && kind == VertexKind::Surface && glm::dot(point.ng, direction) < 0.0f;
  }
  /// The probability that a walk which arrives from `direction` at a surface, a light or the lens stops there.
  float stop_probability(Vec3 direction) const { return leaves_sphere_inwards(direction) ? 0.0f : 1.0f - pass; }
  /// The same for walks from lights, which see what diffuse rays see.
  float stop_probability_from_light(Vec3 direction) const {
    const bool hidden = kind == VertexKind::Surface && point.instance &&
                        !(point.instance->visibility & kVisibleDiffuse);
    return hidden ? 0.0f : stop_probability(direction);
  }
  bool emits() const { return !is_black(shading.emission); }
};

struct PathEdge {
  Vec3 to_eye{0.0f};                               ///< unit direction from the light end to the eye end
  float inverse_square = 1.0f;                     ///< 1 / d^2; 1 if one end is at infinity
  float cos_light_end = 1.0f, cos_eye_end = 1.0f;  ///< |ng . direction|; 1 if there is no surface
  float pass = 1.0f;  ///< probability that a walk passes all surfaces on the edge, and its media without a collision
  float surface_pass = 1.0f;  ///< the same of the surfaces alone
  bool by_ray_kind = false;   ///< there are surfaces on the edge that depend on the kind of the ray ...
  bool eye_only = false;      ///< ... and such that are eye-only
  /// For a walk that arrives at this end: the probability to stop there, of a surface; the density of a collision there
  /// per metre, in a medium.
  float stop_light_end = 1.0f, stop_eye_end = 1.0f;
  Color transmittance{1.0f};  ///< of surfaces and media

  /// Factors from the solid angle at one end to the area at the other. With the cosine of the scattering, they are the
  /// geometry term [Fan 2006, eq. 3.16].
  float to_light_area() const { return cos_light_end * inverse_square; }
  float to_eye_area() const { return cos_eye_end * inverse_square; }
};

/// Scattering at an inner vertex for one pair of directions. Densities are per solid angle.
struct Scattering {
  Color f{0.0f};                 ///< f |cos(to_light)|; the weight if specular
  float pdf_to_light = 0.0f;     ///< density of to_light for a walk from the eye
  float pdf_to_eye = 0.0f;       ///< density of to_eye for a walk from the light that samples the BSDF
  float pdf_walk_to_eye = 0.0f;  ///< the same for a walk that can follow hints (light_walk_guide.h)
  /// Specular only: the same for walks that keep the type of bounce (Bsdf::follow_specular).
  float follow_to_light = 0.0f, follow_to_eye = 0.0f;
};

/// The geometry of the edge between two vertices, without visibility.
PathEdge join(const PathVertex& light_end, const PathVertex& eye_end);

/// The lobes of a surface vertex, made for the direction `wo`.
Bsdf lobes_towards(const PathVertex& vertex, Vec3 wo);
/// The scattering at a surface vertex. It is exact for both directions of travel, no matter from which end the vertex
/// was found.
Scattering scatter(const PathVertex& vertex, Vec3 to_eye, Vec3 to_light, bool specular, const LightWalkGuide* guide);
/// Whether a vertex may scatter light in this direction: false if all of its lobes reflect, and the direction is behind
/// the surface.
inline bool may_scatter_to(const PathVertex& vertex, Vec3 direction) {
  return vertex.kind != VertexKind::Surface || vertex.shading.bsdf.transmits_light() ||
         glm::dot(vertex.shading.bsdf.ng, direction) > 0.0f;
}
/// The receiver set of a vertex.
inline uint32_t receiver_set(const PathVertex& vertex) {
  return vertex.kind == VertexKind::Medium ? vertex.media.receiver_set : receiver_set(vertex.point);
}
/// Whether `light` lights `vertex`, its neighbour.
bool is_linked(const Scene& scene, const PathVertex& light, const PathVertex& vertex);
/// The part of scattering `f` at `vertex`, the neighbour of `light`, by the kinds of lobes that see this light; none if
/// the light does not light the vertex.
Color visible_part(const Scene& scene, const PathVertex& light, const PathVertex& vertex, Vec3 to_eye, Vec3 to_light,
                   bool specular, Color f);

/// The volumes of a ray that leaves a vertex.
MediaStack stack_towards(const Scene& scene, const PathMedia& media, const PathVertex& from, Vec3 direction);

/// Samples a direction for a walk that arrives from `wo`, with the lobes made for `wo`.
std::optional<BsdfSample> sample_direction(const PathVertex& vertex, Vec3 wo, float u_lobe, Vec2 u);
/// The same for a walk that repeats a specular bounce of this type.
std::optional<BsdfSample> follow_direction(const PathVertex& vertex, Vec3 wo, bool transmitted, float u_lobe);

/// The probability with which walks pass a surface of this `transparency`.
float pass_probability(const ShaderProgram& program, Color transparency);

/// The least density per solid angle with which a direction to light from infinity is sampled, for photons to bring its
/// light: that of a disc with a diameter of 20 degrees. A diffuse lobe samples it with a thirtieth of that at most.
constexpr float kLeastDensityOfPhotons = 10.0f;
/// Whether photons start here. Paths from other lights can be found only by walks from the eye, which also find the even
/// parts of the sky well. This depends on the light and on its direction alone, so it divides the paths into two classes.
bool sends_photons(const Scene& scene, const PathVertex& light);

/// The contributions of the light end and of the camera to a path, and the densities with which they are found.
struct LightEnd {
  Color radiance{0.0f};       ///< radiance emitted along the first edge
  float pdf_origin = 0.0f;    ///< density of vertex 0 for walks from lights, times the probability of the light
  float pdf_by_power = 0.0f;  ///< the same for walks that do not use hints
  /// Density of the first edge for walks that do not use hints: per solid angle; per area across the edge for distant
  /// lights.
  float pdf_direction = 0.0f;
  float pdf_sampled = 0.0f;  ///< density of vertex 0 for light sampling at vertex 1
  bool can_be_hit = false;   ///< walks from the eye can hit the light
  /// Some kinds of lobes do not see the light (LightFlags::partial). Such a light is hit only after a specular vertex.
  /// At other vertices, only light sampling finds it, because it separates the kinds.
  bool partial = false;
  bool can_be_hit_from(const PathVertex& next) const {
    return can_be_hit && (!partial || next.specular || next.kind == VertexKind::Lens);
  }
};
LightEnd light_end(const Scene& scene, const PathVertex& light, const PathVertex& next, const PathEdge& edge,
                   const LightWalkGuide* guide);

/// Whether the light is not sampled any more after `bounces` vertices that scatter (LightFlags::max_bounces). Rays still
/// hit it, with the weight that they would have beside light sampling (`weight_past_bounces`). Only walks from the eye
/// find such light.
bool is_past_bounces(const Scene& scene, const PathVertex& light, int bounces);
/// The weight of a hit of such a light. `next` is its neighbour, `pdf_to_light` the density of the direction there.
float weight_past_bounces(const LightEnd& light, const PathVertex& next, const PathEdge& edge, float pdf_to_light);
/// The weight of light sampling against hits, for light past surfaces that depend on the kind of the ray: that of path
/// tracing, which defines this light. Hits past them are other light. `pdf_to_light`: as above.
float weight_past_ray_kinds(const LightEnd& light, const PathEdge& edge, float pdf_to_light);
/// Index of the light group of a light (Scene::light_groups); -1: none.
int light_group_of(const Scene& scene, const PathVertex& light);

/// Pixels^2 per solid angle along the last edge (see Camera::film_density).
inline float lens_density(const Scene& scene, const PathEdge& last, float time) {
  return scene.camera().film_density(-last.to_eye, time);
}

/// Whether paths from lights can be connected to the camera (Camera::finds_film). If not, only walks from the camera
/// find the last edge of a path.
bool joins_lens(const Scene& scene);

/// The normal for the irradiance by which lights are chosen; 0 in media.
Vec3 receiving_normal(const PathVertex& vertex);
/// The same place as seen from the direction `wo`.
ShadingPoint turned_towards(const ShadingPoint& point, Vec3 wo);
/// Whether safe_shading_normal changes the surface's own normal for this direction.
bool bends_normal(const ShadingPoint& point, Vec3 wo);
/// Whether the lobes of a surface, `bsdf`, can differ if they are made for the direction `wo`.
bool depends_on_view(const ShaderProgram& program, const ShadingPoint& point, const Bsdf& bsdf, Vec3 wo);
/// Whether those for `wo` follow from `bsdf` (Bsdf::turn_to), so that the shader need not be evaluated again.
bool turns_to(const ShaderProgram& program, const ShadingPoint& point, const Bsdf& bsdf, Vec3 wo);

/// Finds the surfaces and media between the two ends and sets transmittance and pass. Returns false if the edge is blocked.
/// Counts its rays.
bool look_along(const PathScene& where, const PathVertex& light_end, const PathVertex& eye_end, PathEdge& edge,
                uint64_t& rays, RayKindSurfaces by_kind = RayKindSurfaces::End);
/// Light between a light and the vertex that sampled it, where look_along found a blocked edge or `f_cos` is black, but
/// the light is beyond the shadow terminator (shadow_terminator.h). Returns f |cos| times radiance, transmittance and
/// the geometry of the edge.
Color light_beyond_terminator(const PathScene& where, const PathVertex& light, const PathVertex& vertex,
                              const PathEdge& edge, const LightEnd& end, Color f_cos, uint64_t& rays);

constexpr int kMaxPathVertices = 34;  ///< integrators that work on whole paths leave out longer ones

/// The maximum number of vertices of a path under the limits of the scene.
inline int max_path_vertices(const BounceLimits& limits) {
  return std::min(kMaxPathVertices, std::max(0, limits.total) + 3);
}

/// Whether a walk from the eye can be joined to nothing but the light. This is so if no two neighbouring vertices of
/// the path are both non-specular. The lens counts as non-specular; the light and its neighbour are ignored as a pair.
/// The paths are E S+ (D S+)+ L and E S+ (D S+)+ D L, where S is a delta lobe. E S+ L and E S+ D L are not included,
/// because the eye finds them directly. `specular(i)` is the flag of inner vertex i, counted from the light, 1 to count
/// - 2.
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

/// Whether a path respects the limits for each type of bounce, as a factor in [0, 1]. The path tracer counts the types
/// of the lobes that it samples. So a vertex with several types of lobes passes with the probability that the path
/// tracer would sample the right ones. All scattering is counted except that at the neighbour of the light. (`total`
/// limits the number of vertices.)
class BounceCount {
 public:
  explicit BounceCount(const BounceLimits& limits, int diffuse = 0, int glossy = 0, int transmission = 0)
      : limits_(limits), states_{{diffuse, glossy, transmission, 1.0f}} {}
  /// Whether the limits matter for this number of counted bounces.
  static bool matters(const BounceLimits& limits, int bounces, bool media) {
    return bounces > limits.diffuse || bounces > limits.glossy || bounces > limits.transmission ||
           (media && bounces > limits.volume);
  }
  void add(const PathVertex& vertex, Vec3 to_eye, Vec3 to_light, bool specular);
  float factor() const;

 private:
  struct State {
    int diffuse, glossy, transmission;
    float probability;
  };
  BounceLimits limits_;
  int volume_ = 0;
  std::vector<State> states_;
};

}  // namespace ajar
