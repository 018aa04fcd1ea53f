#include <gtest/gtest.h>

#include "agreement.h"
#include "render/session.h"
#include "transport_scenes.h"

namespace ajar::test_caught_light {

using namespace fixtures;

namespace {

SceneDescription floor_with_ball(bool transparent) {
  SceneDescription d = grey_room();
  d.instances.clear();
  d.world.color = Color(0.5f);
  d.settings.transparent_film = transparent;
  add_object(d, plane(0.9f), add_diffuse(d, Color(0.6f)), moved(Vec3(0.0f, 0.0f, -0.8f), 1.0f));
  d.objects.back().shadow_catcher = true;
  add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), moved(Vec3(0.2f, 0.3f, -0.4f), 0.35f));
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f));
  return d;
}

std::vector<float> render(const SceneDescription& d, const std::string& pass = "Combined") {
  const auto scene = build(d);
  const std::atomic<bool> stop{false};
  const auto integrator = make_integrator("path");
  Film film(0, 0, d.settings.width, d.settings.height, {"Combined"});
  integrator->prepare(scene, 7);
  integrator->run_iteration(film, 64, stop);
  return film.resolve(pass, 1.0f);
}

}  // namespace

TEST(CaughtLight, the_composite_of_sums_follows_the_formula) {
  CaughtLight light;
  light.enable(1, true);
  // Of four samples, two are caught and half in shadow, one shows an object and one nothing.
  light.add(0, {.caught = true, .lit = Color(0.5f), .alone = Color(1.0f)}, false);
  light.add(0, {.caught = true, .lit = Color(0.5f), .alone = Color(1.0f)}, true);
  light.add(0, {.matte = Color(0.8f), .alpha = 1.0f}, false);
  light.add(0, {}, true);
  float out[4], ratio[3];
  light.composite(0, 2, 2, 1.0, out);
  EXPECT_FLOAT_EQ(out[0], 0.2f);
  EXPECT_FLOAT_EQ(out[3], 1.0f - 0.75f * 0.5f);
  light.shadow(0, ratio);
  EXPECT_FLOAT_EQ(ratio[1], 0.5f);
}

TEST(CaughtLight, without_other_objects_a_catcher_is_invisible) {
  for (const bool transparent : {true, false}) {
    SceneDescription d = floor_with_ball(transparent);
    d.instances.pop_back();
    const std::vector<float> image = render(d);
    for (size_t i = 0; i < image.size(); i += 4) {
      EXPECT_NEAR(image[i + 3], transparent ? 0.0f : 1.0f, 1e-5f);
      EXPECT_NEAR(image[i], transparent ? 0.0f : 0.5f, 1e-5f);
    }
  }
}

TEST(CaughtLight, a_ball_throws_a_shadow_on_a_catcher_and_keeps_its_colour) {
  const std::vector<float> image = render(floor_with_ball(true)),
                           shadow = render(floor_with_ball(true), "Shadow Catcher");
  SceneDescription plain = floor_with_ball(true);
  plain.objects[plain.objects.size() - 2].shadow_catcher = false;
  const std::vector<float> usual = render(plain);
  int shaded = 0, opaque = 0;
  for (size_t i = 0; i < image.size(); i += 4) {
    const float ratio = shadow[i / 4 * 3];
    EXPECT_GE(ratio, 0.0f);
    if (ratio < 0.9f && image[i + 3] < 1.0f) ++shaded;
    if (ratio == 1.0f && image[i + 3] == 1.0f) {  // only the ball
      ++opaque;
      for (size_t c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(image[i + c], usual[i + c]);
    }
  }
  EXPECT_GT(shaded, 5);
  EXPECT_GT(opaque, 5);
}

TEST(CaughtLight, a_catcher_behind_clear_glass_is_invisible) {
  // The glass bends no ray. It is near the camera and takes little light from the floor.
  SceneDescription d = floor_with_ball(true);
  d.instances.pop_back();
  const Vec3 eye(0.0f, -0.9f, 0.2f), down = glm::normalize(Vec3(0.0f, 0.9f, -1.0f));
  set_camera(d, eye, eye + down, 12);
  GraphBuilder b;
  b.graph.surface = {b.node("ShaderNodeBsdfRefraction", {value_input("Color", Vec4(1.0f)),
                                                         value_input("Roughness", 0.0f), value_input("IOR", 1.0f)}),
                     "BSDF"};
  add_object(d, plane(1.0f), add_material(d, b), shining(eye + 0.02f * down, down) * moved(Vec3(0.0f), 0.05f));
  const auto mean_alpha = [&] {
    const std::vector<float> image = render(d);
    double sum = 0.0;
    for (size_t i = 3; i < image.size(); i += 4) sum += double(image[i]);
    return sum / double(image.size() / 4);
  };
  EXPECT_GT(mean_alpha(), 0.95);
  d.settings.transparent_glass = true;
  EXPECT_LT(mean_alpha(), 0.05);
}

TEST(CaughtLight, other_techniques_are_replaced_by_path_tracing_and_say_so) {
  SceneDescription d = floor_with_ball(true);
  d.settings.integrator = "bdpt";
  d.settings.samples = 4;
  Session session;
  session.start(std::move(d));
  ASSERT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  bool told = false;
  for (const Diagnostic& diagnostic : session.diagnostics())
    told |= diagnostic.message.find("shadow catchers") != std::string::npos;
  EXPECT_TRUE(told);
}

// Path tracing is one of the choices of `auto`: the plan says why, and there is nothing to warn of.
TEST(CaughtLight, auto_renders_shadow_catchers_by_path_tracing_without_a_warning) {
  for (const char* integrator : {"auto", "bdpt"}) {
    SceneDescription d = floor_with_ball(true);
    d.settings.integrator = integrator;
    d.settings.samples = 1;
    Session session;
    session.start(std::move(d));
    ASSERT_TRUE(session.wait(kHang));
    const bool is_auto = std::string(integrator) == "auto";
    EXPECT_EQ(session.statistics_json().find("path tracing: the others do not render") != std::string::npos, is_auto);
    bool warned = false;
    for (const Diagnostic& diagnostic : session.diagnostics())
      warned |= diagnostic.message.find("is rendered by Path Tracing") != std::string::npos;
    EXPECT_EQ(warned, !is_auto);
  }
}

}  // namespace ajar::test_caught_light
