#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "render/session.h"
#include "scene_fixtures.h"

namespace ajar::test_session {

using namespace fixtures;

namespace {

/// A shared sphere above a shared floor, below a lamp.
struct Stage {
  std::shared_ptr<const MeshDescription> floor = std::make_shared<MeshDescription>(plane(3.0f));
  std::shared_ptr<const MeshDescription> ball = std::make_shared<MeshDescription>(sphere(12));

  SceneDescription scene(float height, Vec3 eye = Vec3(0, -6, 4)) const {
    SceneDescription d;
    const int grey = add_diffuse(d, Color(0.5f));
    add(d, floor, grey, 0.0f);
    add(d, ball, grey, height);
    d.lights.push_back(point_light(Vec3(1, -1, 4), 300.0f, 0.2f));
    set_camera(d, eye, Vec3(0), 24);
    d.settings.samples = 4;
    d.settings.threads = 2;
    return d;
  }

  static void add(SceneDescription& d, const std::shared_ptr<const MeshDescription>& mesh, int material, float height) {
    MeshDescription shared;
    shared.shared = mesh;
    add_object(d, shared, material, Mat4(Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, 0, height, 1)));
  }
};

/// A diffuse material whose colour is the window coordinate.
int add_window_coloured(SceneDescription& d) {
  MaterialDescription material;
  material.name = "Window";
  Node coordinates;
  coordinates.type = "ShaderNodeTexCoord";
  coordinates.name = "Texture Coordinate";
  material.graph.nodes.push_back(coordinates);
  material.graph.nodes.push_back(closure_node("ShaderNodeBsdfDiffuse", Color(1.0f)));
  material.graph.nodes[1].inputs[0].link = {0, "Window"};
  material.graph.surface = {1, "BSDF"};
  d.materials.push_back(material);
  return int(d.materials.size()) - 1;
}

std::vector<float> picture(Session& session, uint64_t render) {
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  EXPECT_EQ(session.progress().render, render);
  EXPECT_EQ(session.progress().phase, Progress::Phase::Done);
  return session.snapshot("Combined");
}

std::vector<float> fresh_image(SceneDescription d) {
  Session session;
  const uint64_t render = session.update(std::move(d));
  return picture(session, render);
}

std::shared_ptr<Scene> build_again(SceneDescription d, std::shared_ptr<Scene> previous) {
  Scene::Options options;
  options.bake_single_instances = false;
  Diagnostics ignored;
  return Scene::build(std::move(d), options, ignored, std::move(previous));
}

}  // namespace

TEST(Session, a_changed_view_gives_the_image_of_a_new_scene) {
  const Stage stage;
  SceneDescription here = stage.scene(1.0f), there = stage.scene(1.0f, Vec3(4, -4, 3));
  for (SceneDescription* d : {&here, &there}) {
    add_window_coloured(*d);
    d->objects[0].materials = {1};
  }
  there.settings.width = 40;
  const auto expected = fresh_image(there);
  Session session;
  const auto first = picture(session, session.update(here));
  EXPECT_EQ(first, fresh_image(here));
  const auto moved = picture(session, session.change_view(there.camera, there.settings));
  EXPECT_EQ(moved.size(), size_t(40 * 24 * 4));
  EXPECT_EQ(moved, expected);
  EXPECT_EQ(picture(session, session.change_view(here.camera, here.settings)), first);
}

TEST(Session, a_pass_that_is_read_is_there_from_the_first_iteration_of_another_view) {
  SceneDescription d = Stage().scene(1.0f);
  d.settings.samples = 1 << 24;  // no end
  d.settings.passes = {"Combined", "Normal"};
  Session session;
  uint64_t render = session.update(d);
  const auto wait_for_image = [&] {
    while (session.progress().render != render || session.progress().iteration == 0) session.wait(0.001);
  };
  wait_for_image();
  while (session.snapshot("Normal").empty()) session.wait(0.001);
  for (int i = 1; i < 20; ++i) {
    d.settings.width = 40 + i;
    render = session.change_view(d.camera, d.settings);
    wait_for_image();
    EXPECT_EQ(session.snapshot("Normal").size(), size_t(d.settings.width * d.settings.height * 3));
  }
}

