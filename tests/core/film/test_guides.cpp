// The guides of a denoiser show what is behind glass and in mirrors, and volumes.
#include <gtest/gtest.h>

#include "feature_scenes.h"
#include "film/film.h"
#include "integrators/integrator.h"
#include "transport_scenes.h"

namespace ajar::test_guides {

namespace {

using namespace fixtures;

class GuidesOf : public testing::TestWithParam<const char*> {};

TEST_P(GuidesOf, are_those_of_the_surface_in_a_mirror) {
  // The camera looks at a mirror. A red wall is behind the camera.
  SceneDescription d = grey_room();
  d.objects.clear();
  d.instances.clear();
  set_camera(d, Vec3(0, -0.5f, 0), Vec3(0, 1, 0), 8, 0.2f);
  const Mat4 facing(Vec4(1, 0, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, -1, 0, 0), Vec4(0, 0, 0, 1));
  Mat4 front = facing, back = facing;
  front[3] = Vec4(0, 1, 0, 1);
  back[3] = Vec4(0, -2, 0, 1);
  add_object(d, plane(3.0f), add_glossy(d, 0.0f, Color(1.0f)), front);
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.7f, 0.2f, 0.1f)), back);
  d.lights.push_back(point_light(Vec3(0.5f, -1, 0.5f), 5.0f, 0.1f));
  const auto scene = build(d);
  const std::atomic<bool> stop{false};
  const auto integrator = make_integrator(GetParam());
  integrator->prepare(scene, 1);
  Film film(0, 0, d.settings.width, d.settings.height, {"Combined", "Albedo", "Denoising Albedo", "Denoising Normal"});
  integrator->run_iteration(film, 2, stop);
  const auto guide = film.resolve("Denoising Albedo", 1.0f), normal = film.resolve("Denoising Normal", 1.0f),
             first = film.resolve("Albedo", 1.0f);
  for (size_t i = 0; i < guide.size(); i += 3) {
    EXPECT_NEAR(guide[i], 0.7f, 0.02f);
    EXPECT_NEAR(guide[i + 1], 0.2f, 0.02f);
    EXPECT_NEAR(normal[i + 1], 1.0f, 1e-3f);
    EXPECT_GT(first[i + 1], 0.9f);
  }
}

// A slab that absorbs light before one that scatters it, each 1 m thick, before a wall. Where light scatters, the albedo
// is 1. Fog of the same density is sampled in another way than that whose density is computed.
TEST(Guides, normals_are_those_of_the_closures) {
  SceneDescription d;
  GraphBuilder g;
  const int tilt = g.node("ShaderNodeCombineXYZ", {value_input("X", 0.5f), value_input("Z", 1.0f)});
  g.graph.surface = {g.node("ShaderNodeBsdfDiffuse", {linked_input("Normal", tilt, "Vector")}), "BSDF"};
  add_object(d, plane(3.0f), add_material(d, g));
  set_world(d, Color(1.0f));
  set_camera(d, Vec3(0, -0.001f, 2), Vec3(0), 4, 0.1f);
  const std::atomic<bool> stop{false};
  const auto integrator = make_integrator("path");
  integrator->prepare(build(d), 1);
  Film film(0, 0, 4, 4, {"Combined", "Normal", "Denoising Normal"});
  integrator->run_iteration(film, 4, stop);
  const Vec3 expected = glm::normalize(Vec3(0.5f, 0.0f, 1.0f));
  for (const char* pass : {"Normal", "Denoising Normal"}) {
    const auto normal = film.resolve(pass, 1.0f);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(normal[c], expected[int(c)], 1e-4f) << pass;
  }
}

TEST(Guides, are_those_of_fog_and_of_what_is_seen_through_it) {
  for (const bool varies : {false, true}) {
    SceneDescription d = grey_room();
    d.objects.clear();
    d.instances.clear();
    set_camera(d, Vec3(0, -3, 0), Vec3(0, 1, 0), 8, 0.05f);
    add_object(d, plane(3.0f), add_diffuse(d, Color(0.7f, 0.2f, 0.1f)), shining(Vec3(0, 2, 0), Vec3(0, -1, 0)));
    const int scatters = add_medium(d, "ShaderNodeVolumeScatter", Color(1.0f), Vec2(0.8f, varies ? 0.8001f : 0.8f)),
              absorbs = add_medium(d, "ShaderNodeVolumeAbsorption", Color(0.8f, 0.5f, 0.2f), Vec2(1.0f));
    add_object(d, cube(), scatters, moved(Vec3(0.0f, 0.5f, 0.0f), 0.5f));
    add_object(d, cube(), absorbs, moved(Vec3(0.0f, -1.0f, 0.0f), 0.5f));
    d.lights.push_back(point_light(Vec3(0.5f, -2, 0.5f), 5.0f, 0.1f));
    const auto scene = build(d);
    const std::atomic<bool> stop{false};
    const auto integrator = make_integrator("path");
    integrator->prepare(scene, 1);
    Film film(0, 0, d.settings.width, d.settings.height, {"Combined", "Denoising Albedo", "Denoising Normal"});
    integrator->run_iteration(film, 512, stop);
    const auto guide = film.resolve("Denoising Albedo", 1.0f), normal = film.resolve("Denoising Normal", 1.0f);
    const double wall[] = {0.7, 0.2, 0.1}, absorbed[] = {0.2, 0.5, 0.8};
    const double passes = std::exp(-0.8);
    for (size_t c = 0; c < 3; ++c) {
      double mean = 0.0;
      for (size_t i = c; i < guide.size(); i += 3) mean += 3.0 * double(guide[i]) / double(guide.size());
      EXPECT_NEAR(mean, std::exp(-absorbed[c]) * (1.0 - passes + passes * wall[c]), 0.01) << varies << " " << c;
    }
    for (size_t i = 0; i < normal.size(); i += 3) EXPECT_NEAR(normal[i + 1], -1.0f, 0.01f);
  }
}

INSTANTIATE_TEST_SUITE_P(All, GuidesOf,
                         testing::Values("path", "bdpt", "erpt", "metropolis", "photon_map", "irradiance_cache"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace

}  // namespace ajar::test_guides
