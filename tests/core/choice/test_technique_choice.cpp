// `auto` chooses an efficient technique and gives the reason. It does not change the scene, and its choice depends only
// on the seed.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "choice/technique_choice.h"
#include "math/warps.h"
#include "transport_scenes.h"

namespace ajar::test_technique_choice {

namespace {

using namespace fixtures;

const std::atomic<bool> kGoOn{false};

/// A floor below an unoccluded lamp.
SceneDescription open_scene() {
  SceneDescription d;
  add_object(d, plane(4.0f), add_diffuse(d, Color(0.5f)));
  d.lights.push_back(area_lamp(Vec3(0, 0, 2), Vec3(0, 0, -1), 1.0f, 50.0f));
  set_camera(d, Vec3(0.1f, -3.0f, 3.0f), Vec3(0.0f), 200);
  return d;
}
/// Hair below a sky with dark and bright parts: each path finds light, but with noise.
SceneDescription lit_hair() {
  SceneDescription d = open_scene();
  add_object(d, curls(2000, StrandShape::Ribbon), add_diffuse(d, Color(0.7f, 0.5f, 0.3f)), moved(Vec3(0.0f), 2.0f));
  d.lights.clear();
  set_checker_world(d, Color(0.1f), Color(2.0f), 3.0f);
  return d;
}
/// A bulb in a glass ball. Light sampling does not find it, and paths from the eye rarely do.
SceneDescription bulb_in_glass() {
  SceneDescription d = grey_room(200);
  const Vec3 at(0.5f, 0.3f, 0.3f);
  add_object(d, sphere(), add_glass(d, 0.0f), moved(at, 0.2f));
  add_object(d, sphere(), add_diffuse(d, Color(0.0f), Color(5e5f)), moved(at, 0.003f));
  return d;
}

/// A pool: a floor below a pane of glass, lit by a small sun and by the sky. Paths find the light of the sky with little
/// noise, and never that of the sun.
SceneDescription sunny_pool() {
  SceneDescription d = open_scene();
  MeshDescription pane = cube();
  for (Vec3& p : pane.positions) p.z *= 0.1f;
  add_object(d, pane, add_glass(d, 0.0f), moved(Vec3(0.0f, 0.0f, 0.5f), 3.0f));
  d.lights.front().kind = LightKind::Sun;
  d.lights.front().energy = 5.0f;
  d.lights.front().sun_angle = 0.005f;
  set_world(d, Color(0.3f));
  return d;
}

TechniqueChoice choose(SceneDescription d, int threads = 1, bool may_mix = false) {
  d.settings.samples = 256;
  d.settings.integrator = "auto";
  Diagnostics diagnostics;
  const CameraDescription camera = d.camera;
  TechniqueChoice choice;
  tbb::task_arena arena(threads);
  arena.execute([&] {
    const std::shared_ptr<Scene> scene = Scene::build(std::move(d), {}, diagnostics);
    const RenderSettings before = scene->settings();
    choice = choose_technique(scene, camera, kGoOn, nullptr, may_mix);
    EXPECT_TRUE(scene->settings() == before) << "the settings have not changed";
    EXPECT_EQ(scene.use_count(), 1) << "no reference to the scene remains";
  });
  return choice;
}

TEST(TechniqueChoice, path_tracing_is_chosen_for_unoccluded_light) {
  const TechniqueChoice choice = choose(open_scene());
  EXPECT_EQ(choice.settings.integrator, "path");
  EXPECT_EQ(choice.trials.size(), 1u) << "no other technique is tried";
  EXPECT_EQ(choice.settings.width, 200);
}

TEST(TechniqueChoice, does_not_depend_on_light_power_times_exposure) {
  const TechniqueChoice plain = choose(hidden_lamp());
  for (float RenderSettings::*const exposure : {&RenderSettings::exposure, &RenderSettings::view_exposure}) {
    SceneDescription bright = hidden_lamp();
    constexpr float kTimes = 4096.0f;
    bright.lights[0].energy *= kTimes;
    bright.settings.*exposure /= kTimes;
    const TechniqueChoice scaled = choose(std::move(bright));
    EXPECT_EQ(plain.settings.integrator, scaled.settings.integrator);
    ASSERT_EQ(plain.trials.size(), scaled.trials.size());
    for (size_t k = 0; k < plain.trials.size(); ++k)
      EXPECT_NEAR(plain.trials[k].relmse, scaled.trials[k].relmse, 0.01 * plain.trials[k].relmse);
  }
}

TEST(TechniqueChoice, path_tracing_is_not_chosen_for_occluded_light) {
  const TechniqueChoice choice = choose(hidden_lamp());
  EXPECT_NE(choice.settings.integrator, "path");
  ASSERT_GT(choice.trials.size(), 1u);
  const PlanSteps plan = choice.plan();
  EXPECT_EQ(plan.size(), 1 + choice.trials.size());
  EXPECT_EQ(plan[0].step, "technique");
  EXPECT_NE(plan[0].reason.find(choice.name), std::string::npos);
  int used = 0;
  for (const PlanStep& step : plan) used += step.used ? 1 : 0;
  EXPECT_EQ(used, 2) << "the technique and its trial";
}

TEST(TechniqueChoice, samples_are_those_that_the_work_of_path_tracing_pays_for) {
  EXPECT_EQ(choose(open_scene()).samples_of_work, 1.0);
  const double of_others = choose(hidden_lamp()).samples_of_work;
  EXPECT_GT(of_others, 0.05);
  EXPECT_LT(of_others, 1.0);
  EXPECT_EQ(samples_for_work(256, 0.25), 64);
  EXPECT_EQ(samples_for_work(256, 1.0), 256);
  EXPECT_EQ(samples_for_work(256, 0.01), 16) << "its noise can be estimated";
  EXPECT_EQ(samples_for_work(8, 0.1), 8) << "never more than asked";
  EXPECT_EQ(samples_for_work(0, 0.5), 0) << "no limit";
}

TEST(TechniqueChoice, a_denoised_image_of_occluded_light_tries_all_techniques) {
  for (uint32_t seed = 0; seed < 9; ++seed) {
    SceneDescription d = hidden_lamp();
    d.settings.denoised = true;
    d.settings.seed = seed;
    const TechniqueChoice choice = choose(std::move(d));
    ASSERT_EQ(choice.trials.size(), 3u);
    EXPECT_NE(choice.settings.integrator, "path") << "seed " << seed;
  }
}

TEST(TechniqueChoice, light_that_paths_never_find_is_not_taken_for_light_without_noise) {
  SceneDescription d = sunny_pool();
  d.settings.denoised = true;
  const TechniqueChoice choice = choose(d);
  EXPECT_EQ(choice.settings.integrator, "bdpt");
  // Without the sun, path tracing finds all light.
  d.lights.clear();
  EXPECT_EQ(choose(d).settings.integrator, "path");
}
TEST(TechniqueChoice, only_a_denoised_image_has_several_techniques) {
  for (const bool denoised : {false, true})
    for (const bool may_mix : {false, true}) {
      SceneDescription d = hidden_lamp();
      d.settings.denoised = denoised;
      d.settings.seed = 1;  // one with which the pilot finds a clear difference (see the test above)
      const TechniqueChoice choice = choose(std::move(d), 1, may_mix);
      const bool mixes = denoised && may_mix;
      EXPECT_EQ(!choice.mixed.techniques.empty(), mixes);
      EXPECT_EQ(choice.plan().back().step == "several techniques", mixes);
      if (!mixes) continue;
      EXPECT_EQ(choice.mixed.techniques[0].integrator, choice.settings.integrator);
      double shares = 0.0;
      for (const auto& technique : choice.mixed.techniques) shares += technique.share;
      EXPECT_NEAR(shares, 1.0, 1e-9);
      EXPECT_GT(choice.mixed.trial_work, 0.0);
    }
  SceneDescription easy = lit_hair();
  easy.settings.denoised = true;
  EXPECT_TRUE(choose(std::move(easy), 1, true).mixed.techniques.empty());
}

TEST(TechniqueChoice, a_denoised_image_of_light_that_paths_find_ends_the_pilot_early) {
  SceneDescription d = lit_hair();
  d.settings.denoised = true;
  const TechniqueChoice choice = choose(std::move(d));
  ASSERT_EQ(choice.trials.size(), 2u) << "path tracing has a relMSE of " << choice.trials[0].relmse;
  EXPECT_EQ(choice.trials[1].name, std::string("photon mapping"));
  EXPECT_EQ(choice.settings.integrator, "path");
  EXPECT_EQ(choice.settings.guiding, Guiding::Off) << "a measurement of guiding would not pay";
}

TEST(TechniqueChoice, an_image_without_light_is_not_taken_for_one_without_noise) {
  for (uint32_t seed = 1; seed <= 2; ++seed) {
    SceneDescription d = bulb_in_glass();
    d.settings.seed = seed;
    d.settings.vertex_merging = Merging::On;
    const TechniqueChoice choice = choose(std::move(d));
    EXPECT_NE(choice.settings.integrator, "path") << "seed " << seed;
    EXPECT_GT(choice.trials.size(), 1u);
  }
}

TEST(TechniqueChoice, does_not_depend_on_the_number_of_threads) {
  const TechniqueChoice one = choose(hidden_lamp(), 1), many = choose(hidden_lamp(), 4);
  ASSERT_EQ(one.trials.size(), many.trials.size());
  for (size_t i = 0; i < one.trials.size(); ++i)
    EXPECT_EQ(one.trials[i].cost.whole, many.trials[i].cost.whole) << one.trials[i].name;
}

TEST(TechniqueChoice, no_pilot_is_rendered_where_it_cannot_be_efficient) {
  SceneDescription few = hidden_lamp();
  few.settings.width = few.settings.height = 20;
  EXPECT_EQ(choose(few).trials.size(), 0u);
  SceneDescription dark = hidden_lamp();
  dark.lights.clear();
  EXPECT_EQ(choose(dark).trials.size(), 0u);
  SceneDescription direct = hidden_lamp();
  direct.settings.bounces.total = 0;
  EXPECT_EQ(choose(direct).trials.size(), 0u);
  SceneDescription hasty = hidden_lamp();
  hasty.settings.samples = 0;
  hasty.settings.seconds = 1e-3;
  EXPECT_EQ(choose(hasty).trials.size(), 0u);
  for (const SceneDescription& d : {few, dark, direct, hasty}) EXPECT_EQ(choose(d).settings.integrator, "path");
}

TEST(TechniqueChoice, a_stop_ends_the_pilot_immediately) {
  SceneDescription d = hidden_lamp();
  Diagnostics diagnostics;
  const CameraDescription camera = d.camera;
  const std::shared_ptr<Scene> scene = Scene::build(std::move(d), {}, diagnostics);
  const std::atomic<bool> stop{true};
  const TechniqueChoice choice = choose_technique(scene, camera, stop);
  EXPECT_EQ(choice.settings.integrator, "path");
  EXPECT_EQ(scene->settings().width, 200);
}

}  // namespace

}  // namespace ajar::test_technique_choice