TEST(Session, an_edited_scene_gives_the_image_of_a_new_scene) {
  const Stage stage;
  Session session;
  std::vector<float> before;
  for (const float height : {1.0f, 0.5f, 0.0f, 2.0f}) {
    const auto now = picture(session, session.update(stage.scene(height)));
    EXPECT_NE(now, before);
    EXPECT_EQ(now, fresh_image(stage.scene(height)));
    before = now;
  }
}

TEST(Session, random_edits_give_the_image_of_a_new_scene) {
  const Stage stage;
  const auto other = std::make_shared<MeshDescription>(cube());
  Pcg32 dice(7);
  SceneDescription d = stage.scene(1.0f);
  set_checker_world(d, Color(0.5f), Color(0.1f), 3.0f);
  for (int i = 0; i < 6; ++i) Stage::add(d, i % 2 ? stage.ball : other, 0, 0.5f * float(i));
  Session session;
  for (int edit = 0; edit < 40; ++edit) {
    InstanceDescription& instance = d.instances[dice.next() % d.instances.size()];
    switch (dice.next() % 7) {
      case 0: instance.world_from_object[3] = 4.0f * dice.next_float() - 2.0f; break;
      case 1:
        instance.world_from_object[10] = dice.next_float() < 0.3f ? 0.0f : dice.next_float();
        break;  // flat instances are baked
      case 2: instance.object = int(dice.next() % d.objects.size()); break;
      case 3:
        d.objects[dice.next() % d.objects.size()].visibility = dice.next_float() < 0.5f ? kVisibleAll : kVisibleShadow;
        break;
      case 4: d.lights[0].energy = 500.0f * dice.next_float(); break;
      case 5: set_checker_world(d, Color(0.5f), Color(dice.next_float()), 3.0f); break;
      case 6:
        if (d.instances.size() > 5)
          d.instances.pop_back();
        else
          d.instances.push_back(InstanceDescription(d.instances.back()));
    }
    const uint64_t render = session.update(d);
    if (edit % 4 == 3) {
      EXPECT_EQ(picture(session, render), fresh_image(d)) << edit;
    } else if (edit % 4 == 1)
      session.wait(0.01);
    else
      session.wait(kHang);
  }
}

TEST(Scene, an_edit_builds_only_what_it_changed) {
  const Stage stage;
  SceneDescription d = stage.scene(1.0f);
  set_checker_world(d, Color(0.5f), Color(0.1f), 3.0f);
  const int other = add_diffuse(d, Color(0.2f));
  for (int i = 0; i < 8; ++i)
    Stage::add(d, std::make_shared<MeshDescription>(sphere(4 + i)), i == 3 ? other : 0, 0.5f * float(i));
  auto scene = build_again(d, nullptr);
  const auto edited = [&](uint64_t placed, bool kept_environment, uint64_t compiled) {
    scene = build_again(d, std::move(scene));
    const BuildStatistics& built = scene->statistics();
    EXPECT_EQ(built.placed_instances, placed);
    EXPECT_EQ(built.kept_environment, kept_environment);
    EXPECT_EQ(built.compiled_programs, compiled);
    EXPECT_EQ(built.compiled_programs + built.kept_programs, 2u);
    EXPECT_GT(scene->lights().size(), 1u);
  };
  EXPECT_EQ(scene->statistics().placed_instances, 10u);
  EXPECT_EQ(scene->statistics().compiled_programs, 2u);
  EXPECT_FALSE(scene->statistics().kept_environment);
  edited(0, true, 0);
  d.instances[3].world_from_object[7] += 1.0f;
  edited(1, true, 0);
  d.lights[0].energy *= 2.0f;
  edited(0, true, 0);
  d.materials[0].graph.nodes[0].inputs[0].value = Vec4(0.1f);
  edited(0, true, 1);
  d.materials[1].pass_index = 3;
  edited(0, true, 1);
  d.settings.reflective_caustics = false;
  edited(0, true, 2);
  d.objects[2].visibility = kVisibleCamera;
  edited(1, true, 0);
  set_checker_world(d, Color(0.5f), Color(0.2f), 3.0f);
  edited(0, false, 0);
  Stage::add(d, std::make_shared<MeshDescription>(plane(9.0f)), 0, -1.0f);
  edited(11, true, 0);  // the number of instances has changed
  for (InstanceDescription& instance : d.instances) instance.world_from_object[3] += 0.1f;
  edited(11, true, 0);  // more than half have moved
  d.instances[0].world_from_object[10] = 0.0f;
  edited(11, true, 0);  // flat, and therefore baked
  d.instances[0].world_from_object[10] = 1.0f;
  edited(11, true, 0);
  // A world and a material that use window coordinates depend on the camera.
  Node coordinates;
  coordinates.type = coordinates.name = "ShaderNodeTexCoord";
  d.world.graph.nodes.push_back(coordinates);
  d.world.graph.nodes[0].inputs.push_back({"Vector", {2, "Window"}, Vec4(0.0f)});
  edited(0, false, 0);
  d.materials[0].graph.nodes.push_back(coordinates);
  d.materials[0].graph.nodes[0].inputs[0].link = {1, "Window"};
  edited(0, false, 1);
  edited(0, false, 1);
}

