// Ray portals: where rays go on, what counts behind them, and that no light is lost or counted twice.
#include "agreement.h"
#include "render/session.h"

namespace ajar::test_portals {

using namespace fixtures;

namespace {

/// A material of one Ray Portal. `position` is added to the place of the ray.
int add_portal(SceneDescription& d, Vec3 position, Vec3 direction, Color color = Color(1.0f), float straight = 0.0f) {
  GraphBuilder b;
  const int geometry = b.node("ShaderNodeNewGeometry");
  const int sum = b.node(
      "ShaderNodeVectorMath",
      {linked_input("Vector", geometry, "Position"), value_input("Vector_001", Vec4(position, 0.0f))},
      {text_property("operation", "ADD")});
  const NodeInput place = position == Vec3(0.0f) ? value_input("Position", 0.0f)
                                                 : linked_input("Position", sum, "Vector");
  const int portal = b.node("ShaderNodeBsdfRayPortal", {value_input("Color", Vec4(color, 1.0f)), place,
                                                        value_input("Direction", Vec4(direction, 0.0f))});
  b.graph.surface = {portal, "BSDF"};
  if (straight > 0.0f) {
    const int transparent = b.node("ShaderNodeBsdfTransparent", {value_input("Color", Vec4(1.0f))});
    b.graph.surface = {
        b.node("ShaderNodeMixShader", {value_input("Fac", straight), linked_input("Shader", portal, "BSDF"),
                                       linked_input("Shader_001", transparent, "BSDF")}),
        "Shader"};
  }
  return add_material(d, b);
}
int add_transparent(SceneDescription& d) {
  return add_closure(d, "ShaderNodeBsdfTransparent", {value_input("Color", Vec4(1.0f))});
}

/// A camera at (0, 0, 3) that sees only the plane z = 0.
SceneDescription above_a_plane() {
  SceneDescription d;
  set_camera(d, Vec3(0, 0, 3), Vec3(0.0f), 4);
  d.settings.bounces = {8, 8, 8, 8, 8, 0};
  return d;
}

std::vector<float> image(const SceneDescription& d, int samples = 4) { return render(d, "path", samples, 1); }

/// The room with a lamp below the ceiling, and a sheet of the material `make` returns between the lamp and the floor.
SceneDescription room_with_sheet(const std::function<int(SceneDescription&)>& make) {
  SceneDescription d = grey_room();
  add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), moved(Vec3(0.2f, 0.3f, -0.5f), 0.3f));
  add_object(d, plane(0.8f), make(d), moved(Vec3(0.05f, 0.1f, 0.4f)));
  add_object(d, plane(0.8f), add_diffuse(d, Color(0.0f), Color(2.0f)), moved(Vec3(0.1f, 0.1f, 0.9f)));
  return d;
}

void expect_same_mean(const SceneDescription& a, const SceneDescription& b, int samples = 32) {
  const RunningMoments first = whole(a, "path", samples, 16, 100), second = whole(b, "path", samples, 16, 300);
  const double visible = 4.8 * std::sqrt(first.variance_of_mean() + second.variance_of_mean()) / first.mean();
  EXPECT_LT(visible, 0.02) << "inconclusive";
  EXPECT_TRUE(statistical::means_agree(first, second)) << first.mean() << " and " << second.mean();
}

}  // namespace

TEST(Portals, a_ray_goes_on_at_another_place_in_another_direction_and_is_tinted) {
  SceneDescription d = above_a_plane();
  // From 10 metres aside, rays along +x meet a wall that shines.
  add_object(d, plane(5.0f), add_portal(d, Vec3(0, 10, 0), Vec3(3.0f, 0, 0), Color(0.5f, 1.0f, 0.25f)));
  Mat4 wall(Vec4(0, 0, -1, 0), Vec4(0, 1, 0, 0), Vec4(1, 0, 0, 0), Vec4(20, 10, 0, 1));
  add_object(d, plane(8.0f), add_diffuse(d, Color(0.0f), Color(2.0f, 3.0f, 4.0f)), wall);
  const std::vector<float> seen = image(d);
  for (size_t i = 0; i < seen.size(); i += 4) {
    EXPECT_NEAR(seen[i], 1.0f, 1e-5f);
    EXPECT_NEAR(seen[i + 1], 3.0f, 1e-5f);
    EXPECT_NEAR(seen[i + 2], 1.0f, 1e-5f);
  }
}

TEST(Portals, without_a_direction_the_ray_goes_straight_on_from_the_other_place) {
  SceneDescription d = above_a_plane();
  d.settings.transparent_film = true;
  add_object(d, plane(5.0f), add_portal(d, Vec3(0, 0, -100), Vec3(0.0f)));
  add_object(d, plane(40.0f), add_diffuse(d, Color(0.0f), Color(1.0f)), moved(Vec3(0, 0, -50)));  // passed over
  for (const float value : image(d)) EXPECT_EQ(value, 0.0f);  // nothing is seen, and alpha is 0
  add_object(d, plane(400.0f), add_diffuse(d, Color(0.0f), Color(2.0f)), moved(Vec3(0, 0, -150)));
  const std::vector<float> seen = image(d);
  for (size_t i = 0; i < seen.size(); i += 4) {
    EXPECT_NEAR(seen[i], 2.0f, 1e-5f);
    EXPECT_NEAR(seen[i + 3], 1.0f, 1e-5f);
  }
}

