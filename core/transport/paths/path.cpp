#include "transport/paths/path.h"

#include <algorithm>

#include "film/film.h"
#include "lights/sources/lamp.h"
#include "transport/paths/eye_history.h"

namespace ajar {

Path& Path::operator=(const Path& other) {
  count = other.count;
  hint = other.hint;
  film = other.film;
  light = other.light;
  hit_choice = other.hit_choice;
  film_density = other.film_density;
  f = other.f;
  target = other.target;
  std::copy_n(other.vertices.begin(), count, vertices.begin());
  std::copy_n(other.edges.begin(), std::max(0, count - 1), edges.begin());
  std::copy_n(other.scattering.begin(), count, scattering.begin());
  return *this;
}

double Path::pdf_from_eye(int i, float pdf_lens_area) const {
  if (i == count - 1) return pdf_lens_area;
  return (i == count - 2 ? film_density : scattering[size_t(i + 1)].pdf_to_light) * eye_step(i);
}

double Path::pdf_from_light(int i) const {
  if (i == 0) return light.pdf_origin;
  return (i == 1 ? light.pdf_direction : scattering[size_t(i - 1)].pdf_walk_to_eye) * light_step(i);
}

SharedEnds shared_ends(const Path& a, const Path& b) {
  const auto same = [](const PathVertex& v, const PathVertex& w) {
    if (v.kind != w.kind || v.light != w.light || v.distant != w.distant) return false;
    if (v.point.time != w.point.time) return false;
    // The position of a lens that turns depends on the film point.
    if (v.kind == VertexKind::Lens) return v.point.barycentric == w.point.barycentric;
    return v.distant ? v.point.ng == w.point.ng : v.position() == w.position();
  };
  const int least = std::min(a.count, b.count);
  SharedEnds shared{0, 0};
  while (shared.light < least && same(a.vertices[size_t(shared.light)], b.vertices[size_t(shared.light)]))
    ++shared.light;
  while (shared.eye < least - shared.light &&
         same(a.vertices[size_t(a.count - 1 - shared.eye)], b.vertices[size_t(b.count - 1 - shared.eye)]))
    ++shared.eye;
  return shared;
}

bool is_unconnectable(const Path& path) {
  for (int i = 1; i < path.count - 1; ++i)
    if (path.vertices[size_t(i)].kind == VertexKind::Medium || path.vertices[size_t(i)].excludes_photons())
      return false;
  return is_unconnectable(path.count, [&](int i) { return !path.joinable(i); });
}

int first_joinable_from_eye(const Path& path) {
  int i = path.count - 2;
  while (i > 0 && !path.joinable(i)) --i;
  return i;
}

PathSpace::PathSpace(const Scene& s, int x0, int y0, int x1, int y1, bool direct_apart)
    : scene(s),
      filter(s.settings().filter, s.settings().filter_width),
      max_vertices(max_path_vertices(s.settings().bounces)),
      to_lens(joins_lens(s)),
      without_direct(direct_apart),
      has_subsurface(s.has_subsurface()),
      x0_(x0),
      y0_(y0),
      x1_(x1),
      y1_(y1) {
  const float margin = filter.half_width() - 0.5f;
  film_min = Vec2(float(x0) - margin, float(y0) - margin);
  film_max = Vec2(float(x1) + margin, float(y1) + margin);
}

PathSpace::PathSpace(const Scene& s, const Film& film, const PathMedia* scene_media)
    : PathSpace(s, film.x0(), film.y0(), film.x0() + film.width(), film.y0() + film.height(), true) {
  media = scene_media;
}

PathSpace::Place PathSpace::place(Vec2 film, Vec2 u) const {
  const auto column = filter.place(film.x, x0_, x1_, u.x), row = filter.place(film.y, y0_, y1_, u.y);
  return {column.pixel, row.pixel, column.weight * row.weight};
}

float PathSpace::filter_sum(Vec2 film) const {
  return filter.place(film.x, x0_, x1_, 0.5f).weight * filter.place(film.y, y0_, y1_, 0.5f).weight;
}

Color PathSpace::history_of(const Path& path) const {
  const BounceLimits& limits = scene.settings().bounces;
  const bool limited = BounceCount::matters(limits, path.count - 3, media != nullptr);
  int last = 1;  // the vertex next to the light where the history matters
  while (!limited && last < path.count - 1 && !can_enter(path.vertices[size_t(last)])) ++last;
  EyeHistory history(limited ? &limits : nullptr);
  for (int i = path.count - 2; i >= std::max(2, last); --i)
    history.add(path.vertices[size_t(i)], path.to_eye(i), path.to_light(i), path.vertices[size_t(i)].specular);
  if (last == 1 && path.count > 2)
    history.end(scene, path.vertices[0], path.vertices[1], path.to_eye(1), path.to_light(1), path.vertices[1].specular);
  return history.factor();
}

bool PathSpace::complete(Path& path, int first, int last) const {
  path.target = 0.0;
  path.f = glm::dvec3(0.0);
  const int n = path.count;
  if (n < 2 || n > max_vertices) return false;
  const float here = weight(path.film);
  if (!(here > 0.0f)) return false;
  if (without_direct && first_joinable_from_eye(path) <= 1) return false;
  if (without_unconnectable && is_unconnectable(path) && sends_photons(scene, path.vertices[0]) &&
      path.vertices[size_t(first_joinable_from_eye(path))].stores_photons())
    return false;
  path.film_density = lens_density(scene, path.edges[size_t(n - 2)], path.time());
  for (int i = std::max(1, first); i <= std::min(n - 2, last); ++i) {
    Scattering& s = path.scattering[size_t(i)];
    s = scatter(path.vertices[size_t(i)], path.to_eye(i), path.to_light(i), path.vertices[size_t(i)].specular, guide);
    if (i == 1)
      s.f = visible_part(scene, path.vertices[0], path.vertices[1], path.to_eye(1), path.to_light(1),
                         path.vertices[1].specular, s.f);
    if (is_black(s.f)) return false;
  }
  path.light = light_end(scene, path.vertices[0], path.vertices[1], path.edges[0], guide);
  path.light.can_be_hit = path.light.can_be_hit_from(path.vertices[1]);
  // The contribution f [Fan 2006, eq. 3.15], in the form of path_vertex.h.
  glm::dvec3& f = path.f;
  f = glm::dvec3(path.light.radiance);
  f *= double(path.film_density) * pdf_lens_area();
  for (int i = 0; i < n - 1; ++i) {
    const PathEdge& edge = path.edges[size_t(i)];
    f *= glm::dvec3(edge.transmittance) * double(edge.to_light_area());
    if (i > 0) f *= glm::dvec3(path.scattering[size_t(i)].f);
  }
  const BounceLimits& limits = scene.settings().bounces;
  if (has_subsurface) {
    f *= glm::dvec3(history_of(path));
  } else if (BounceCount::matters(limits, n - 3, media != nullptr)) {
    BounceCount bounces(limits);
    for (int i = 2; i <= n - 2; ++i)
      bounces.add(path.vertices[size_t(i)], path.to_eye(i), path.to_light(i), path.vertices[size_t(i)].specular);
    f *= double(bounces.factor());
  }
  if (is_past_bounces(scene, path.vertices[0], n - 3)) [[unlikely]]
    f *= double(weight_past_bounces(path.light, path.vertices[1], path.edges[0], path.scattering[1].pdf_to_light));
  path.target = path.energy() * double(here);
  if (!(path.target > 0.0) || !std::isfinite(path.target)) {
    path.target = 0.0;
    return false;
  }
  path.hit_choice = 1.0f;
  if (!path.light.can_be_hit) return true;
  const bool distant = path.vertices[0].distant;
  if (!distant && !scene.has_lamp_shapes()) return true;
  Ray ray = scene.spawn_ray(path.vertices[1].point, -path.edges[0].to_eye);
  const uint32_t kind = kind_towards_light(scene, path.vertices[1], path.to_eye(1), ray.direction);
  if (distant) {
    int met = 0;
    for_each_distant_light(scene, ray, kind, true, [&](const LightMet&) { ++met; });
    path.hit_choice = met > 0 ? 1.0f / float(met) : 0.0f;
  } else if (!path.vertices[0].program) {
    path.hit_choice = kLampStop;
  }
  if (scene.has_lamp_shapes()) {
    const PathVertex& light = path.vertices[0];
    float distance = distant ? kInfinity : (1.0f - 1e-4f) / std::sqrt(path.edges[0].inverse_square);
    if (light.light >= 0 && scene.lights().flags(uint32_t(light.light)).soft)
      distance = (1.0f - 1e-4f) * soft_lamp_distance(scene.lights().light(uint32_t(light.light)),
                                                     path.vertices[1].position(), ray.direction)
                                      .value_or(kInfinity);
    for_each_lamp_crossed(scene, ray, distance, kind, [&](const LightMet&) { path.hit_choice *= 1.0f - kLampStop; });
  }
  return true;
}

}  // namespace ajar