TEST(Scene, diagnostics_of_a_kept_material_are_repeated) {
  SceneDescription d = Stage().scene(1.0f);
  Node strange;
  strange.type = strange.name = "ShaderNodeOfTomorrow";
  d.materials[0].graph.nodes.push_back(strange);
  d.materials[0].graph.nodes[0].inputs[0].link = {1, "Color"};
  Scene::Options options;
  options.bake_single_instances = false;
  Diagnostics first, second;
  auto scene = Scene::build(d, options, first, nullptr);
  scene = Scene::build(d, options, second, std::move(scene));
  EXPECT_EQ(scene->statistics().kept_programs, 1u);
  ASSERT_EQ(first.size(), 1u);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_EQ(first[0].message, second[0].message);
}

TEST(Session, the_latest_of_many_requests_is_rendered) {
  const Stage stage;
  Session session;
  session.update(stage.scene(1.0f));
  uint64_t last = 0;
  for (int i = 0; i < 60; ++i) {
    SceneDescription d = stage.scene(0.1f * float(i % 7), Vec3(0.1f * float(i), -6, 4));
    last = i % 3 == 0 ? session.update(d) : session.change_view(d.camera, d.settings);
    if (i % 10 == 0) session.wait(0.01);
    if (i == 30) session.cancel();
  }
  EXPECT_EQ(picture(session, last), fresh_image(stage.scene(0.1f * float(57 % 7), Vec3(5.9f, -6, 4))));
}

TEST(Session, an_invalid_view_is_refused_and_the_scene_is_kept) {
  const Stage stage;
  SceneDescription d = stage.scene(1.0f);
  Session session;
  const auto first = picture(session, session.update(d));
  CameraDescription blind = d.camera;
  blind.clip_end = blind.clip_start;
  session.change_view(blind, d.settings);
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.progress().phase, Progress::Phase::Failed);
  EXPECT_NE(session.take_error().find("Camera"), std::string::npos);
  EXPECT_EQ(picture(session, session.change_view(d.camera, d.settings)), first);
}

/// Statistics during a render are those after an iteration, when no thread writes, so that every pixel has the same
/// number of samples.
TEST(Session, statistics_during_a_render_are_those_after_an_iteration) {
  SceneDescription d = Stage().scene(1.0f);
  d.settings.width = d.settings.height = 160;
  d.settings.samples = 1 << 24;  // no end; the test cancels the render
  Session session;
  session.start(d);
  for (int answered = 0; answered < 50;) {
    const auto told = nlohmann::json::parse(session.statistics_json());
    if (!told.contains("samples_per_pixel")) continue;
    ++answered;
    ASSERT_EQ(told["samples_per_pixel"]["min"], told["samples_per_pixel"]["max"]) << "answer " << answered;
  }
  session.cancel();
  EXPECT_TRUE(session.wait(kHang));
}

