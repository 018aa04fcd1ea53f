#include "transport/chains/mutations/caustic_perturbation.h"

#include <algorithm>

namespace ajar {

namespace {
constexpr float kLargestAngle = 0.7f;
}

CausticPerturbation::CausticPerturbation(const PathSpace& space)
    : space_(space), pixels_(LogarithmicStep::on_film(space)) {}

int CausticPerturbation::turned(const Path& path) {
  int i = path.count - 3;
  while (i > 0 && !path.rough(i)) --i;
  return i;
}

bool CausticPerturbation::suits(const Path& from) const {
  // A delta sun has only one direction, but its rays can be shifted like those of any distant light.
  return space_.to_lens && from.count >= 3 && from.rough(from.count - 2);
}

float CausticPerturbation::per_pixel(const Path& path, int vertex) const {
  const auto length = [&](int edge) { return 1.0f / std::sqrt(path.edges[size_t(edge)].inverse_square); };
  float size = 1.0f / std::sqrt(path.film_density);  // of a pixel at the vertex next to the eye
  if (!path.vertices[size_t(path.count - 1)].distant) size *= length(path.count - 2);
  if (path.vertices[size_t(vertex)].distant) return size;
  float travelled = 0.0f;
  for (int i = vertex; i < path.count - 2; ++i) travelled += length(i);
  return size / travelled;
}

bool CausticPerturbation::sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const {
  const Scene& scene = space_.scene;
  const int n = from.count, first = turned(from);
  const PathVertex& start = from.vertices[size_t(first)];
  to.count = n;
  std::copy_n(from.vertices.begin(), first + 1, to.vertices.begin());
  std::copy_n(from.edges.begin(), first, to.edges.begin());
  std::copy_n(from.scattering.begin(), first + 1, to.scattering.begin());
  to.vertices[size_t(n - 1)] = from.vertices[size_t(n - 1)];
  const Vec2 u = sampler.get_2d();
  const float step = per_pixel(from, first) * pixels_.sample(u.x);
  Ray ray;
  ray.time = from.time();
  if (start.distant) {
    const Frame frame(start.point.ng);
    const float phi = 2.0f * kPi * u.y;
    ray.direction = start.point.ng;
    ray.origin = from.vertices[1].position() + step * (std::cos(phi) * frame.s + std::sin(phi) * frame.t);
    // The ray starts outside the scene, as light walks do.
    ray.origin -= ray.direction * (scene.radius() + glm::dot(ray.origin - scene.center(), ray.direction));
  } else {
    if (!(step < kLargestAngle)) return false;
    const Vec3 direction = turn(from.to_eye(first), step, u.y);
    if (start.kind == VertexKind::Surface || start.kind == VertexKind::Medium || start.program) {
      ray = scene.spawn_ray(start.point, direction);
    } else {
      ray.origin = start.position();
      ray.direction = direction;
    }
  }
  for (int i = first + 1; i <= n - 2; ++i) {
    if (!grow(space_, ray, {Growth::ToEye, collisions_like(from, i, false)}, to, i, sampler, rays)) return false;
    PathVertex& vertex = to.vertices[size_t(i)];
    vertex.specular = !from.joinable(i);
    if (!vertex.specular && !vertex.connectable()) return false;
    if (i == n - 2) break;
    const auto repeated = repeat_bounce(from, i, vertex, to.to_light(i), sampler);
    if (!repeated) return false;
    ray = scene.spawn_ray(vertex.point, *repeated);
  }
  if (!join_at(space_, to, n - 2, rays) || !arrive_on_film(space_, to)) return false;
  return space_.complete(to, first, n - 2) && same_configuration(from, to);
}

double CausticPerturbation::pdf(const Path& from, const Path& to) const {
  const int n = from.count, first = turned(from);
  if (!same_configuration(from, to)) return 0.0;
  const SharedEnds shared = shared_ends(from, to);
  if (shared.light < first + 1 || shared.eye < 1) return 0.0;
  const PathVertex& start = from.vertices[size_t(first)];
  const double scale = per_pixel(from, first);
  double pdf;
  if (start.distant) {
    const Vec3 shift = to.vertices[1].position() - from.vertices[1].position();
    const double across = double(glm::length(shift - glm::dot(shift, start.point.ng) * start.point.ng));
    pdf = pixels_.pdf_area(across / scale) / (scale * scale);
  } else {
    const double angle = angle_between(from.to_eye(first), to.to_eye(first));
    if (!(angle < double(kLargestAngle))) return 0.0;
    pdf = pixels_.pdf_length(angle / scale) / scale / (2.0 * M_PI * std::sin(angle));
  }
  for (int i = first + 1; i <= n - 2; ++i) {
    if (i > first + 1) pdf *= pdf_of_repeated(from, to, i - 1, false);
    pdf *= to.kept_light_step(i);
  }
  return pdf;
}

}  // namespace ajar
