// A complete light path: a value that chains and populations keep, mutate and weigh.
//
// Its contribution f and the densities of its vertices are functions of the path alone, whichever way it was found
// (path_vertex.h). `specular` flags are part of the path: two paths are compared only when they have the same ones.
#pragma once

#include <algorithm>
#include <array>

#include "film/filter.h"
#include "transport/paths/film_importance.h"
#include "transport/paths/walk.h"

namespace ajar {

inline double luminance(const glm::dvec3& c) { return 0.2126729 * c.x + 0.7151522 * c.y + 0.0721750 * c.z; }

struct Path {
  int count = 0;    ///< vertices, light and lens included; at least 2
  int hint = -1;    ///< which hint proposed it, for statistics; -1: none
  Vec2 film{0.0f};  ///< where it arrives, in pixels of the full frame
  LightEnd light;
  float hit_choice = 1.0f;    ///< probability that a walk from the eye takes this light among those its last ray meets
  float film_density = 0.0f;  ///< pixels^2 per solid angle along the last edge
  /// Measurement contribution, before the pixel filters. In doubles, as the target: squares of small distances
  /// multiply.
  glm::dvec3 f{0.0};
  double target = 0.0;  ///< luminance of f times PathSpace::weight at `film`: what chains follow
  std::array<PathVertex, kMaxPathVertices> vertices;
  std::array<PathEdge, kMaxPathVertices> edges;         ///< i joins vertices i and i + 1
  std::array<Scattering, kMaxPathVertices> scattering;  ///< of vertices 1 .. count - 2

  Path() = default;
  Path(const Path& other) { *this = other; }
  Path& operator=(const Path& other);

  Vec3 to_light(int i) const { return -edges[size_t(i - 1)].to_eye; }
  Vec3 to_eye(int i) const { return edges[size_t(i)].to_eye; }
  /// At an inner vertex: does light pass to the other side?
  bool transmits(int i) const {
    const Vec3 ng = vertices[size_t(i)].point.ng;
    return glm::dot(ng, to_light(i)) * glm::dot(ng, to_eye(i)) < 0.0f;
  }
  /// What the path splats when it carries `weight` of target.
  Color splat(double weight) const { return Color(f * (weight / target)); }
  bool joinable(int i) const { return !vertices[size_t(i)].specular; }
  /// Does light scatter widely enough here that its path may be joined anew at this vertex? Where it does not,
  /// mutations follow the lobe as they follow a mirror.
  bool rough(int i) const {
    constexpr float kSharp = 5.0f;  // per solid angle: a cone of about 15 degrees
    if (i == 0 || i == count - 1) return joinable(i);
    const Scattering& s = scattering[size_t(i)];
    return joinable(i) && std::max(s.pdf_to_light, s.pdf_to_eye) < kSharp;
  }

  /// Density of vertex i by a walk that has reached its neighbour; per area (solid angle for a light at infinity). For
  /// i = count - 2 the film point has density 1 per pixel^2; for count - 1 it is the lens's own.
  double pdf_from_eye(int i, float pdf_lens_area) const;
  double pdf_from_light(int i) const;
  /// What densities of vertex i per solid angle at its neighbour are multiplied with (passing surfaces included).
  double eye_step(int i) const {
    return double(edges[size_t(i)].to_light_area()) * edges[size_t(i)].pass * (1.0f - vertices[size_t(i)].pass);
  }
  double light_step(int i) const {
    return double(edges[size_t(i - 1)].to_eye_area()) * edges[size_t(i - 1)].pass * (1.0f - vertices[size_t(i)].pass);
  }
};

/// How many vertices two paths share at their light and eye ends.
struct SharedEnds {
  int light, eye;
};
SharedEnds shared_ends(const Path& a, const Path& b);

bool is_unconnectable(const Path& path);

/// Index of the first vertex from the eye that is not specular (0: there is none before the light).
int first_joinable_from_eye(const Path& path);

class Film;

/// The paths that count: which film, how long, with or without those that other means find better.
class PathSpace {
 public:
  /// `without_direct`: paths LS*E and L(D)S*E count nothing.
  PathSpace(const Scene& scene, int x0, int y0, int x1, int y1, bool without_direct);
  /// Of a film whose direct light is found apart.
  PathSpace(const Scene& scene, const Film& film);

  const Scene& scene;
  PixelFilter filter;
  int max_vertices;
  bool without_direct;
  bool without_unconnectable = false;     ///< paths that merging finds (vertex_merging.h) count nothing
  const LightWalkGuide* guide = nullptr;  ///< of walks from lights; must outlive the space
  /// Everywhere on the film that belongs to a pixel.
  Vec2 film_min, film_max;
  double film_area() const { return double(film_max.x - film_min.x) * double(film_max.y - film_min.y); }
  bool on_film(Vec2 film) const {
    return film.x >= film_min.x && film.y >= film_min.y && film.x < film_max.x && film.y < film_max.y &&
           scene.camera().sees(film);
  }
  Vec2 film_at(Vec2 u) const { return film_min + u * (film_max - film_min); }
  float pdf_lens_area() const { return scene.camera().pdf_lens_area(); }

  /// The pixel a path is splatted to, and the sum of all filters there.
  struct Place {
    int x, y;
    float weight;
  };
  Place place(Vec2 film, Vec2 u) const;
  float filter_sum(Vec2 film) const;
  FilmImportance importance;  ///< where chains shall dwell more
  /// Sum of the filters times importance.
  float weight(Vec2 film) const { return filter_sum(film) * importance.at(film); }

  /// Fill in everything that follows from vertices, flags, edges (with transmittance) and film: scattering for the
  /// vertices first .. last (those of other vertices are kept), light end, f, target. False when nothing arrives.
  bool complete(Path& path, int first, int last) const;

 private:
  int x0_, y0_, x1_, y1_;
};

}  // namespace ajar
