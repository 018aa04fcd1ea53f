#include "transport/paths/shadow_terminator.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

/// The vector from the flat triangle to the curved surface through its vertices, along the interpolated normal, in
/// world space. Its length is the maximum of a parabola and the lower envelope of the planes at the vertices, where
/// each plane is raised until it is above the neighbouring vertices. `ng` is on the light's side.
Vec3 to_curved_surface(const ShadingPoint& point, Vec3 ng) {
  const BuiltMesh& mesh = *point.mesh;
  const UVec3 triangle = mesh.triangles[point.primitive];
  const float weights[3] = {1.0f - point.barycentric.x - point.barycentric.y, point.barycentric.x, point.barycentric.y};
  Vec3 p[3], n[3], place(0.0f), normal(0.0f);
  for (int i = 0; i < 3; ++i) {
    const uint32_t vertex = triangle[i];
    p[i] = mesh.positions[vertex];
    n[i] = mesh.normal_domain == Domain::Vertex ? mesh.normals[vertex]
                                                : mesh.normals[size_t(point.primitive) * 3 + size_t(i)];
    place += weights[i] * p[i];
    normal += weights[i] * n[i];
  }
  Mat4 moved;
  const Vec3 world_normal = mesh.baked
                                ? normal
                                : transform_vector(world_from_object(*point.instance, point.time, moved), normal);
  const float side = glm::dot(world_normal, ng) > 0.0f ? 1.0f : -1.0f;
  const float a = glm::dot(n[2] - n[0], p[0] - p[2]), b = glm::dot(n[2] - n[1], p[1] - p[2]),
              c = glm::dot(n[1] - n[0], p[1] - p[0]);
  const float u = weights[0], v = weights[1];
  const float parabola = 0.5f * (a * u * (u - 1.0f) + (a + b + c) * u * v + b * v * (v - 1.0f));
  float envelope = kInfinity;
  for (int i = 0; i < 3; ++i) {
    const Vec3 to_next = p[(i + 1) % 3] - p[i], to_last = p[(i + 2) % 3] - p[i];
    const float raised = std::max({side * glm::dot(to_next, n[i]), side * glm::dot(to_last, n[i]), 0.0f});
    envelope = std::min(envelope, std::max(side * glm::dot(p[i] - place, n[i]) + raised, 0.0f));
  }
  return world_normal * (side > 0.0f ? std::max(envelope, parabola) : std::min(-envelope, parabola));
}

}  // namespace

bool has_soft_terminator(const Scene& scene) {
  return scene.settings().bounces.total > 0 && !scene.lights().empty() &&
         std::any_of(scene.instances().begin(), scene.instances().end(), [&](const BuiltInstance& instance) {
           return scene.object(instance.object).shadow_terminator_offset > 0.0f &&
                  !scene.meshes()[instance.mesh].normals.empty();
         });
}

bool beyond_terminator(const Scene& scene, const ShadingPoint& point, const Bsdf& bsdf, const LightPlace& light,
                       bool shadows, Color& f, Ray& ray) {
  const Vec3 wi = light.wi;
  if (!grazes_terminator(point, wi)) return false;
  if (is_black(f)) f = bsdf.evaluate_beyond_horizon(point.wo, wi);
  ray.t_max = 0.0f;
  if (is_black(f) || !shadows) return !is_black(f);
  ShadingPoint moved = point;
  moved.position += share_of_terminator_offset(point, wi) *
                    to_curved_surface(point, glm::dot(point.ns, wi) < 0.0f ? -point.ng : point.ng);
  LightPlace place = light;
  if (light.distance < kInfinity) {
    const Vec3 to_light = light.position - moved.position;
    place.distance = std::sqrt(length_squared(to_light));
    if (!(place.distance > 0.0f)) return false;
    place.wi = to_light / place.distance;
    // The flat faces of the mesh itself are below the horizon of the curved surface.
    if (glm::dot(point.ns, place.wi) * glm::dot(point.ns, wi) <= 0.0f) return false;
  }
  ray = scene.spawn_segment(moved, place);
  return true;
}

Color beyond_terminator(const Scene& scene, const ShadingPoint& point, const Bsdf& bsdf, const LightPlace& light,
                        Color f_cos, bool shadows, uint64_t& rays) {
  Ray ray;
  if (!beyond_terminator(scene, point, bsdf, light, shadows, f_cos, ray)) return Color(0.0f);
  if (!(ray.t_max > 0.0f)) return f_cos;
  ++rays;
  return f_cos * scene.transmittance(ray, scene.settings().bounces.transparent);
}

}  // namespace ajar