TEST(Portals, a_portal_counts_as_a_transparent_surface) {
  SceneDescription d = above_a_plane();
  set_world(d, Color(1.0f));
  add_object(d, plane(5.0f), add_portal(d, Vec3(0.0f), Vec3(0.0f)));
  EXPECT_NEAR(image(d)[0], 1.0f, 1e-5f);
  d.settings.bounces.transparent = 0;
  EXPECT_EQ(image(d)[0], 0.0f);
  d.settings.bounces = {0, 0, 0, 0, 8, 0};  // and not as a bounce
  EXPECT_NEAR(image(d)[0], 1.0f, 1e-5f);
}

TEST(Portals, light_path_knows_how_many_were_passed) {
  SceneDescription d = above_a_plane();
  for (const float z : {0.0f, -1.0f})
    add_object(d, plane(5.0f), add_portal(d, Vec3(0.0f), Vec3(0.0f)), moved(Vec3(0, 0, z)));
  GraphBuilder b;
  b.emit(b.node("ShaderNodeLightPath"), "Portal Depth");
  add_object(d, plane(40.0f), add_material(d, b), moved(Vec3(0, 0, -4)));
  EXPECT_NEAR(image(d)[0], 2.0f, 1e-5f);
}

TEST(Portals, no_shadow_ray_passes_even_where_the_portal_is_mixed_with_transparency) {
  for (const float straight : {0.0f, 0.5f}) {
    SceneDescription d = above_a_plane();
    add_object(d, plane(5.0f), add_diffuse(d, Color(0.5f)));
    // A lamp without extent, which only shadow rays find, behind a sheet beside the line of sight.
    d.lights.push_back(point_light(Vec3(6, 0, 4), 1000.0f));
    EXPECT_GT(image(d)[0], 0.01f);
    Mat4 sheet(Vec4(0, 0, -1, 0), Vec4(0, 1, 0, 0), Vec4(1, 0, 0, 0), Vec4(4, 0, 0, 1));
    add_object(d, plane(8.0f), add_portal(d, Vec3(0.0f), Vec3(0.0f), Color(1.0f), straight), sheet);
    for (size_t i = 0; i < 64; i += 4) EXPECT_EQ(image(d)[i], 0.0f);
  }
}

TEST(Portals, light_behind_a_portal_counts_once) {
  const SceneDescription clear = room_with_sheet(add_transparent);
  for (const float straight : {0.0f, 0.5f})
    expect_same_mean(clear, room_with_sheet([&](SceneDescription& d) {
                       return add_portal(d, Vec3(0.0f), Vec3(0.0f), Color(1.0f), straight);
                     }),
                     96);
}

TEST(Portals, light_behind_a_portal_counts_once_in_fog_with_a_guide_and_with_other_direct_light) {
  SceneDescription clear = room_with_sheet(add_transparent);
  SceneDescription portal = room_with_sheet([](SceneDescription& d) { return add_portal(d, Vec3(0.0f), Vec3(0.0f)); });
  for (SceneDescription* d : {&clear, &portal}) {
    d->settings.direct_samples = 4;
    d->settings.direct = DirectMethod::PmcHi;
    d->settings.guiding = Guiding::On;
  }
  expect_same_mean(clear, portal, 96);
  for (SceneDescription* d : {&clear, &portal}) {
    d->settings = RenderSettings(grey_room().settings);
    GraphBuilder fog;
    fog.graph.volume = {
        fog.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(0.8f)), value_input("Density", 0.3f)}),
        "Volume"};
    d->world.graph.nodes = fog.graph.nodes;
    d->world.graph.volume = fog.graph.volume;
    d->settings.bounces.volume = 4;
  }
  expect_same_mean(clear, portal, 96);
}

TEST(Portals, several_portals_of_a_surface_share_its_light) {
  SceneDescription d = above_a_plane();
  GraphBuilder b;
  int portals[2];
  for (int i = 0; i < 2; ++i)
    portals[i] = b.node("ShaderNodeBsdfRayPortal", {value_input("Color", Vec4(1.0f)), value_input("Position", 0.0f),
                                                    value_input("Direction", Vec4(i == 0 ? 1.0f : -1.0f, 0, 0, 0))});
  b.graph.surface = {
      b.node("ShaderNodeMixShader", {value_input("Fac", 0.25f), linked_input("Shader", portals[0], "BSDF"),
                                     linked_input("Shader_001", portals[1], "BSDF")}),
      "Shader"};
  add_object(d, plane(5.0f), add_material(d, b), moved(Vec3(0, 0, 1e-3f)));
  for (const float x : {-10.0f, 10.0f}) {
    Mat4 wall(Vec4(0, 0, -1, 0), Vec4(0, 1, 0, 0), Vec4(1, 0, 0, 0), Vec4(x, 0, 0, 1));
    add_object(d, plane(8.0f), add_diffuse(d, Color(0.0f), x > 0 ? Color(4.0f, 0, 0) : Color(0, 4.0f, 0)), wall);
  }
  const std::vector<float> seen = image(d, 4096);
  EXPECT_NEAR(seen[0], 3.0f, 0.03f);
  EXPECT_NEAR(seen[1], 1.0f, 0.03f);
}

TEST(Portals, other_techniques_are_replaced_by_path_tracing_and_say_so) {
  for (const bool visible : {true, false}) {
    SceneDescription d = above_a_plane();
    d.settings.integrator = "bdpt";
    d.settings.samples = 4;
    set_world(d, Color(1.0f));
    add_object(d, plane(5.0f), add_portal(d, Vec3(0.0f), Vec3(0.0f)));
    if (!visible) d.instances.clear();
    Session session;
    session.start(std::move(d));
    ASSERT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.take_error(), "");
    bool told = false;
    for (const Diagnostic& diagnostic : session.diagnostics())
      told |= diagnostic.message.find("ray portals") != std::string::npos;
    EXPECT_EQ(told, visible);
  }
}

}  // namespace ajar::test_portals
