// A complete path: a value that chains and populations store, mutate and weight.
//
// Its contribution f and the densities of its vertices depend only on the path, not on how it was found
// (path_vertex.h). The `specular` flags are part of the path: two paths are compared only if their flags are equal.
#pragma once

#include <algorithm>
#include <array>

#include "film/filter.h"
#include "transport/paths/film_importance.h"
#include "transport/paths/walk.h"

namespace ajar {

inline double luminance(const glm::dvec3& c) { return 0.2126729 * c.x + 0.7151522 * c.y + 0.0721750 * c.z; }

struct Path {
  int count = 0;    ///< number of vertices with light and lens; at least 2
  int hint = -1;    ///< index of the hint that proposed the path, for statistics; -1: none
  Vec2 film{0.0f};  ///< position on the film in pixels of the full frame
  LightEnd light;
  float hit_choice = 1.0f;    ///< probability that a walk from the eye takes this light among those on its last ray
  float film_density = 0.0f;  ///< pixels^2 per solid angle along the last edge
  /// Measurement contribution before the pixel filters. It is a double, as is the target, because squares of small
  /// distances are multiplied.
  glm::dvec3 f{0.0};
  double target = 0.0;  ///< luminance of f times PathSpace::weight at `film`, which chains follow
  std::array<PathVertex, kMaxPathVertices> vertices;
  std::array<PathEdge, kMaxPathVertices> edges;         ///< edge i joins vertices i and i + 1
  std::array<Scattering, kMaxPathVertices> scattering;  ///< at the vertices 1 .. count - 2

  Path() = default;
  Path(const Path& other) { *this = other; }
  Path& operator=(const Path& other);

  /// Luminance of the amount of light, which is negative for lamps of negative power.
  double energy() const { return luminance(glm::abs(f)); }
  /// The time of all vertices, in [0, 1] of the shutter interval.
  float time() const { return vertices[size_t(count - 1)].point.time; }
  Vec3 to_light(int i) const { return -edges[size_t(i - 1)].to_eye; }
  Vec3 to_eye(int i) const { return edges[size_t(i)].to_eye; }
  /// Whether light is transmitted to the other side at an inner vertex.
  bool transmits(int i) const {
    if (vertices[size_t(i)].kind == VertexKind::Medium) return true;
    const Vec3 ng = vertices[size_t(i)].point.ng;
    return glm::dot(ng, to_light(i)) * glm::dot(ng, to_eye(i)) < 0.0f;
  }
  /// The splat of the path if its weight, as a multiple of the target, is `weight`.
  Color splat(double weight) const { return Color(f * (weight / target)); }
  bool joinable(int i) const { return !vertices[size_t(i)].specular; }
  /// Whether the scattering at this vertex is rough enough to join the path anew. Where it is not, mutations follow the
  /// lobe as if it were specular.
  bool rough(int i) const {
    constexpr float kSharp = 5.0f;  // limit of the density per solid angle: a cone of about 15 degrees
    if (i == 0 || i == count - 1) return joinable(i);
    const Scattering& s = scattering[size_t(i)];
    return joinable(i) && std::max(s.pdf_to_light, s.pdf_to_eye) < kSharp;
  }

  /// The density of vertex i for a walk that has reached its neighbour: per area, or per solid angle for a light at
  /// infinity. For i = count - 2, the film point has density 1 per pixel^2. For i = count - 1, the density is that of
  /// the lens.
  double pdf_from_eye(int i, float pdf_lens_area) const;
  double pdf_from_light(int i) const;
  /// The factor from the density of vertex i per solid angle at its neighbour to that per area. It includes the
  /// probability of passing the surfaces on the edge.
  double eye_step(int i) const {
    const PathEdge& edge = edges[size_t(i)];
    // The last edge of a walk that must end on a light has no collisions.
    return double(edge.to_light_area()) * (i == 0 ? edge.surface_pass : edge.pass) * edge.stop_light_end;
  }
  double light_step(int i) const {
    const PathEdge& edge = edges[size_t(i - 1)];
    return double(edge.to_eye_area()) * edge.pass * edge.stop_eye_end;
  }
  /// The same for walks that keep the kinds of vertices, and the distances of collisions, of another path.
  double kept_eye_step(int i) const {
    const PathEdge& edge = edges[size_t(i)];
    return double(edge.to_light_area()) * edge.surface_pass * vertices[size_t(i)].stop_probability(edge.to_eye);
  }
  double kept_light_step(int i) const {
    const PathEdge& edge = edges[size_t(i - 1)];
    return double(edge.to_eye_area()) * edge.surface_pass *
           vertices[size_t(i)].stop_probability_from_light(-edge.to_eye);
  }
};

/// The numbers of vertices that two paths share at their light and eye ends.
struct SharedEnds {
  int light, eye;
};
SharedEnds shared_ends(const Path& a, const Path& b);

bool is_unconnectable(const Path& path);

/// Index of the first vertex from the eye that is not specular; 0 if there is none before the light.
int first_joinable_from_eye(const Path& path);

class Film;

/// The paths that contribute: the film, the maximum length, and whether paths that other methods find better are
/// excluded.
class PathSpace {
 public:
  /// `without_direct`: the paths LS*E and L(D)S*E contribute nothing.
  PathSpace(const Scene& scene, int x0, int y0, int x1, int y1, bool without_direct);
  /// The space of a film whose direct light is computed separately.
  PathSpace(const Scene& scene, const Film& film, const PathMedia* media = nullptr);

  const Scene& scene;
  PixelFilter filter;
  int max_vertices;
  bool to_lens;                      ///< paths from lights can be connected to the camera
  const PathMedia* media = nullptr;  ///< of the scene, if it has any; must outlive the space
  bool without_direct;
  bool without_unconnectable = false;  ///< paths that merging finds (vertex_merging.h) contribute nothing
  /// Light goes below surfaces: paths of the space have no such walk (eye_history.h). If it is false, the lobes are
  /// diffuse reflection.
  bool has_subsurface;
  const LightWalkGuide* guide = nullptr;  ///< guide of walks from lights; it must outlive the space
  /// The bounds of all film positions that contribute to a pixel.
  Vec2 film_min, film_max;
  double film_area() const { return double(film_max.x - film_min.x) * double(film_max.y - film_min.y); }
  bool on_film(Vec2 film) const {
    return film.x >= film_min.x && film.y >= film_min.y && film.x < film_max.x && film.y < film_max.y &&
           scene.camera().sees(film);
  }
  Vec2 film_at(Vec2 u) const { return film_min + u * (film_max - film_min); }
  PathScene path_scene() const { return {scene, media}; }
  float pdf_lens_area() const { return scene.camera().pdf_lens_area(); }

  /// The pixel to which a path is splatted, and the sum of all filters there.
  struct Place {
    int x, y;
    float weight;
  };
  Place place(Vec2 film, Vec2 u) const;
  float filter_sum(Vec2 film) const;
  FilmImportance importance;  ///< importance of film positions for chains
  /// The sum of the filters times the importance.
  float weight(Vec2 film) const { return filter_sum(film) * importance.at(film); }

  /// Computes all data that follow from vertices, flags, edges (with transmittance) and film: the scattering at the
  /// vertices first .. last (that of other vertices is kept), the light end, f and the target. Returns false if the
  /// contribution is zero.
  bool complete(Path& path, int first, int last) const;

 private:
  /// The factor of what the path has been through, seen from the eye: limits of kinds of bounces, and lobes that stand for walks below surfaces.
  Color history_of(const Path& path) const;

  int x0_, y0_, x1_, y1_;
};

}  // namespace ajar
