#include <gtest/gtest.h>

#include "graph_fixtures.h"
#include "scene_fixtures.h"
#include "statistical.h"

namespace ajar::test_occlusion {

using namespace fixtures;
using namespace statistical;

namespace {

/// The values of the node on the floor near the origin, seen from above.
RunningMoments openness(SceneDescription d, bool bake, float distance, int samples, bool inside = false,
                        bool only_local = false) {
  GraphBuilder g;
  const int node = g.node(
      "ShaderNodeAmbientOcclusion", {value_input("Distance", distance), value_input("Color", Vec4(1.0f))},
      {number_property("samples", {float(samples)}), number_property("inside", {float(inside)}),
       number_property("only_local", {float(only_local)}), number_property("world_distance", {100.0f})});
  g.emit(node, "AO");
  for (MaterialDescription& material : d.materials) material.graph = g.graph;
  const auto scene = build(d, nullptr, bake);
  RunningMoments moments;
  for (int i = 0; i < 400; ++i) {
    Ray ray;
    ray.origin = Vec3(0.01f + 1e-5f * float(i), 0.02f, 1.0f);
    ray.direction = Vec3(0, 0, -1);
    const Hit hit = scene->intersect(ray, kRayCamera);
    ShadingPoint point;
    scene->shading_point(ray, hit, point);
    moments.add(scene->material(hit).evaluate_emission(point).x);
  }
  return moments;
}

Mat4 at(Vec3 place) { return Mat4(Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(place, 1)); }

/// A floor and a practically infinite wall in the plane x = 0.11, which half of the cosine-weighted directions hit.
SceneDescription corner(bool one_mesh) {
  SceneDescription d;
  const int grey = add_diffuse(d, Color(0.5f));
  MeshDescription floor = plane(1e4f);
  const Vec3 wall[] = {{0.11f, -1e4f, 0.0f}, {0.11f, 1e4f, 0.0f}, {0.11f, 1e4f, 2e4f}, {0.11f, -1e4f, 2e4f}};
  MeshDescription other;
  other.name = "Wall";
  MeshDescription& to = one_mesh ? floor : other;
  const uint32_t first = uint32_t(to.positions.size());
  to.positions.insert(to.positions.end(), std::begin(wall), std::end(wall));
  to.triangles.push_back(UVec3(first, first + 1, first + 2));
  to.triangles.push_back(UVec3(first, first + 2, first + 3));
  add_object(d, floor, grey);
  if (!one_mesh) add_object(d, other, grey);
  set_camera(d, Vec3(0, 0, 5), Vec3(0.001f, 0, 0), 8);
  return d;
}

}  // namespace

TEST(Occlusion, an_infinite_wall_occludes_half_of_the_light) {
  for (const bool bake : {false, true}) {
    for (const int samples : {1, 16}) {
      EXPECT_TRUE(mean_agrees(openness(corner(false), bake, 1e5f, samples), 0.5, {.test_count = 16}))
          << bake << samples;
      EXPECT_TRUE(mean_agrees(openness(corner(true), bake, 1e5f, samples, false, true), 0.5, {.test_count = 16}))
          << bake << samples;
    }
    EXPECT_EQ(openness(corner(false), bake, 1e5f, 16, false, true).mean(), 1.0);  // the wall is a different object
    EXPECT_EQ(openness(corner(false), bake, 0.1f * 0.9f, 16).mean(), 1.0);        // the wall is at a larger distance
    // Without a distance, that of the world is used.
    EXPECT_TRUE(mean_agrees(openness(corner(false), bake, 0.0f, 16), 0.5, {.test_count = 16}, 1e-3));
  }
}

TEST(Occlusion, the_inside_option_traces_rays_below_the_surface) {
  SceneDescription d;
  const int grey = add_diffuse(d, Color(0.5f));
  add_object(d, cube(), grey, at({0, 0, -1}));        // its top is the floor
  add_object(d, plane(50.0f), grey, at({0, 0, -2}));  // another object at its bottom
  set_camera(d, Vec3(0, 0, 5), Vec3(0.001f, 0, 0), 8);
  for (const bool bake : {false, true}) {
    EXPECT_EQ(openness(d, bake, 10.0f, 8).mean(), 1.0);
    EXPECT_EQ(openness(d, bake, 10.0f, 8, true).mean(), 0.0);
    EXPECT_EQ(openness(d, bake, 10.0f, 8, true, true).mean(), 0.0);
    EXPECT_EQ(openness(d, bake, 0.5f, 8, true).mean(), 1.0);
    // The walls are one unit away and the edges at the bottom are farther than 2.05, so that most rays of this length
    // hit the cube and some do not.
    const RunningMoments some = openness(d, bake, 2.05f, 8, true);
    EXPECT_GT(some.mean(), 0.0);
    EXPECT_LT(some.mean(), 0.6);
  }
}

TEST(Occlusion, without_a_scene_nothing_is_occluded_and_the_colour_is_returned) {
  GraphBuilder g;
  const int node = g.node("ShaderNodeAmbientOcclusion",
                          {value_input("Distance", 1.0f), value_input("Color", Vec4(0.25f, 0.5f, 0.75f, 1.0f))},
                          {number_property("samples", {16.0f})});
  g.emit(node, "Color");
  const Color shown = compile(g.graph).evaluate_emission(ShadingPoint());
  EXPECT_EQ(shown, Color(0.25f, 0.5f, 0.75f));
}

}  // namespace ajar::test_occlusion
