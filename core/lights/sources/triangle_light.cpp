#include "lights/sources/triangle_light.h"

#include "lights/sources/spherical_triangle.h"
#include "math/warps.h"

namespace ajar {

WorldTriangle world_triangle(const BuiltMesh& mesh, const BuiltInstance& instance, uint32_t primitive, float time) {
  const auto [p0, p1, p2] = mesh.corners(primitive, time);
  WorldTriangle t;
  t.p0 = p0;
  t.e1 = p1 - p0;
  t.e2 = p2 - p0;
  if (!mesh.baked) {
    Mat4 moved;
    const Mat4& m = world_from_object(instance, time, moved);
    t.p0 = transform_point(m, t.p0);
    t.e1 = transform_vector(m, t.e1);
    t.e2 = transform_vector(m, t.e2);
  }
  // Scaled so that tiny and huge triangles stay in the range of floats.
  const float scale = std::max(max_component(glm::abs(t.e1)), max_component(glm::abs(t.e2)));
  t.normal = Vec3(0.0f);
  t.area = 0.0f;
  if (!(scale > 0.0f)) return t;
  const Vec3 cross = glm::cross(t.e1 / scale, t.e2 / scale);
  const float length = glm::length(cross);
  if (!(length > 0.0f)) return t;
  t.normal = cross * ((instance.flips_orientation ? -1.0f : 1.0f) / length);
  t.area = 0.5f * length * scale * scale;
  return t;
}

float triangle_position_error(const BuiltMesh& mesh, const BuiltInstance& instance, uint32_t primitive, float time) {
  const auto [p0, p1, p2] = mesh.corners(primitive, time);
  Vec3 largest = glm::max(glm::abs(p0), glm::max(glm::abs(p1), glm::abs(p2)));
  if (mesh.deformation) [[unlikely]]
    largest = glm::max(largest, mesh.deformation->reach(mesh.triangles[primitive], time));
  const auto reach = [&](const Mat4& m) {
    return glm::abs(Vec3(m[0])) * largest.x + glm::abs(Vec3(m[1])) * largest.y + glm::abs(Vec3(m[2])) * largest.z +
           glm::abs(Vec3(m[3]));
  };
  if (instance.motion) [[unlikely]] {
    const KeyPair keys = keys_at(time, instance.motion_count);
    largest = glm::max(reach(instance.motion[keys.first]), reach(instance.motion[keys.first + 1]));
  } else if (!mesh.baked) {
    largest = reach(instance.world_from_object);
  }
  // Interpolation has rounding errors of its own.
  return gamma_bound(moves(mesh, instance) ? 24 : 12) * max_component(largest);
}

TriangleSample sample_triangle_li(const WorldTriangle& t, Vec3 p, Vec2 u) {
  TriangleSample s{Vec2(0.0f), Vec3(0.0f), 0.0f, 0.0f};
  const Vec3 to_p0 = t.p0 - p;
  const SphericalTriangle spherical(to_p0, to_p0 + t.e1, to_p0 + t.e2);
  if (spherical.usable()) {
    s.wi = spherical.sample(u);
    s.distance = glm::dot(t.normal, to_p0) / glm::dot(t.normal, s.wi);
    // Barycentric coordinates of the point in the plane (Cramer), clamped to the triangle.
    const Vec3 local = s.wi * s.distance - to_p0, n = glm::cross(t.e1, t.e2);
    const float n2 = length_squared(n);
    const float b1 = saturate(glm::dot(glm::cross(local, t.e2), n) / n2);
    s.barycentric = Vec2(b1, std::clamp(glm::dot(glm::cross(t.e1, local), n) / n2, 0.0f, 1.0f - b1));
    if (s.distance > 0.0f && s.distance < kInfinity) s.pdf_solid_angle = 1.0f / spherical.solid_angle();
    return s;
  }
  s.barycentric = warp::square_to_triangle(u);
  const Vec3 d = to_p0 + s.barycentric.x * t.e1 + s.barycentric.y * t.e2;
  s.distance = glm::length(d);
  s.wi = d / s.distance;
  const float pdf = sqr(s.distance) / (t.area * abs_dot(t.normal, s.wi));
  if (std::isfinite(pdf)) s.pdf_solid_angle = pdf;
  return s;
}

float pdf_triangle_li(const WorldTriangle& t, Vec3 p, Vec3 wi, float distance) {
  const Vec3 to_p0 = t.p0 - p;
  const SphericalTriangle spherical(to_p0, to_p0 + t.e1, to_p0 + t.e2);
  if (spherical.usable()) return 1.0f / spherical.solid_angle();
  const float projected = t.area * abs_dot(t.normal, wi);
  return projected > 0.0f ? sqr(distance) / projected : 0.0f;
}

ShadingPoint triangle_point(const ObjectDescription& object, const SeenTriangle& seen, Vec2 barycentric, Vec3 wo) {
  const auto& [mesh, instance, primitive, triangle, time, distance] = seen;
  ShadingPoint point;
  point.position = triangle.p0 + barycentric.x * triangle.e1 + barycentric.y * triangle.e2;
  point.dpdu = triangle.e1;
  point.dpdv = triangle.e2;
  point.wo = wo;
  point.barycentric = barycentric;
  point.primitive = primitive;
  point.mesh = &mesh;
  point.instance = &instance;
  point.object = &object;
  point.ray_kind = 0;
  point.ray_length = distance;
  point.time = time;
  Vec3 ns(0.0f);
  if (!mesh.normals.empty()) {
    const auto [n0, n1, n2] = mesh.corner_normals(primitive, time);
    ns = (1.0f - barycentric.x - barycentric.y) * n0 + barycentric.x * n1 + barycentric.y * n2;
    Mat4 moved;
    // A row vector: the inverse transpose times a column.
    if (!mesh.baked) ns = ns * Mat3(object_from_world(instance, time, moved));
  }
  const float ns_length = glm::length(ns);
  ns = ns_length > 0.0f ? ns / ns_length : triangle.normal;
  point.backfacing = glm::dot(triangle.normal, wo) < 0.0f;
  point.ng = point.backfacing ? -triangle.normal : triangle.normal;
  point.ns = point.backfacing ? -ns : ns;
  return point;
}

Color mean_emission(const ShaderProgram& program, const ObjectDescription& object, const SeenTriangle& seen,
                    int points) {
  // Centres of the four similar quarters; the first is that of the whole. More points are those of an irrational lattice,
  // because patterns of a texture often repeat at simple fractions.
  constexpr float a = 1.0f / 6.0f, b = 2.0f / 3.0f, c = 1.0f / 3.0f;
  constexpr Vec2 kQuarters[4] = {{c, c}, {a, a}, {b, a}, {a, b}};
  constexpr double kStepX = 0.7548776662466927, kStepY = 0.5698402909980532;  // powers of 1 over the plastic number
  const auto place = [&](int i) {
    if (points <= 4) return kQuarters[i];
    const Vec2 p(glm::fract(double(i) * kStepX), glm::fract(double(i) * kStepY));
    return p.x + p.y > 1.0f ? 1.0f - p : p;
  };
  const int sides = program.emission_depends_on_side() ? 2 : 1;
  Color sum(0.0f);
  for (int i = 0; i < points; ++i)
    for (int side = 0; side < sides; ++side) {
      const Vec3 wo = side == 0 ? seen.triangle.normal : -seen.triangle.normal;
      sum += program.evaluate_emission(triangle_point(object, seen, place(i), wo));
    }
  return sum / float(points * sides);
}

}  // namespace ajar
