#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "render/session.h"
#include "scene_fixtures.h"

using namespace ajar;
using namespace ajar::fixtures;

namespace {

/// A shared sphere above a shared floor under a lamp.
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

/// Reflects by where the frame shows it: red from left to right.
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
  EXPECT_TRUE(session.wait(60.0));
  EXPECT_EQ(session.take_error(), "");
  EXPECT_EQ(session.progress().render, render);
  EXPECT_EQ(session.progress().phase, Progress::Phase::Done);
  return session.snapshot("Combined");
}

std::vector<float> fresh_picture(SceneDescription d) {
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

TEST(Session, path_tracing_renders_panoramas_that_paths_cannot_be_joined_to_and_says_so) {
  SceneDescription d = Stage().scene(1.0f);
  d.camera.kind = CameraKind::Panorama;
  d.camera.screen_window = Vec4(0, 1, 0, 1);
  const auto render_with = [&](const char* integrator, bool& said) {
    d.settings.integrator = integrator;
    Session session;
    session.start(d);
    EXPECT_TRUE(session.wait(60.0));
    EXPECT_EQ(session.take_error(), "");
    said = false;
    for (const Diagnostic& diagnostic : session.diagnostics()) said |= diagnostic.message.find("Path Tracing renders it") != std::string::npos;
    return session.snapshot("Combined");
  };
  bool said;
  const auto path = render_with("path", said);
  EXPECT_FALSE(said);
  for (const char* name : {"bdpt", "metropolis", "erpt", "pmc_pt", "mps"}) {
    EXPECT_EQ(render_with(name, said), path) << name;
    EXPECT_TRUE(said) << name;
  }
  render_with("photon_map", said);
  EXPECT_FALSE(said);
  d.camera.panorama.kind = PanoramaKind::MirrorBall;
  EXPECT_NE(render_with("bdpt", said), path);
  EXPECT_FALSE(said);
}

TEST(Session, another_view_of_a_scene_is_the_picture_of_a_scene_built_for_it) {
  const Stage stage;
  SceneDescription here = stage.scene(1.0f), there = stage.scene(1.0f, Vec3(4, -4, 3));
  for (SceneDescription* d : {&here, &there}) {
    add_window_coloured(*d);
    d->objects[0].materials = {1};
  }
  there.settings.width = 40;
  const auto expected = fresh_picture(there);
  Session session;
  const auto first = picture(session, session.update(here));
  EXPECT_EQ(first, fresh_picture(here));
  const auto moved = picture(session, session.change_view(there.camera, there.settings));
  EXPECT_EQ(moved.size(), size_t(40 * 24 * 4));
  EXPECT_EQ(moved, expected);
  EXPECT_EQ(picture(session, session.change_view(here.camera, here.settings)), first);
}

TEST(Session, an_edited_scene_is_the_picture_of_one_built_anew) {
  const Stage stage;
  Session session;
  std::vector<float> before;
  for (const float height : {1.0f, 0.5f, 0.0f, 2.0f}) {
    const auto now = picture(session, session.update(stage.scene(height)));
    EXPECT_NE(now, before);
    EXPECT_EQ(now, fresh_picture(stage.scene(height)));
    before = now;
  }
}

TEST(Session, the_latest_of_many_requests_is_what_renders) {
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
  EXPECT_EQ(picture(session, last), fresh_picture(stage.scene(0.1f * float(57 % 7), Vec3(5.9f, -6, 4))));
}

TEST(Session, a_view_without_a_picture_is_refused_and_the_scene_stays) {
  const Stage stage;
  SceneDescription d = stage.scene(1.0f);
  Session session;
  const auto first = picture(session, session.update(d));
  CameraDescription blind = d.camera;
  blind.clip_end = blind.clip_start;
  session.change_view(blind, d.settings);
  EXPECT_TRUE(session.wait(10.0));
  EXPECT_EQ(session.progress().phase, Progress::Phase::Failed);
  EXPECT_NE(session.take_error().find("Camera"), std::string::npos);
  EXPECT_EQ(picture(session, session.change_view(d.camera, d.settings)), first);
}

/// What is told while it renders is counted where no thread writes: every pixel then has the same number of samples.
TEST(Session, statistics_asked_for_while_it_renders_are_those_of_an_iteration_boundary) {
  SceneDescription d = Stage().scene(1.0f);
  d.settings.width = d.settings.height = 160;
  d.settings.samples = 8;
  Session session;
  session.start(d);
  int asked = 0;
  for (bool done = false; !done; ++asked) {
    done = session.wait(0.0);
    const auto told = nlohmann::json::parse(session.statistics_json());
    if (!told.contains("samples_per_pixel")) continue;
    ASSERT_EQ(told["samples_per_pixel"]["min"], told["samples_per_pixel"]["max"]) << "question " << asked;
    EXPECT_TRUE(!done || told["samples_per_pixel"]["mean"] == 8.0);
  }
  EXPECT_GT(asked, 10);
}

TEST(Scene, meshes_and_images_that_come_again_are_kept) {
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
  EXPECT_EQ(scene->textures().decoded_count(), 1);
  // Another mesh and other pixels are not what was there before.
  Stage other = stage;
  other.ball = std::make_shared<MeshDescription>(sphere(10));
  SceneDescription d = textured(2.0f, 0.5f);
  d.meshes[1].shared = other.ball;
  scene = build_again(d, std::move(scene));
  EXPECT_EQ(scene->statistics().kept_meshes, 1u);
  EXPECT_EQ(scene->statistics().kept_textures, 0u);
  EXPECT_EQ(scene->meshes()[1].source, other.ball);
}

TEST(Scene, a_shared_mesh_flattened_once_is_whole_again_afterwards) {
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
