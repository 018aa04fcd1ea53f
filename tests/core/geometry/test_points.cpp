// Point clouds: intersections with rays, the shading point at a hit, rays that leave and cross points.
#include "geometry/points.h"

#include <gtest/gtest.h>

#include "math/random.h"
#include "math/warps.h"
#include "render/session.h"
#include "scene_fixtures.h"
#include "shading/functions/point_functions.h"

namespace ajar::test_points {

using namespace fixtures;

namespace {

SceneDescription empty_scene() {
  SceneDescription d;
  set_camera(d, Vec3(0, -4, 0), Vec3(0), 16);
  return d;
}

Ray ray_of(Vec3 origin, Vec3 direction) {
  Ray ray;
  ray.origin = origin;
  ray.direction = glm::normalize(direction);
  return ray;
}

ShadingPoint met(const Scene& scene, Vec3 origin, Vec3 direction) {
  const Ray ray = ray_of(origin, direction);
  ShadingPoint point;
  const Hit hit = scene.intersect(ray, kRayCamera);
  EXPECT_TRUE(hit.found());
  if (hit.found()) scene.shading_point(ray, hit, point);
  return point;
}

const Diagnostic* find(const Diagnostics& diagnostics, const std::string& text) {
  for (const Diagnostic& d : diagnostics)
    if (d.message.find(text) != std::string::npos) return &d;
  return nullptr;
}

Mat4 stretched(Vec3 scale, Vec3 to) {
  return Mat4(Vec4(scale.x, 0, 0, 0), Vec4(0, scale.y, 0, 0), Vec4(0, 0, scale.z, 0), Vec4(to, 1));
}

}  // namespace

TEST(Points, hits_and_normals_are_those_of_spheres) {
  SceneDescription d = empty_scene();
  add_object(d, cloud({{0, 0, 0}, {1, 0, 0}}, {0.25f, 0.5f}), add_diffuse(d, Color(0.5f)));
  const auto scene = build(d);
  EXPECT_EQ(scene->statistics().points, 2u);
  const ShadingPoint point = met(*scene, {1.3f, -5, 0.1f}, {0, 1, 0});
  const Vec3 normal(0.6f, -std::sqrt(1.0f - 0.36f - 0.04f), 0.2f);
  EXPECT_LT(glm::length(point.ns - normal), 1e-6f);
  EXPECT_LT(glm::length(point.ng - normal), 1e-6f);
  EXPECT_LT(glm::length(point.position - (Vec3(1, 0, 0) + 0.5f * normal)), 1e-6f);
  EXPECT_EQ(point.primitive, 1u);
  EXPECT_FALSE(point.backfacing);
  EXPECT_NEAR(glm::dot(point.dpdu, point.ns), 0.0f, 1e-6f);
  EXPECT_NEAR(glm::length(point.dpdv), 1.0f, 1e-6f);
}

TEST(Points, a_ray_that_leaves_a_point_does_not_hit_it_at_any_scale_or_distance) {
  Pcg32 rng(3);
  const auto anywhere = [&] { return warp::square_to_sphere({rng.next_float(), rng.next_float()}); };
  for (const float scale : {1e-4f, 1.0f, 1e4f})
    for (const float away : {0.0f, 10.0f, 1e4f})
      for (const Vec3 axes : {Vec3(1.0f), Vec3(1.0f, 2.0f, 0.5f)}) {
        SceneDescription d = empty_scene();
        const Vec3 center(away * scale, -0.5f * away * scale, 0);
        add_object(d, cloud({Vec3(0)}, {1.0f}), add_diffuse(d, Color(0.5f)), stretched(scale * axes, center));
        const auto scene = build(d);
        EXPECT_EQ(scene->meshes()[0].baked, axes == Vec3(1.0f));  // others are ellipsoids
        for (int i = 0; i < 1000; ++i) {
          const Vec3 from = center + 50.0f * scale * anywhere(), to = center + 0.4f * scale * anywhere();
          const ShadingPoint point = met(*scene, from, to - from);
          ASSERT_GT(glm::dot(point.ng, point.wo), 0.0f);
          // Its distance from the surface by an independent formula.
          const glm::dvec3 unit = (glm::dvec3(point.position) - glm::dvec3(center)) /
                                  (double(scale) * glm::dvec3(axes));
          const double bound = double(max_component(point.position_error)) / double(scale);
          EXPECT_LT(std::abs(glm::length(unit) - 1.0), 8.0 * bound);
          EXPECT_FALSE(scene->is_blocked(scene->spawn_ray(point, anywhere())));  // outwards, and inwards through it
        }
      }
}

TEST(Points, a_small_point_far_from_the_origin_of_a_ray_keeps_its_shape) {
  SceneDescription d = empty_scene();
  add_object(d, cloud({{0, 0, 0}}, {0.01f}), add_diffuse(d, Color(0.5f)));
  const auto scene = build(d);
  for (const float x : {-0.008f, 0.0f, 0.005f}) {
    const ShadingPoint point = met(*scene, {x, -30000, 0}, {0, 1, 0});
    EXPECT_LT(glm::length(point.position), 0.01001f);
    EXPECT_NEAR(point.ns.x, x / 0.01f, 1e-4f);
    EXPECT_NEAR(point.ns.y, -std::sqrt(1.0f - sqr(x / 0.01f)), 1e-4f);
  }
}

TEST(Points, a_ray_towards_the_inner_side_of_a_place_ends_before_the_point) {
  Pcg32 rng(4);
  for (const Vec3 axes : {Vec3(1.0f), Vec3(1.0f, 2.0f, 0.5f)}) {
    SceneDescription d = empty_scene();
    add_object(d, cloud({Vec3(0)}, {1.0f}), add_diffuse(d, Color(0.5f)), stretched(axes, Vec3(3, 2, 1)));
    const auto scene = build(d);
    for (int i = 0; i < 1000; ++i) {
      const Vec3 from = Vec3(3, 2, 1) + 5.0f * warp::square_to_sphere({rng.next_float(), rng.next_float()});
      const ShadingPoint point = met(*scene, from, Vec3(3, 2, 1) - from);
      const Vec3 direction = warp::square_to_sphere({rng.next_float(), rng.next_float()});
      const float way = way_out(point, direction);
      if (glm::dot(direction, point.ng) >= 0.0f) {
        EXPECT_EQ(way, 0.0f);
        continue;
      }
      if (glm::dot(direction, point.ng) > -0.02f) continue;  // rounding errors move the end of a tangent far
      Ray ray = ray_of(point.position + 10.0f * direction, -direction);
      EXPECT_NEAR(scene->intersect(ray, kRayCamera).t, 10.0f - way, 2e-3f);
      ray.t_max = 10.0f - way;
      EXPECT_FALSE(scene->is_blocked(ray));
    }
  }
}

TEST(Points, instanced_baked_and_moving_points_give_the_same_hits) {
  const Mat4 matrix(Vec4(0, 2, 0, 0), Vec4(-2, 0, 0, 0), Vec4(0, 0, 2, 0), Vec4(0.5f, 0.25f, 1, 1));
  SceneDescription d = empty_scene();
  add_object(d, random_cloud(100, 0.05f), add_diffuse(d, Color(0.5f)), matrix);
  SceneDescription moves = d;
  moves.instances[0].motion_key_count = 2;
  moves.motion_keys = {rows(matrix), rows(moved(Vec3(1, 0, 0), 1.0f) * matrix)};
  const auto baked = build(d), instanced = build(d, nullptr, false), moving = build(moves);
  EXPECT_TRUE(baked->meshes()[0].baked);
  EXPECT_FALSE(instanced->meshes()[0].baked);
  Pcg32 rng(8);
  int found = 0, alike = 0;
  for (int i = 0; i < 10000; ++i) {
    const Vec3 center(0.5f, 0.25f, 1);
    const Vec3 from = center + 6.0f * warp::square_to_sphere({rng.next_float(), rng.next_float()});
    Ray ray = ray_of(from, center + 2.0f * warp::square_to_sphere({rng.next_float(), rng.next_float()}) - from);
    const Hit a = baked->intersect(ray, kRayCamera), b = instanced->intersect(ray, kRayCamera);
    ray.time = 0.5f;
    ray.origin.x += 0.5f;
    const Hit c = moving->intersect(ray, kRayCamera);
    if (!a.found() || !b.found() || !c.found()) continue;
    ShadingPoint p, q, r;
    moving->shading_point(ray, c, r);
    ray.origin.x -= 0.5f;
    baked->shading_point(ray, a, p);
    instanced->shading_point(ray, b, q);
    ++found;
    const auto same = [&](const ShadingPoint& other, Vec3 shift) {
      return p.primitive == other.primitive && glm::length(p.position + shift - other.position) < 1e-4f &&
             glm::dot(p.ns, other.ns) > 0.9999f;
    };
    alike += same(q, Vec3(0)) && same(r, Vec3(0.5f, 0, 0)) ? 1 : 0;
  }
  EXPECT_GT(found, 1000);
  EXPECT_GT(alike, found * 98 / 100);  // grazing rays may hit or miss
}

TEST(Points, white_points_are_invisible_in_a_white_world) {
  SceneDescription d = empty_scene();
  set_camera(d, Vec3(0, -4, 0), Vec3(0), 24, 0.4f);
  set_world(d, Color(1.0f));
  add_object(d, cloud({{-0.6f, 0, 0}, {0.6f, 0, 0}}, {0.3f, 0.1f}), add_diffuse(d, Color(1.0f)));
  d.settings.samples = 64;
  d.settings.bounces.total = d.settings.bounces.diffuse = 64;
  Session session;
  session.start(std::move(d));
  ASSERT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  for (const float value : session.snapshot("Combined")) ASSERT_NEAR(value, 1.0f, 1e-3f);
}

TEST(Points, point_info_and_attributes_are_those_of_the_point) {
  MeshDescription mesh = cloud({{-1, 0, 0}, {1, 0, 0}}, {0.5f, 0.25f});
  mesh.material_slots = {0, 1};
  mesh.attributes.push_back({"heat", Domain::Vertex, 1, {2, 3}});
  mesh.attributes.push_back({"tint", Domain::Vertex, 4, {0, 0, 0, 1, 0.1f, 0.2f, 0.3f, 0.4f}});
  for (const Vec3 axes : {Vec3(2.0f), Vec3(1, 1, 2)}) {
    SceneDescription d = empty_scene();
    const int first = add_diffuse(d, Color(0.5f)), second = add_diffuse(d, Color(0.2f));
    d.objects[size_t(add_object(d, mesh, first, stretched(axes, Vec3(0, 0, 3))))].materials = {first, second};
    const auto scene = build(d);
    const ShadingPoint point = met(*scene, {axes.x + 0.1f, -5, 3}, {0, 1, 0});
    using nodes::PointOutput;
    EXPECT_EQ(nodes::point_info(point, PointOutput::Position), Vec3(axes.x, 0, 3));
    EXPECT_NEAR(nodes::point_info(point, PointOutput::Radius).x, 0.25f * glm::length(axes) / std::sqrt(3.0f), 1e-6f);
    // Values of Cycles 3.4.1 and 5.2.3.
    EXPECT_NEAR(nodes::point_info(point, PointOutput::Random).x, 0.295f, 5e-4f);
    EXPECT_EQ(nodes::attribute(point, "heat", nullptr).x, 3.0f);
    EXPECT_EQ(nodes::attribute(point, "tint", nullptr), Vec4(0.1f, 0.2f, 0.3f, 0.4f));
    EXPECT_EQ(nodes::attribute(point, "", nullptr), Vec4(0.0f));  // point clouds have no default colour
    EXPECT_EQ(nodes::hair_info(point, nodes::HairOutput::Length), 0.0f);
    EXPECT_LT(glm::length(nodes::generated(point) - nodes::object_position(point)), 1e-6f);
    EXPECT_LT(glm::length(nodes::object_position(point) - (point.position - Vec3(0, 0, 3)) / axes), 1e-5f);
    // The normal is the direction from the centre, also on ellipsoids, as in Cycles.
    EXPECT_LT(glm::length(point.ns - glm::normalize(point.position - Vec3(axes.x, 0, 3))), 1e-5f);
    EXPECT_EQ(scene->material_index(point), second);
    EXPECT_EQ(nodes::active_uv(point), Vec3(0.0f));
    EXPECT_FALSE(nodes::is_near_edge(point, 1.0f));
    EXPECT_NEAR(nodes::point_info(met(*scene, {-axes.x, -5, 3}, {0, 1, 0}), PointOutput::Random).x, 0.860f, 5e-4f);
  }
}

TEST(Points, invalid_points_are_left_out_and_reported_with_the_name) {
  const auto built = [](MeshDescription mesh, const char* text) {
    SceneDescription d = empty_scene();
    const int material = add_diffuse(d, Color(0.5f));
    add_object(d, plane(1.0f), material);
    add_object(d, std::move(mesh), material);
    Diagnostics diagnostics;
    auto scene = build(d, &diagnostics);
    const Diagnostic* found = find(diagnostics, text);
    EXPECT_TRUE(found) << text;
    EXPECT_EQ(found ? found->object : "", "Cloud");
    return scene;
  };
  const MeshDescription good = cloud({{0, 0, 3}, {1, 0, 3}, {2, 0, 3}}, {0.1f, 0.1f, 0.1f});
  for (const float radius : {-1.0f, std::nanf(""), kInfinity}) {
    MeshDescription bad = good;
    bad.radii[1] = radius;
    const auto scene = built(bad, "1 point with invalid radii or positions left out");
    EXPECT_FALSE(scene->is_blocked(ray_of({1, -5, 3}, {0, 1, 0})));
    EXPECT_EQ(met(*scene, {2, -5, 3}, {0, 1, 0}).primitive, 2u);  // random values keep their points
  }
  MeshDescription bad = good;
  bad.positions[0].x = kInfinity;
  EXPECT_LT(built(bad, "1 point with invalid radii or positions left out")->radius(), 5.0f);
  bad = good;
  bad.radii.pop_back();
  EXPECT_EQ(built(bad, "The radii do not match the points")->statistics().points, 0u);
  bad = good;
  bad.material_slots = {0};
  built(bad, "Material slots do not match the points");
  bad = good;
  bad.attributes.push_back({"uv", Domain::Corner, 2, {}});
  built(bad, "Attribute 'uv' does not match");
}

TEST(Points, points_of_radius_zero_are_invisible) {
  for (const bool all : {false, true}) {
    SceneDescription d = empty_scene();
    add_object(d, cloud({{0, 0, 0}, {1, 0, 0}}, {0.0f, all ? 0.0f : 0.1f}), add_diffuse(d, Color(0.5f)));
    Diagnostics diagnostics;
    const auto scene = build(d, &diagnostics);
    EXPECT_TRUE(diagnostics.empty());
    EXPECT_FALSE(scene->is_blocked(ray_of({0, -5, 0}, {0, 1, 0})));
    EXPECT_EQ(scene->is_blocked(ray_of({1, -5, 0}, {0, 1, 0})), !all);
  }
}

TEST(Points, emissive_points_are_not_lights_and_are_reported) {
  SceneDescription d = empty_scene();
  add_object(d, cloud({{0, 0, 0}}, {0.1f}), add_diffuse(d, Color(0.5f), Color(2.0f)));
  Diagnostics diagnostics;
  const auto scene = build(d, &diagnostics);
  EXPECT_TRUE(scene->emission_without_lights());
  EXPECT_EQ(scene->lights().size(), 0u);
  EXPECT_TRUE(find(diagnostics, "only random rays find"));
}

}  // namespace ajar::test_points
