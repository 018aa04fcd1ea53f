#include "transport/mutations/lens_perturbation.h"

#include <algorithm>

namespace ajar {

LensPerturbation::LensPerturbation(const PathSpace& space)
    : space_(space), film_step_{0.1f, std::max(1.0f, float(std::sqrt(0.05 * space.film_area() / M_PI)))}, angle_step_{0.0005f, 0.2f} {}

int LensPerturbation::first_changed(const Path& path) {
  for (int i = first_joinable_from_eye(path); i > 0; --i)
    if (path.joinable(i) && path.joinable(i - 1)) return i;
  return 0;
}

bool LensPerturbation::suits(const Path& from) const {
  const int first = first_changed(from);
  return first > 0 || (from.light.can_be_hit && first_joinable_from_eye(from) > 0);
}

bool LensPerturbation::sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const {
  const Scene& scene = space_.scene;
  const int n = from.count, first = first_changed(from);
  const Vec2 u = sampler.get_2d();
  const float r = film_step_.sample(u.x), phi = 2.0f * kPi * u.y;
  to.count = n;
  to.film = from.film + r * Vec2(std::cos(phi), std::sin(phi));
  if (!space_.on_film(to.film)) return false;
  std::copy_n(from.vertices.begin(), first, to.vertices.begin());
  std::copy_n(from.edges.begin(), std::max(0, first - 1), to.edges.begin());
  std::copy_n(from.scattering.begin(), first, to.scattering.begin());
  to.vertices[size_t(n - 1)] = from.vertices[size_t(n - 1)];
  Ray ray = scene.camera().ray_through(to.film, to.vertices[size_t(n - 1)].position(), 0.0f);
  for (int i = n - 2; i >= first; --i) {
    if (i == 0) {
      if (!grow_light(scene, ray, to, sampler, rays)) return false;
      break;
    }
    if (!grow(scene, ray, true, i == n - 2, to, i, sampler, rays)) return false;
    PathVertex& vertex = to.vertices[size_t(i)];
    vertex.specular = !from.joinable(i);
    if (!vertex.specular && !vertex.connectable()) return false;
    if (i == first) break;
    Vec3 direction;
    if (vertex.specular) {
      const auto followed = follow_direction(vertex, to.to_eye(i), from.transmits(i), sampler.get_1d());
      if (!followed) return false;
      direction = followed->wi;
    } else {
      const Vec2 u_turn = sampler.get_2d();
      direction = turn(from.to_light(i), angle_step_.sample(u_turn.x), u_turn.y);
    }
    ray = scene.spawn_ray(vertex.point, direction);
  }
  if (first > 0 && !join_at(scene, to, first - 1, rays)) return false;
  return space_.complete(to, first - 1, n - 2);
}

double LensPerturbation::pdf(const Path& from, const Path& to) const {
  const int n = from.count, first = first_changed(from);
  if (!same_configuration(from, to)) return 0.0;
  const SharedEnds shared = shared_ends(from, to);
  if (shared.light < first || shared.eye < 1 || (first == 0 && !to.light.can_be_hit)) return 0.0;
  double pdf = film_step_.pdf_area(double(glm::length(to.film - from.film))) * to.film_density;
  for (int i = n - 2; i >= first; --i) {
    if (i < n - 2)
      pdf *= to.joinable(i + 1) ? angle_step_.pdf_solid_angle(angle_between(from.to_light(i + 1), to.to_light(i + 1)))
                                : double(to.scattering[size_t(i + 1)].follow_to_light);
    pdf *= to.eye_step(i);
  }
  return first == 0 ? pdf * to.hit_choice : pdf;
}

}  // namespace ajar
