#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <nlohmann/json.hpp>

#include "film/tile_loop.h"
#include "integrators/integrator.h"
#include "math/statistics.h"
#include "render/session.h"
#include "renders.h"
#include "transport_scenes.h"

namespace ajar::test_path_tracer {

using namespace fixtures;

namespace {

std::vector<float> render(SceneDescription d, int samples, uint32_t seed = 1, int threads = 2) {
  d.settings.samples = samples;
  d.settings.seed = seed;
  d.settings.threads = threads;
  Session session;
  session.start(std::move(d));
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  return session.snapshot("Combined");
}

/// The mean of one channel over the image, and the standard error of this mean from independent seeds.
struct Estimate {
  double mean, standard_error;
};
Estimate estimate(const SceneDescription& d, int samples, int seeds, int channel = 0) {
  RunningMoments moments;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto image = render(d, samples, uint32_t(seed));
    double sum = 0.0;
    for (size_t i = size_t(channel); i < image.size(); i += 4) sum += double(image[i]);
    moments.add(sum / double(image.size() / 4));
  }
  return {moments.mean(), std::sqrt(moments.variance_of_mean())};
}

SceneDescription closed_furnace(float albedo) {
  SceneDescription d;
  add_object(d, cube(true), add_diffuse(d, Color(albedo), Color(1.0f - albedo)));
  set_camera(d, Vec3(0.1f, -0.5f, 0.2f), Vec3(0.3f, 0.5f, -0.1f), 8);
  d.settings.bounces = {1000, 1000, 1000, 1000, 1000, 0};
  return d;
}

}  // namespace

class Furnace : public ::testing::TestWithParam<float> {};

TEST_P(Furnace, a_closed_room_with_emission_one_minus_albedo_has_radiance_one) {
  const Estimate e = estimate(closed_furnace(GetParam()), 64, 16);
  EXPECT_NEAR(e.mean, 1.0, 4.0 * e.standard_error + 1e-5);
  EXPECT_LT(e.standard_error, 0.01);
}
INSTANTIATE_TEST_SUITE_P(Albedos, Furnace, ::testing::Values(0.0f, 0.2f, 0.5f, 0.8f, 0.95f));

TEST(PathTracer, a_white_object_is_invisible_in_a_white_world) {
  // Flat facets, since smooth normals scatter a ten-thousandth of the light below the facets.
  SceneDescription d;
  MeshDescription facets = sphere();
  facets.normals.clear();
  add_object(d, std::move(facets), add_diffuse(d, Color(1.0f)));
  set_camera(d, Vec3(0, -4, 0), Vec3(0), 16);
  set_world(d, Color(1.0f));
  d.settings.bounces = {1000, 1000, 1000, 1000, 1000, 0};
  const Estimate e = estimate(d, 64, 16);
  EXPECT_NEAR(e.mean, 1.0, 4.0 * e.standard_error + 1e-5);
}

TEST(PathTracer, irradiance_below_a_point_light_agrees_with_the_closed_form) {
  // A lamp of P watts is an isotropic source of radiant intensity P / (4 pi), as measured in Cycles 3.4.
  SceneDescription d;
  add_object(d, plane(100.0f), add_diffuse(d, Color(0.5f)));
  d.lights.push_back(point_light(Vec3(0, 0, 2), 100.0f));
  set_camera(d, Vec3(0, -0.001f, 1), Vec3(0), 1, 1e-4f);
  d.settings.bounces.total = 0;
  const auto image = render(d, 16);
  const double intensity = 100.0 / (4.0 * 3.14159265);
  EXPECT_NEAR(image[0], 0.5 / 3.14159265 * intensity / 4.0, 1e-5);
}

TEST(PathTracer, the_image_does_not_depend_on_the_number_of_threads) {
  SceneDescription d = closed_furnace(0.7f);
  d.settings.width = 40;
  d.settings.height = 33;
  d.lights.push_back(point_light(Vec3(0.2f, 0.1f, 0.5f), 5.0f, 0.1f));
  const auto one = render(d, 8, 5, 1);
  EXPECT_EQ(one, render(d, 8, 5, 2));
  EXPECT_EQ(one, render(d, 8, 5, 8));
  EXPECT_NE(one, render(d, 8, 6, 2));
}