/// An integrator can count samples differently: ERPT takes a quarter of them from the eye. The remaining time must
/// still be correct.
TEST(Session, reports_the_remaining_time) {
  for (const char* integrator : {"path", "erpt"}) {
    SceneDescription d = Stage().scene(1.0f);
    d.settings.integrator = integrator;
    d.settings.samples = 64;
    Session session;
    session.start(d);
    EXPECT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.progress().remaining_seconds, 0.0) << integrator;
    d.settings.samples = 1 << 24;
    Session longer;
    longer.start(d);
    while (longer.progress().samples < 4.0) longer.wait(0.01);
    const Progress progress = longer.progress();
    longer.cancel();
    EXPECT_TRUE(longer.wait(kHang));
    // Nearly all of the render remains: about the number of samples times the time for one sample, which depends on the
    // integrator.
    EXPECT_GT(progress.remaining_seconds, progress.render_seconds * 1e4) << integrator;
    EXPECT_LT(progress.fraction, 0.06) << integrator;
  }
}

TEST(Session, a_pause_stops_the_render_and_changes_no_pixel) {
  SceneDescription d = Stage().scene(1.0f);
  d.settings.samples = 16;
  const auto expected = fresh_image(d);
  Session session;
  session.pause(true);
  session.start(d);
  while (session.progress().iteration == 0)
    session.wait(0.01);  // the first iteration is rendered, so that there is an image
  EXPECT_FALSE(session.wait(0.1)) << "the paused render continued";
  EXPECT_TRUE(session.is_paused());
  EXPECT_EQ(session.progress().samples, 1.0);
  session.pause(false);
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.snapshot("Combined"), expected);
}

TEST(Session, a_paused_render_can_be_cancelled) {
  Session session;
  session.pause(true);
  session.start(Stage().scene(1.0f));
  session.cancel();
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.progress().phase, Progress::Phase::Cancelled);
}

TEST(Scene, unchanged_meshes_and_images_are_kept) {
  const Stage stage;
  const auto textured = [&](float height, float shade) {
    SceneDescription d = stage.scene(height);
    ImageDescription image;
    image.name = "Card";
    image.width = image.height = 2;
    image.pixels.assign(16, shade);
    d.images.push_back(image);
    Node texture;
    texture.type = "ShaderNodeTexImage";
    texture.name = "Image Texture";
    texture.properties.push_back({"image", "", {0.0f}});
    d.materials[0].graph.nodes.push_back(texture);
    d.materials[0].graph.nodes[0].inputs[0].link = {1, "Color"};
    return d;
  };
  auto scene = build_again(textured(1.0f, 0.25f), nullptr);
  EXPECT_EQ(scene->statistics().kept_meshes, 0u);
  EXPECT_EQ(scene->statistics().kept_textures, 0u);
  scene = build_again(textured(2.0f, 0.25f), std::move(scene));
  EXPECT_EQ(scene->statistics().kept_meshes, 2u);
  EXPECT_EQ(scene->statistics().kept_textures, 1u);
  EXPECT_EQ(scene->statistics().kept_programs, 1u);
  EXPECT_EQ(scene->textures().decoded_count(), 1);
  // A different mesh and different pixels are not kept.
  Stage other = stage;
  other.ball = std::make_shared<MeshDescription>(sphere(10));
  SceneDescription d = textured(2.0f, 0.5f);
  d.meshes[1].shared = other.ball;
  scene = build_again(d, std::move(scene));
  EXPECT_EQ(scene->statistics().kept_meshes, 1u);
  EXPECT_EQ(scene->statistics().kept_textures, 0u);
  EXPECT_EQ(scene->statistics().kept_programs, 0u);
  EXPECT_EQ(scene->meshes()[1].source, other.ball);
}

TEST(Scene, a_shared_mesh_is_correct_after_it_was_flattened_once) {
  const Stage stage;
  SceneDescription flat = stage.scene(1.0f);
  flat.instances[1].world_from_object = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1};
  auto scene = build_again(flat, build_again(stage.scene(1.0f), nullptr));
  Ray ray;
  ray.origin = Vec3(0.1f, 0.1f, 10.0f);
  ray.direction = Vec3(0, 0, -1);
  EXPECT_NEAR(scene->intersect(ray, kRayCamera).t, 9.0f, 1e-4f);
  scene = build_again(stage.scene(1.0f), std::move(scene));
  EXPECT_EQ(scene->statistics().kept_meshes, 2u);
  EXPECT_NEAR(scene->intersect(ray, kRayCamera).t, 8.0f, 0.05f);
}

}  // namespace ajar::test_session
