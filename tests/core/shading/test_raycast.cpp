#include <gtest/gtest.h>

#include "graph_fixtures.h"
#include "scene_fixtures.h"
#include "shading/functions/ray_functions.h"

namespace ajar::test_raycast {

using namespace fixtures;

namespace {

/// A plane at z = 0 with this material, and a cube with edges of 2 metres around (0, 0, 3).
std::shared_ptr<const Scene> plane_below_cube(const GraphBuilder& g) {
  SceneDescription d;
  MaterialDescription material;
  material.name = "Raycast";
  material.graph = g.graph;
  d.materials.push_back(material);
  add_object(d, plane(50.0f), 0);
  MeshDescription box = cube();
  Attribute place{"place", Domain::Vertex, 4, {}}, wide{"wide", Domain::Face, 3, {}};
  for (const Vec3 p : box.positions) place.values.insert(place.values.end(), {p.x, p.y, p.z, 0.5f});
  for (size_t i = 0; i < box.triangles.size(); ++i) wide.values.insert(wide.values.end(), {0.5f, 1.25f, 2.0f});
  box.attributes = {place, wide};
  add_object(d, box, add_diffuse(d, Color(0.5f)),
             Mat4(Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, 0, 3, 1)));
  set_camera(d, Vec3(9, 0, 1), Vec3(5, 0, 0), 8);
  return build(d);
}

/// The same where the material emits this output of the node.
std::shared_ptr<const Scene> plane_below_cube(const char* output, std::initializer_list<NodeInput> inputs,
                                              bool only_local) {
  GraphBuilder g;
  const int node = g.node("ShaderNodeRaycast", inputs, {number_property("only_local", {only_local ? 1.0f : 0.0f})});
  g.emit(node, output);
  return plane_below_cube(g);
}

/// The point of the plane at (x, 0.2).
ShadingPoint on_plane(const Scene& scene, float x) {
  Ray ray;
  ray.origin = Vec3(x, 0.2f, 0.5f);
  ray.direction = Vec3(0, 0, -1);
  ShadingPoint point;
  scene.shading_point(ray, scene.intersect(ray, kRayCamera), point);
  return point;
}

Color emission_at(const Scene& scene, float x) {
  const ShadingPoint point = on_plane(scene, x);
  return scene.programs()[scene.materials_of(*point.instance)[0]].evaluate_emission(point);
}
Color emission_on_plane(const GraphBuilder& g, float x) { return emission_at(*plane_below_cube(g), x); }
Color emitted(const char* output, float x, std::initializer_list<NodeInput> inputs, bool only_local = false) {
  const auto scene = plane_below_cube(output, inputs, only_local);
  return emission_at(*scene, x);
}

}  // namespace

TEST(Raycast, finds_the_nearest_object_along_the_normal) {
  const std::initializer_list<NodeInput> length = {value_input("Length", 5.0f)};
  EXPECT_EQ(emitted("Is Hit", 0.3f, length), Color(1.0f));
  EXPECT_EQ(emitted("Self Hit", 0.3f, length), Color(0.0f));
  EXPECT_NEAR(emitted("Hit Distance", 0.3f, length).x, 2.0f, 1e-5f);
  EXPECT_LT(glm::distance(emitted("Hit Position", 0.3f, length), Color(0.3f, 0.2f, 2.0f)), 1e-5f);
  EXPECT_EQ(emitted("Hit Normal", 0.3f, length), Color(0.0f));  // (0, 0, -1), and there is no negative light
}

TEST(Raycast, without_a_hit_has_the_length_and_zeros) {
  for (const float x : {4.0f, 0.3f}) {  // beside the cube, and with a ray that ends before it
    const std::initializer_list<NodeInput> length = {value_input("Length", 1.5f)};
    EXPECT_EQ(emitted("Is Hit", x, length), Color(0.0f));
    EXPECT_EQ(emitted("Hit Distance", x, length), Color(1.5f));
    EXPECT_EQ(emitted("Hit Position", x, length), Color(0.0f));
    EXPECT_EQ(emitted("Hit Normal", x, length), Color(0.0f));
  }
}

TEST(Raycast, only_local_hits_the_object_of_the_point_alone) {
  EXPECT_EQ(emitted("Is Hit", 0.3f, {value_input("Length", 5.0f)}, true), Color(0.0f));
}