TEST(PathTracer, rendering_a_region_gives_the_same_pixels_as_the_full_frame) {
  SceneDescription d = closed_furnace(0.7f);
  d.settings.width = d.settings.height = 16;
  const auto full = render(d, 4);
  d.settings.region = {3, 5, 9, 12};
  const auto part = render(d, 4);
  ASSERT_EQ(part.size(), 6u * 7u * 4u);
  for (size_t y = 0; y < 7; ++y)
    for (size_t x = 0; x < 6 * 4; ++x) EXPECT_EQ(part[y * 24 + x], full[((y + 5) * 16 + 3) * 4 + x]);
}

TEST(PathTracer, bounce_limit_zero_is_direct_light_only) {
  SceneDescription d = closed_furnace(0.5f);
  d.settings.bounces.total = 0;
  // Emission that is seen directly (0.5), and emission of the walls that is scattered once (0.5 * 0.5).
  const Estimate e = estimate(d, 64, 16);
  EXPECT_NEAR(e.mean, 0.75, 4.0 * e.standard_error);
}

/// Two translucent sheets between the eye and a sun.
TEST(PathTracer, a_translucent_bounce_is_transmission_and_its_ray_sees_what_transmitted_rays_see) {
  SceneDescription d;
  set_camera(d, Vec3(0.0f, 0.1f, -3.0f), Vec3(0.0f), 8);
  const int sheet = add_closure(d, "ShaderNodeBsdfTranslucent", {value_input("Color", Vec4(0.8f, 0.8f, 0.8f, 1.0f))});
  add_object(d, plane(20.0f), sheet);
  add_object(d, plane(20.0f), sheet, moved(Vec3(0.0f, 0.0f, 1.0f)));
  LightDescription sun;
  sun.kind = LightKind::Sun;
  sun.energy = 3.0f;
  sun.world_from_light = rows(shining(Vec3(0), Vec3(0, 0, -1)));
  d.lights.push_back(sun);
  const auto mean = [&](const std::string& integrator, int diffuse, int transmission, uint32_t hidden = 0) {
    d.settings.bounces = {8, diffuse, 0, transmission, 8, 0};
    d.objects[1].visibility = kVisibleAll & ~hidden;
    d.settings.integrator = integrator;
    const std::vector<float> image = render(d, 64);
    double sum = 0.0;
    for (size_t i = 0; i < image.size(); i += 4) sum += image[i];
    return sum / double(image.size() / 4);
  };
  for (const std::string integrator : {"path", "bdpt"}) {
    SCOPED_TRACE(integrator);
    const double all = mean(integrator, 8, 8);
    EXPECT_GT(all, 0.3);
    EXPECT_NEAR(mean(integrator, 0, 8), all, 0.01 * all);
    EXPECT_NEAR(mean(integrator, 8, 1), all, 0.01 * all);
    EXPECT_EQ(mean(integrator, 8, 0), 0.0);
  }
  EXPECT_GT(mean("path", 8, 8, kVisibleDiffuse), 0.3);
  EXPECT_EQ(mean("path", 8, 8, kVisibleTransmission), 0.0);
}

/// A wall that a lamp lights by way of a dark polished floor only: a card is between the lamp and the wall.
TEST(PathTracer, light_in_a_dim_reflection_does_not_get_the_weight_of_russian_roulette) {
  constexpr float kWall = 0.5f, kFloor = 0.04f, kLamp = 100.0f;
  SceneDescription d;
  set_camera(d, Vec3(0.0f, 0.5f, 1.0f), Vec3(0.0f, 1.0f, 1.0f), 32);
  d.settings.bounces = {2, 2, 2, 2, 2, 8};
  add_object(d, plane(2.0f), add_glossy(d, 0.05f, Color(kFloor)));
  add_object(d, plane(1.0f), add_diffuse(d, Color(0.0f)), shining(Vec3(0.0f, 0.4f, 1.8f), Vec3(0.0f, 1.0f, 0.0f)));
  add_object(d, plane(2.0f), add_diffuse(d, Color(kWall)), shining(Vec3(0.0f, 1.0f, 2.0f), Vec3(0.0f, 1.0f, 0.0f)));
  add_object(d, plane(0.2f), add_diffuse(d, Color(0.0f), Color(kLamp)), moved(Vec3(0.0f, 0.0f, 1.5f)));
  const auto image = render(d, 1);
  float brightest = 0.0f;
  for (size_t i = 0; i < image.size(); i += 4) brightest = std::max(brightest, image[i]);
  EXPECT_GT(brightest, 0.5f * kWall * kFloor * kLamp);
  EXPECT_LT(brightest, 1.5f * kWall * kFloor * kLamp);
}

