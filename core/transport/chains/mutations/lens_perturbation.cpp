#include "transport/chains/mutations/lens_perturbation.h"

#include <algorithm>

namespace ajar {

namespace {
/// Edges shorter than ten widths of a pixel at their eye end are not connected if a longer one can be: the light along
/// them changes with every step.
constexpr float kNear = 0.01f;
}  // namespace

LensPerturbation::LensPerturbation(const PathSpace& space)
    : LensPerturbation(space, "lens", LogarithmicStep::on_film(space)) {}

LensPerturbation::LensPerturbation(const PathSpace& space, const char* name, LogarithmicStep film_step)
    : space_(space), name_(name), film_step_(film_step), angle_step_{0.0005f, 0.2f} {}

int LensPerturbation::first_changed(const Path& path) {
  // Distance from the eye along the path, over specular chains too.
  float travelled = path.vertices[size_t(path.count - 1)].distant ? 1.0f : 0.0f;
  int near = 0;
  for (int i = path.count - 2; i > 0; --i) {
    if (!path.vertices[size_t(path.count - 1)].distant)
      travelled += 1.0f / std::sqrt(path.edges[size_t(i)].inverse_square);
    if (!path.rough(i) || !path.rough(i - 1)) continue;
    if (i == 1 || travelled * travelled * path.edges[size_t(i - 1)].inverse_square < kNear * path.film_density)
      return i;
    if (near == 0) near = i;
  }
  return near;
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
  Ray ray = leave_lens(scene, to.film, to.vertices[size_t(n - 1)]);
  for (int i = n - 2; i >= first; --i) {
    if (i == 0) {
      if (!grow_light(space_, ray, to, sampler, rays)) return false;
      break;
    }
    const Growth growth{i == n - 2 ? Growth::ToLightFromLens : Growth::ToLight, collisions_like(from, i, true)};
    if (!grow(space_, ray, growth, to, i, sampler, rays)) return false;
    PathVertex& vertex = to.vertices[size_t(i)];
    vertex.specular = !from.joinable(i);
    if (!vertex.specular && !vertex.connectable()) return false;
    if (i == first) break;
    Vec3 direction;
    if (from.rough(i)) {
      const Vec2 u_turn = sampler.get_2d();
      direction = turn(from.to_light(i), angle_step_.sample(u_turn.x), u_turn.y);
    } else {
      const auto repeated = repeat_bounce(from, i, vertex, to.to_eye(i), sampler);
      if (!repeated) return false;
      direction = *repeated;
    }
    ray = scene.spawn_ray(vertex.point, direction);
  }
  if (first > 0 && !join_at(space_, to, first - 1, rays)) return false;
  return space_.complete(to, first - 1, n - 2) && same_configuration(from, to) && first_changed(to) == first;
}

double LensPerturbation::pdf(const Path& from, const Path& to) const {
  const int n = from.count, first = first_changed(from);
  if (!same_configuration(from, to)) return 0.0;
  const SharedEnds shared = shared_ends(from, to);
  if (shared.light < first || shared.eye < 1 || (first == 0 && !to.light.can_be_hit)) return 0.0;
  double pdf = film_step_.pdf_area(double(glm::length(to.film - from.film))) * to.film_density;
  for (int i = n - 2; i >= first; --i) {
    if (i < n - 2)
      pdf *= to.rough(i + 1) ? angle_step_.pdf_solid_angle(angle_between(from.to_light(i + 1), to.to_light(i + 1)))
                             : pdf_of_repeated(from, to, i + 1, true);
    pdf *= to.kept_eye_step(i);
  }
  return first == 0 ? pdf * to.hit_choice : pdf;
}

}  // namespace ajar
