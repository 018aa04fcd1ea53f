// `auto` chooses what pays, says why, leaves the scene as it was, and chooses alike for a seed.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "math/warps.h"
#include "render/technique_choice.h"
#include "transport_scenes.h"

namespace ajar::test_technique_choice {

namespace {

using namespace fixtures;

const std::atomic<bool> kGoOn{false};

/// A floor under an open lamp.
SceneDescription open_scene() {
  SceneDescription d;
  add_object(d, plane(4.0f), add_diffuse(d, Color(0.5f)));
  d.lights.push_back(area_lamp(Vec3(0, 0, 2), Vec3(0, 0, -1), 1.0f, 50.0f));
  set_camera(d, Vec3(0.1f, -3.0f, 3.0f), Vec3(0.0f), 200);
  return d;
}
/// A room lit by a lamp behind a screen, which faces away into a corner.
SceneDescription hidden_lamp() {
  SceneDescription d = grey_room(200);
  add_object(d, cube(true), 0, moved(Vec3(0.7f, 0.7f, 0.7f), 0.28f));
  d.instances.back().world_from_object[10] = 0.2799f;  // a box about the lamp ...
  d.lights.push_back(area_lamp(Vec3(0.7f, 0.7f, 0.75f), Vec3(0, 0, 1), 0.05f, 50.0f));
  MeshDescription& box = d.meshes[size_t(d.objects.back().mesh)];
  box.triangles.resize(box.triangles.size() - 1);  // ... with one triangle open
  return d;
}

/// A bulb in a glass ball: neither light sampling nor, but by a rare probability, a path from the eye finds it.
SceneDescription bulb_in_glass() {
  SceneDescription d = grey_room(200);
  const Vec3 at(0.5f, 0.3f, 0.3f);
  add_object(d, sphere(), add_glass(d, 0.0f), moved(at, 0.2f));
  add_object(d, sphere(), add_diffuse(d, Color(0.0f), Color(5e5f)), moved(at, 0.003f));
  return d;
}

TechniqueChoice choose(SceneDescription d, int threads = 1) {
  d.settings.samples = 256;
  d.settings.integrator = kAutomatic;
  Diagnostics diagnostics;
  const CameraDescription camera = d.camera;
  TechniqueChoice choice;
  tbb::task_arena arena(threads);
  arena.execute([&] {
    const std::shared_ptr<Scene> scene = Scene::build(std::move(d), {}, diagnostics);
    const RenderSettings before = scene->settings();
    choice = choose_technique(scene, camera, kGoOn);
    EXPECT_TRUE(scene->settings() == before) << "the scene is looked at as before";
    EXPECT_EQ(scene.use_count(), 1) << "nobody keeps it";
  });
  return choice;
}

TEST(TechniqueChoice, open_light_is_left_to_path_tracing) {
  const TechniqueChoice choice = choose(open_scene());
  EXPECT_EQ(choice.settings.integrator, "path");
  EXPECT_EQ(choice.trials.size(), 1u) << "the others are not even tried";
  EXPECT_EQ(choice.settings.width, 200);
}

TEST(TechniqueChoice, brighter_light_shown_darker_is_the_same) {
  SceneDescription bright = hidden_lamp();
  constexpr float kTimes = 4096.0f;
  bright.lights[0].energy *= kTimes;
  bright.settings.exposure /= kTimes;
  const TechniqueChoice plain = choose(hidden_lamp()), scaled = choose(std::move(bright));
  EXPECT_EQ(plain.settings.integrator, scaled.settings.integrator);
  ASSERT_EQ(plain.trials.size(), scaled.trials.size());
  EXPECT_NEAR(plain.trials[0].relmse, scaled.trials[0].relmse, 0.01 * plain.trials[0].relmse);
}

TEST(TechniqueChoice, hidden_light_is_not) {
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

TEST(TechniqueChoice, darkness_is_not_taken_for_quiet) {
  for (uint32_t seed = 1; seed <= 2; ++seed) {
    SceneDescription d = bulb_in_glass();
    d.settings.seed = seed;
    d.settings.vertex_merging = "on";
    const TechniqueChoice choice = choose(std::move(d));
    EXPECT_NE(choice.settings.integrator, "path") << "seed " << seed;
    EXPECT_GT(choice.trials.size(), 1u);
  }
}

TEST(TechniqueChoice, a_seed_chooses_alike_for_any_number_of_threads) {
  const TechniqueChoice one = choose(hidden_lamp(), 1), many = choose(hidden_lamp(), 4);
  ASSERT_EQ(one.trials.size(), many.trials.size());
  for (size_t i = 0; i < one.trials.size(); ++i)
    EXPECT_EQ(one.trials[i].cost.whole, many.trials[i].cost.whole) << one.trials[i].name;
}

TEST(TechniqueChoice, no_pilot_where_it_cannot_pay) {
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

TEST(TechniqueChoice, a_stop_ends_the_pilot_at_once) {
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