/// A bright world behind many sheets that each let half of the light through.
SceneDescription tinted_sheets(int count) {
  SceneDescription d;
  set_camera(d, Vec3(0.0f, 0.1f, -3.0f), Vec3(0.0f), 32);
  const int sheet = add_closure(d, "ShaderNodeBsdfTransparent", {value_input("Color", Vec4(0.5f, 0.5f, 0.5f, 1.0f))});
  for (int i = 0; i < count; ++i) add_object(d, plane(100.0f), sheet, moved(Vec3(0.0f, 0.0f, float(i))));
  set_world(d, Color(std::exp2(float(count))));
  d.settings.bounces = {8, 8, 8, 8, 1000, 0};
  return d;
}

TEST(PathTracer, russian_roulette_behind_tinted_surfaces_keeps_the_mean) {
  const Estimate e = estimate(tinted_sheets(8), 64, 24);
  EXPECT_NEAR(e.mean, 1.0, 4.0 * e.standard_error);
  EXPECT_LT(e.standard_error, 0.005);
  EXPECT_GT(e.standard_error, 0.0);
  const Estimate few = estimate(tinted_sheets(3), 1, 2);
  EXPECT_NEAR(few.mean, 1.0, 1e-5);
  EXPECT_LT(few.standard_error, 1e-6);  // few sheets make no noise
}

TEST(PathTracer, paths_end_behind_many_tinted_surfaces) {
  constexpr int kSheets = 100;
  Session session;
  session.start(with(tinted_sheets(kSheets), "path", 4));
  ASSERT_TRUE(session.wait(kHang));
  const auto told = nlohmann::json::parse(session.statistics_json());
  EXPECT_LT(double(told["rays"]), 0.1 * kSheets * double(told["paths"]));
}

// tests/timing measures how soon a render stops. This test checks that it stops and keeps its image.
TEST(Session, cancel_stops_a_render_and_keeps_its_image) {
  SceneDescription d = closed_furnace(0.95f);
  d.settings.width = d.settings.height = 64;
  d.settings.samples = 1 << 24;
  Session session;
  session.start(d);
  while (session.progress().samples < 1) session.wait(0.01);
  session.cancel();
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.progress().phase, Progress::Phase::Cancelled);
  EXPECT_FALSE(session.snapshot("Combined").empty());
}

// Cancelling is fast because no thread starts a sample after `stop` is set.
TEST(TileLoop, stops_before_the_next_sample) {
  Film film(0, 0, 64, 64, {"Combined"});
  std::atomic<bool> stop{false};
  std::atomic<int> begun{0}, begun_after_stop{0};
  constexpr int kThreads = 4;
  tbb::task_arena(kThreads).execute([&] {
    for_each_sample(
        film, 1000, stop, [] { return 0; },
        [&](int, int, int, uint32_t) {
          if (stop.load()) ++begun_after_stop;
          if (++begun == 100) stop.store(true);
        });
  });
  EXPECT_GE(begun, 100);
  // A thread may have read `stop` just before it was set.
  EXPECT_LT(begun_after_stop, kThreads);
}

