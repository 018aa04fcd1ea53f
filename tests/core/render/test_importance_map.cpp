#include "render/importance_map.h"

#include <numeric>

#include <gtest/gtest.h>

#include "integrators/path_tracer.h"
#include "math/random.h"
#include "render/session.h"
#include "statistical.h"
#include "transport_scenes.h"

namespace ajar::test_importance_map {

using namespace fixtures;

namespace {

const std::atomic<bool> kGoOn{false};

/// One source of each type: a lamp, a triangle mesh, a mesh whose emission is no light, a sun, and the world.
SceneDescription all_sources(bool fog) {
  SceneDescription d;
  d.settings.bounces = {6, 6, 6, 6, 6, 6};
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.6f, 0.5f, 0.7f)), moved(Vec3(0, 0, -0.5f)));
  add_object(d, sphere(6), add_diffuse(d, Color(0.3f), Color(0.9f, 0.5f, 0.2f)),
             moved(Vec3(-0.5f, 0.2f, -0.2f), 0.25f));
  GraphBuilder incidence;  // its emission depends on the direction of view
  const int weight = incidence.node("ShaderNodeLayerWeight", {value_input("Blend", 0.5f)});
  incidence.graph.surface = {incidence.node("ShaderNodeEmission", {value_input("Color", Vec4(1.0f)),
                                                                   linked_input("Strength", weight, "Facing")}),
                             "Emission"};
  add_object(d, sphere(6), add_material(d, incidence), moved(Vec3(0.5f, 0.2f, -0.2f), 0.25f));
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.9f), Vec3(0, 0, -1), 0.4f, 8.0f));
  d.lights.push_back(point_light(Vec3(0, 0, 5), 1.0f));
  d.lights.back().kind = LightKind::Sun;
  d.lights.back().sun_angle = 0.02f;
  set_checker_world(d, Color(0.5f), Color(0.1f), 3.0f);
  if (fog) {
    GraphBuilder b;
    b.graph.volume = {
        b.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(0.9f)), value_input("Density", 0.4f)}), "Volume"};
    add_object(d, cube(), add_material(d, b), moved(Vec3(0.0f, 0.0f, 0.5f), 0.95f));
  }
  set_camera(d, Vec3(0.1f, -3.0f, 1.2f), Vec3(0.0f, 0.0f, -0.2f), 8, 0.5f);
  return d;
}

/// Two lamps above the two sides of a floor. Each illuminates its own side.
SceneDescription two_lamps(int size) {
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.6f)), moved(Vec3(0, 0, -0.5f)));
  add_object(d, cube(), add_diffuse(d, Color(0.5f)),
             Mat4(Vec4(0.02f, 0, 0, 0), Vec4(0, 3, 0, 0), Vec4(0, 0, 0.6f, 0), Vec4(0, 0, 0, 1)));
  for (const float x : {-0.6f, 0.6f}) d.lights.push_back(area_lamp(Vec3(x, 0.0f, 0.4f), Vec3(0, 0, -1), 0.3f, 10.0f));
  set_camera(d, Vec3(0.0f, -1.0f, 3.0f), Vec3(0.0f, 0.0f, -0.5f), size, 0.3f);
  d.settings.samples = 32;
  d.settings.image = ImageSampling::PmcIp;
  d.settings.passes = {"Combined", "Sample Count"};
  return d;
}

struct Halves {
  double light[2] = {0.0, 0.0}, samples[2] = {0.0, 0.0};
  std::string statistics, said;
};
Halves render(const SceneDescription& d) {
  Session session;
  session.start(d);
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  const auto image = session.snapshot("Combined"), counts = session.snapshot("Sample Count");
  Halves halves;
  const size_t width = size_t(d.settings.width);
  for (size_t i = 0; i < counts.size(); ++i) {
    halves.light[i % width >= width / 2] += double(image[4 * i + 1]);
    halves.samples[i % width >= width / 2] += double(counts[i]);
  }
  halves.statistics = session.statistics_json();
  for (const Diagnostic& diagnostic : session.diagnostics()) halves.said += diagnostic.message;
  return halves;
}

}  // namespace

