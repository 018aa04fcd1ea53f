// What only path tracing renders: it replaces other techniques there, and the artist is told.
#include "scene/path_tracing_only.h"

#include "agreement.h"
#include "render/session.h"

namespace ajar::test_path_tracing_only {

namespace {

using namespace fixtures;

/// A room with a Ray Portal.
SceneDescription with_a_portal() {
  SceneDescription d = grey_room(16);
  add_object(d, plane(0.5f), add_closure(d, "ShaderNodeBsdfRayPortal", {value_input("Color", Vec4(1.0f))}),
             moved(Vec3(0.0f, 0.5f, 0.0f)));
  d.lights.push_back(area_lamp(Vec3(0.0f, 0.0f, 0.7f), Vec3(0, 0, -1), 0.2f, 20.0f));
  return d;
}

TEST(PathTracingOnly, auto_measures_whether_a_guide_pays) {
  Session session;
  session.start(with(with_a_portal(), "auto", 20));
  ASSERT_TRUE(session.wait(kHang));
  EXPECT_NE(session.statistics_json().find("a measurement during the render decides"), std::string::npos);
}

TEST(PathTracingOnly, other_techniques_are_replaced_and_the_artist_is_told) {
  const std::vector<float> expected = render(with_a_portal(), "path", 16, 3);
  for (const char* technique : {"bdpt", "photon_map", "auto"}) {
    Session session;
    SceneDescription d = with(with_a_portal(), technique, 16);
    d.settings.seed = 3;
    session.start(std::move(d));
    ASSERT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.snapshot("Combined"), expected) << technique;
    EXPECT_NE(session.statistics_json().find("ray portals"), std::string::npos) << technique;
    // Again with the scene that is built.
    d = with(with_a_portal(), technique, 16);
    d.settings.seed = 3;
    session.change_view(d.camera, d.settings);
    ASSERT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.snapshot("Combined"), expected) << technique;
  }
}

// Other techniques cannot clamp. The image of `auto` must not depend on the one that it chooses.
TEST(PathTracingOnly, auto_does_not_clamp) {
  SceneDescription room = grey_room(16);
  room.lights.push_back(area_lamp(Vec3(0.0f, 0.0f, 0.7f), Vec3(0, 0, -1), 0.2f, 20.0f));
  const std::vector<float> plain = render(room, "path", 4, 3);
  room.settings.clamp_direct = room.settings.clamp_indirect = 0.01f;
  EXPECT_NE(render(room, "path", 4, 3), plain);
  Session session;
  SceneDescription d = with(room, "auto", 4);  // too few samples for a pilot: path tracing
  d.settings.seed = 3;
  session.start(std::move(d));
  ASSERT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.snapshot("Combined"), plain);
  EXPECT_NE(session.statistics_json().find("only path tracing can clamp"), std::string::npos);
}

/// A cube in a fog of the world, which may vary, with a sun or a lamp.
SceneDescription in_fog(bool varies, bool sun, Color sky) {
  SceneDescription d;
  add_object(d, cube(), add_diffuse(d, Color(0.5f)));
  set_camera(d, Vec3(0, -5, 0), Vec3(0), 8, 0.7f);
  GraphBuilder b;
  const int place = b.node("ShaderNodeNewGeometry"),
            parts = b.node("ShaderNodeSeparateXYZ", {linked_input("Vector", place, "Position")});
  b.graph.volume = {
      b.node("ShaderNodeVolumeScatter", {varies ? linked_input("Density", parts, "Z") : value_input("Density", 0.1f)}),
      "Volume"};
  b.graph.surface = {
      b.node("ShaderNodeBackground", {value_input("Color", Vec4(sky, 1.0f)), value_input("Strength", 1.0f)}),
      "Background"};
  d.world.graph = b.graph;
  d.lights.push_back(area_lamp(Vec3(0.0f, 0.0f, 3.0f), Vec3(0, 0, -1), 0.2f, 20.0f));
  if (sun) d.lights.back().kind = LightKind::Sun;
  return d;
}

TEST(PathTracingOnly, renders_light_from_infinity_through_fog_of_the_world_that_varies) {
  struct Case {
    bool varies, sun;
    Color sky;
    bool replaced;
  };
  for (const Case& c : {Case{true, true, Color(0.0f), true},
                        {true, false, Color(1.0f), true},
                        {true, false, Color(0.0f), false},
                        {false, true, Color(1.0f), false}}) {
    const auto is_replaced = [](const Session& session) {
      return session.statistics_json().find("a world volume that varies") != std::string::npos;
    };
    Session session;
    const SceneDescription d = with(in_fog(c.varies, c.sun, c.sky), "bdpt", 2);
    session.start(SceneDescription(d));
    ASSERT_TRUE(session.wait(kHang));
    EXPECT_EQ(is_replaced(session), c.replaced);
    session.change_view(d.camera, d.settings);  // with the scene that is built
    ASSERT_TRUE(session.wait(kHang));
    EXPECT_EQ(is_replaced(session), c.replaced);
  }
}

}  // namespace

}  // namespace ajar::test_path_tracing_only
