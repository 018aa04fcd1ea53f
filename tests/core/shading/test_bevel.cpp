#include <gtest/gtest.h>

#include "graph_fixtures.h"
#include "scene_fixtures.h"
#include "shading/functions/ray_functions.h"

namespace ajar::test_bevel {

using namespace fixtures;

namespace {

constexpr float kRadius = 0.5f;
constexpr int kMany = 20000;

/// A cube with edges of 2 metres whose material has the node, and another object that touches it.
std::shared_ptr<const Scene> cube_scene(bool bake, Mat4 where, float node_radius = kRadius, int node_samples = 4) {
  GraphBuilder g;
  const int bevel = g.node("ShaderNodeBevel", {value_input("Radius", node_radius)},
                           {number_property("samples", {float(node_samples)})});
  g.emit(bevel, "Normal");
  SceneDescription d;
  MaterialDescription material;
  material.name = "Bevel";
  material.graph = g.graph;
  d.materials.push_back(material);
  add_object(d, cube(), 0, where);
  add_object(d, plane(50.0f), add_diffuse(d, Color(0.5f)),
             Mat4(Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, 0, 0.9f, 1)));
  set_camera(d, Vec3(0, 0, 5), Vec3(0.001f, 0, 0), 8);
  return build(d, nullptr, bake);
}

ShadingPoint seen(const Scene& scene, Vec3 from, Vec3 direction) {
  Ray ray;
  ray.origin = from;
  ray.direction = direction;
  const Hit hit = scene.intersect(ray, kRayCamera);
  ShadingPoint point;
  scene.shading_point(ray, hit, point);
  return point;
}

/// The mean of the normals of two planes that meet at a right angle, at a distance from the edge: of the plane of the
/// point (y) and of the other one (x).
Vec2 mean_normal(float to_edge) {
  constexpr int kSteps = 400;
  constexpr float kStep = 2.0f * kRadius / kSteps;
  const auto weight = [](float x, float y, float z) {
    const float left = std::max(kRadius - std::sqrt(x * x + y * y + z * z), 0.0f);
    return left * left * left;
  };
  Vec2 sum(0.0f);
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const float a = (float(i) + 0.5f) * kStep - kRadius, b = (float(j) + 0.5f) * kStep - kRadius;
      if (a < to_edge) sum.y += weight(a, b, 0.0f);
      if (a < 0.0f) sum.x += weight(to_edge, b, a);
    }
  }
  return glm::normalize(sum);
}

}  // namespace

TEST(Bevel, normals_near_an_edge_are_the_weighted_mean_of_both_sides) {
  const Mat4 mirrored = Mat4(Vec4(-1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, 0, 0, 1));
  for (const Mat4& where : {Mat4(1.0f), mirrored}) {
    for (const bool bake : {false, true}) {
      const auto scene = cube_scene(bake, where);
      for (const float to_edge : {0.02f, 0.1f, 0.3f}) {
        const Vec2 expected = mean_normal(to_edge);
        const ShadingPoint above = seen(*scene, Vec3(1.0f - to_edge, 0.1f, 3.0f), Vec3(0, 0, -1));
        const Vec3 n = nodes::bevelled_normal(above, kRadius, kMany);
        EXPECT_NEAR(n.x, expected.x, 0.01f) << to_edge;
        EXPECT_NEAR(n.y, 0.0f, 0.01f) << to_edge;
        EXPECT_NEAR(n.z, expected.y, 0.01f) << to_edge;
        // From inside, the normal is turned.
        const ShadingPoint inside = seen(*scene, Vec3(0.95f, 1.0f - to_edge, 0.0f), Vec3(1, 0, 0));
        const Vec3 m = nodes::bevelled_normal(inside, kRadius, kMany);
        EXPECT_NEAR(m.x, -expected.y, 0.01f) << to_edge;
        EXPECT_NEAR(m.y, -expected.x, 0.01f) << to_edge;
      }
    }
  }
}

TEST(Bevel, a_plane_keeps_its_normal_and_other_objects_do_not_count) {
  const auto scene = cube_scene(true, Mat4(1.0f));
  const ShadingPoint point = seen(*scene, Vec3(0.1f, 0.2f, 3.0f), Vec3(0, 0, -1));
  EXPECT_EQ(nodes::bevelled_normal(point, 0.5f, 16), Vec3(0, 0, 1));
  EXPECT_EQ(nodes::bevelled_normal(point, 0.0f, 16), Vec3(0, 0, 1));
  EXPECT_EQ(nodes::bevelled_normal(point, 0.5f, 0), Vec3(0, 0, 1));
}

TEST(Bevel, the_node_has_the_value_of_the_function_at_every_visit) {
  const auto scene = cube_scene(true, Mat4(1.0f), 0.4f, 100);
  const ShadingPoint point = seen(*scene, Vec3(0.9f, 0.93f, 3.0f), Vec3(0, 0, -1));
  const Vec3 value = nodes::bevelled_normal(point, 0.4f, 100);
  EXPECT_GT(value.x, 0.0f);
  EXPECT_GT(value.y, 0.0f);
  const uint32_t material = scene->materials_of(*point.instance)[0];
  EXPECT_EQ(scene->programs()[material].evaluate_emission(point), Color(glm::max(value, 0.0f)));
  EXPECT_EQ(nodes::bevelled_normal(point, 0.4f, 100), value);
}

TEST(Bevel, a_linked_normal_gets_the_difference_to_the_surface) {
  GraphBuilder g;
  const int other = g.node("ShaderNodeCombineXYZ",
                           {value_input("X", 0.6f), value_input("Y", 0.0f), value_input("Z", 0.8f)});
  const int bevel = g.node("ShaderNodeBevel", {value_input("Radius", 0.1f), linked_input("Normal", other, "Vector")},
                           {number_property("samples", {4.0f})});
  g.emit(bevel, "Normal");
  ShadingPoint point;  // without a scene there is no difference
  const Color normal = compile(g.graph).evaluate_emission(point);
  EXPECT_NEAR(normal.x, 0.6f, 1e-6f);
  EXPECT_NEAR(normal.z, 0.8f, 1e-6f);
}

}  // namespace ajar::test_bevel
