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

}  // namespace

}  // namespace ajar::test_path_tracing_only