TEST(Session, stops_at_the_time_limit_and_at_the_error_target) {
  SceneDescription d = closed_furnace(0.5f);
  d.settings.samples = 0;
  d.settings.seconds = 0.3;
  Session timed;
  timed.start(d);
  EXPECT_TRUE(timed.wait(kHang));
  EXPECT_EQ(timed.progress().phase, Progress::Phase::Done);
  EXPECT_GE(timed.progress().render_seconds, 0.3);  // tests/timing has the upper bound
  d.settings.seconds = 0.0;
  d.settings.target_error = 1e-4;
  Session precise;
  precise.start(d);
  EXPECT_TRUE(precise.wait(kHang));
  EXPECT_LE(precise.progress().estimated_relmse, 1e-4);
}

// Each render is stopped by the clock at an arbitrary point of its second or a later iteration. In a closed furnace,
// all radiance is 1.
TEST(Session, a_time_limit_within_an_iteration_keeps_the_mean) {
  for (const char* integrator : {"path", "bdpt", "metropolis", "erpt", "pmc_pt", "photon_map", "mps"}) {
    RunningMoments means;
    for (uint32_t seed = 1; seed <= 8; ++seed) {
      SceneDescription d = closed_furnace(0.5f);
      d.settings.width = d.settings.height = 96;
      d.settings.integrator = integrator;
      d.settings.samples = 0;
      d.settings.seconds = 0.04;
      d.settings.seed = seed;
      Session session;
      session.start(d);
      ASSERT_TRUE(session.wait(kHang));
      EXPECT_EQ(session.take_error(), "");
      EXPECT_EQ(session.progress().phase, Progress::Phase::Done);
      double sum = 0.0, smallest = 1e9;
      const std::vector<float> image = session.snapshot("Combined"), counts = session.snapshot("Sample Count");
      for (size_t i = 0; i < image.size(); i += 4) sum += double(image[i]);
      for (size_t i = 0; i < counts.size(); ++i) smallest = std::min(smallest, double(counts[i]));
      EXPECT_GE(smallest, 1.0) << integrator;
      means.add(sum / double(image.size() / 4));
    }
    // Photon mapping has a bias at edges, here of at most 2 %.
    const double bias = std::string(integrator) == "photon_map" || std::string(integrator) == "mps" ? 0.02 : 0.0;
    EXPECT_NEAR(means.mean(), 1.0, bias + 4.0 * std::sqrt(means.variance_of_mean()) + 1e-3) << integrator;
    EXPECT_LT(std::sqrt(means.variance_of_mean()), 0.01) << integrator << ": too noisy for the test";
  }
}

TEST(Session, errors_are_reported_once_and_list_the_valid_choices) {
  SceneDescription d = closed_furnace(0.5f);
  d.settings.integrator = "warp";
  Session session;
  session.start(d);
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.progress().phase, Progress::Phase::Failed);
  EXPECT_NE(session.take_error().find("metropolis"), std::string::npos);
  EXPECT_EQ(session.take_error(), "");
}

TEST(Session, statistics_have_the_keys_that_the_command_line_documents) {
  SceneDescription d = closed_furnace(0.5f);
  d.settings.samples = 4;
  Session session;
  session.start(d);
  EXPECT_TRUE(session.wait(kHang));
  const std::string json = session.statistics_json();
  for (const char* key : {"version", "integrator", "seeds", "threads", "resolution", "samples_per_pixel", "rays",
                          "build_seconds", "render_seconds", "peak_memory_bytes", "refused_samples", "plan", "hints",
                          "acceptance_rates", "estimated_error"})
    EXPECT_NE(json.find("\"" + std::string(key) + "\""), std::string::npos) << key;
}

TEST(Session, several_sessions_run_at_once) {
  std::vector<std::unique_ptr<Session>> sessions;
  for (int i = 0; i < 4; ++i) {
    SceneDescription d = closed_furnace(0.5f);
    d.settings.samples = 16;
    sessions.push_back(std::make_unique<Session>());
    sessions.back()->start(d);
  }
  const auto expected = render(closed_furnace(0.5f), 16, 0);
  for (auto& session : sessions) {
    EXPECT_TRUE(session->wait(kHang));
    EXPECT_EQ(session->snapshot("Combined"), expected);
  }
}

}  // namespace ajar::test_path_tracer