TEST(Raycast, the_function_measures_in_lengths_of_the_direction) {
  const auto scene = plane_below_cube("Is Hit", {}, true);
  const ShadingPoint point = on_plane(*scene, 0.3f);
  const nodes::RaycastHit hit = nodes::raycast(point, {point.position, Vec3(0, 0, 0.5f), 5.0f, false});
  EXPECT_TRUE(hit.found);
  EXPECT_NEAR(hit.distance, 4.0f, 1e-5f);
  EXPECT_EQ(hit.normal, Vec3(0, 0, -1));
  EXPECT_FALSE(nodes::raycast(point, {point.position, Vec3(0, 0, 0.5f), 3.0f, false}).found);
  // A ray from another place may hit the surface of the point, from both sides.
  for (const float z : {1.0f, -1.0f}) {
    for (const bool only_local : {false, true}) {
      const nodes::RaycastHit own = nodes::raycast(point, {Vec3(3, 3, z), Vec3(0, 0, -z), 2.0f, only_local});
      EXPECT_TRUE(own.found && own.own);
      EXPECT_NEAR(own.distance, 1.0f, 1e-5f);
      EXPECT_EQ(own.normal, Vec3(0, 0, z));
    }
  }
}

TEST(Raycast, reads_attributes_of_the_mesh_that_it_hits) {
  const auto at_hit = [](const char* output, const char* type, const char* name, float x, bool only_local = false) {
    GraphBuilder g;
    const int node = g.node("ShaderNodeRaycast", {value_input("Length", 5.0f)},
                            {number_property("only_local", {only_local ? 1.0f : 0.0f}), text_property("Value_1", name),
                             text_property("attribute_type_1", type)});
    g.emit(node, output);
    return emission_on_plane(g, x);
  };
  const float x = 0.3f;
  // The attribute is (x, y, z, 0.5) of the cube's corners, in the space of the cube; the ray hits (0.3, 0.2, -1).
  EXPECT_LT(glm::distance(at_hit("Attribute_1", "RGBA", "place", x), Color(0.3f, 0.2f, 0.0f)), 1e-5f);
  EXPECT_NEAR(at_hit("Attribute_1_Alpha", "RGBA", "place", x).x, 0.5f, 1e-5f);
  EXPECT_NEAR(at_hit("Attribute_1", "VALUE", "wide", x).x, 1.25f, 1e-5f);  // the mean, as of the node Attribute
  EXPECT_EQ(at_hit("Attribute_1", "RGBA", "unknown", x), Color(0.0f));
  EXPECT_EQ(at_hit("Attribute_1", "RGBA", "place", 4.0f), Color(0.0f));        // no hit
  EXPECT_EQ(at_hit("Attribute_1_Alpha", "RGBA", "place", 4.0f), Color(0.0f));  // no hit
  EXPECT_EQ(at_hit("Attribute_1", "RGBA", "place", x, true), Color(0.0f));     // the plane alone
}

TEST(Raycast, invalid_rays_hit_nothing) {
  const auto scene = plane_below_cube("Is Hit", {}, true);
  const ShadingPoint point = on_plane(*scene, 0.3f);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const Vec3 up(0, 0, 1);
  EXPECT_FALSE(nodes::raycast(point, {point.position, Vec3(0.0f), 5.0f, false}).found);
  EXPECT_FALSE(nodes::raycast(point, {point.position, Vec3(nan), 5.0f, false}).found);
  EXPECT_FALSE(nodes::raycast(point, {point.position, Vec3(infinity), 5.0f, false}).found);
  EXPECT_FALSE(nodes::raycast(point, {Vec3(nan), up, 5.0f, false}).found);
  EXPECT_FALSE(nodes::raycast(point, {point.position, up, nan, false}).found);
  EXPECT_FALSE(nodes::raycast(point, {point.position, up, -1.0f, false}).found);
  EXPECT_FALSE(nodes::raycast(ShadingPoint(), {Vec3(0.0f), up, 5.0f, false}).found);  // there is no scene
  EXPECT_TRUE(nodes::raycast(point, {point.position, up, infinity, false}).found);
}

}  // namespace ajar::test_raycast