TEST(ImportantLight, equals_the_light_of_sources_with_a_higher_emission) {
  // Light is linear: multiplying the emission of a source equals multiplying the light that arrives from it.
  const auto sum = [](const std::vector<Vec2>& light) {
    return std::accumulate(light.begin(), light.end(), Vec2(0.0f));
  };
  for (const bool fog : {false, true}) {
    SCOPED_TRACE(fog ? "fog" : "clear");
    const SceneDescription plain = all_sources(fog);
    for (int source = 0; source < 5; ++source) {
      SCOPED_TRACE(source);
      SceneDescription important = plain, brighter = plain;
      const auto brighten = [&](const char* socket, NodeGraph& graph) {
        for (Node& node : graph.nodes)
          for (NodeInput& input : node.inputs)
            if (node.type == std::string("ShaderNodeEmission") || node.type == std::string("ShaderNodeBackground"))
              if (input.socket == socket) input.value *= 4.0f;
      };
      if (source < 2) {
        important.lights[size_t(source)].light_importance = 4.0f;
        brighter.lights[size_t(source)].energy *= 4.0f;
      } else if (source < 4) {
        important.objects[size_t(source - 1)].light_importance = 4.0f;
        brighten("Color", brighter.materials[size_t(source - 1)].graph);
      } else {
        important.world.light_importance = 4.0f;
        brighten("Strength", brighter.world.graph);
      }
      const auto scene = build(important), other = build(brighter), before = build(plain);
      ASSERT_TRUE(scene->any_light_importance());
      RunningMoments told, wanted, all, luminance;
      for (uint32_t seed = 0; seed < 12; ++seed) {
        const Vec2 light = sum(measure_important_light(scene, seed, 8.0f, kGoOn));
        told.add(double(light.y));
        all.add(double(light.x));
        wanted.add(double(sum(measure_important_light(other, seed + 100, 8.0f, kGoOn)).x));
        luminance.add(double(sum(measure_important_light(before, seed + 200, 8.0f, kGoOn)).x));
      }
      EXPECT_TRUE(statistical::means_agree(told, wanted, {0.01, 20}));
      EXPECT_TRUE(statistical::means_agree(all, luminance, {0.01, 20}));
      EXPECT_FALSE(statistical::means_agree(told, all));
    }
  }
}

TEST(ImportanceMap, is_the_mean_importance_of_the_light) {
  SceneDescription d = two_lamps(16);
  d.lights[0].light_importance = 6.0f;
  const auto scene = build(d);
  const std::vector<float> map = importance_map(scene, 7, kGoOn);
  ASSERT_EQ(map.size(), 256u);
  EXPECT_NEAR(map[8 * 16 + 2], 6.0f, 0.2f);
  EXPECT_NEAR(map[8 * 16 + 13], 1.0f, 0.2f);
  EXPECT_EQ(importance_map(scene, 7, kGoOn), map);
}

TEST(ImportanceMap, is_not_computed_if_no_light_is_more_important) {
  SceneDescription d = two_lamps(8);
  d.objects[0].light_importance = 3.0f;  // has no emission
  d.world.light_importance = 3.0f;       // black
  EXPECT_FALSE(has_importance(*build(d)));
  EXPECT_TRUE(importance_map(build(d), 1, kGoOn).empty());
  EXPECT_EQ(render(d).statistics.find("importance of light"), std::string::npos);
  d.lights[1].light_importance = NAN;  // validation replaces it
  EXPECT_FALSE(has_importance(*build(d)));
}

TEST(ImportanceMap, pixels_with_important_light_get_more_samples_and_keep_their_mean) {
  for (const char* integrator : {"path", "bdpt"}) {
    SCOPED_TRACE(integrator);
    RunningMoments mean[2][2];
    for (uint32_t seed = 0; seed < 40; ++seed) {
      for (const bool important : {false, true}) {
        SceneDescription d = two_lamps(8);
        d.settings.integrator = integrator;
        d.settings.seed = important ? seed + 100 : seed;
        if (important) d.lights[0].light_importance = 6.0f;
        const Halves r = render(d);
        for (int half = 0; half < 2; ++half) mean[important][half].add(r.light[half]);
        if (!important) continue;
        EXPECT_GT(r.samples[0], 2.0 * r.samples[1]);
        EXPECT_NEAR(r.samples[0] + r.samples[1], 32.0 * 64.0, 0.5);
        EXPECT_NE(r.statistics.find("importance of light"), std::string::npos);
      }
    }
    for (int half = 0; half < 2; ++half) EXPECT_TRUE(statistical::means_agree(mean[1][half], mean[0][half], {0.01, 4}));
  }
}

TEST(ImportanceMap, chains_report_that_importance_is_ignored) {
  SceneDescription d = two_lamps(8);
  d.settings.integrator = "metropolis";
  d.settings.samples = 2;
  EXPECT_EQ(render(d).said.find("importance has no effect"), std::string::npos);
  d.lights[0].light_importance = 2.0f;
  EXPECT_NE(render(d).said.find("importance has no effect"), std::string::npos);
}

}  // namespace ajar::test_importance_map
