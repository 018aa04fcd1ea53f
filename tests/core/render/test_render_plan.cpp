// A render does no work that its scene does not need. The tests count the work.
#include "integrators/render_plan.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "render/session.h"
#include "renders.h"
#include "transport/media/media.h"
#include "transport_scenes.h"

namespace ajar::test_render_plan {

namespace {

using namespace fixtures;

constexpr int kSize = 16;
constexpr uint64_t kPixels = kSize * kSize;

/// Blender's default scene: a grey cube, one lamp, and a constant grey world.
SceneDescription default_cube() {
  SceneDescription d;
  GraphBuilder b;
  b.graph.surface = {b.node("ShaderNodeBsdfPrincipled",
                            {value_input("Base Color", Vec4(0.8f, 0.8f, 0.8f, 1.0f)), value_input("Roughness", 0.5f)}),
                     "BSDF"};
  add_object(d, cube(), add_material(d, b));
  d.lights.push_back(point_light(Vec3(4.08f, 1.0f, 5.9f), 1000.0f, 0.1f));
  set_world(d, Color(0.05f));
  set_camera(d, Vec3(7.36f, -6.93f, 4.96f), Vec3(0.0f), kSize);
  d.settings.samples = 2;
  d.settings.bounces = {12, 4, 4, 12, 8, 0};
  return d;
}

nlohmann::json rendered(SceneDescription d) {
  Session session;
  session.start(std::move(d));
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  return nlohmann::json::parse(session.statistics_json());
}

bool uses(const nlohmann::json& statistics, const std::string& step) {
  for (const auto& line : statistics["plan"])
    if (line["step"] == step) {
      EXPECT_NE(line["reason"], "");
      if (!line["used"]) {
        EXPECT_EQ(line["cost"], "") << step;
      }
      return line["used"];
    }
  ADD_FAILURE() << "the plan has no step '" << step << "'";
  return false;
}

int instructions(const Scene& scene) {
  int sum = scene.world_program().instruction_count();
  for (const ShaderProgram& program : scene.programs()) sum += program.instruction_count();
  return sum;
}

TEST(RenderPlan, of_the_default_cube_is_light_sampling_of_one_lamp) {
  const auto told = rendered(default_cube());
  for (const char* step : {"transparent shadows", "depth of field", "motion keys", "textures", "shader programs",
                           "caustic map", "vertex merging", "passes beyond Combined", "image sampling"})
    EXPECT_FALSE(uses(told, step)) << step;
  for (const char* step : {"light sampling", "lamp shapes", "environment"}) EXPECT_TRUE(uses(told, step)) << step;
}

TEST(RenderPlan, reports_when_there_are_too_few_samples_to_learn_the_choice_of_lights) {
  SceneDescription d = default_cube();
  d.settings.integrator = "path";
  d.settings.direct = DirectMethod::PmcHi;
  d.settings.samples = 1;
  EXPECT_FALSE(uses(rendered(d), "direct light method"));
  d.settings.samples = 64;
  EXPECT_TRUE(uses(rendered(d), "direct light method"));
}

TEST(RenderPlan, techniques_with_walks_from_lights_name_objects_that_only_some_bounces_see) {
  for (const IntegratorInfo& integrator : integrator_list()) {
    if (integrator.automatic) continue;
    SceneDescription d = default_cube();
    d.settings.integrator = integrator.name;
    d.settings.samples = 1;
    d.settings.photons = 100;
    d.objects[0].name = "Pane";
    d.objects[0].visibility = kVisibleAll & ~kVisibleGlossy;
    Session session;
    session.start(std::move(d));
    ASSERT_TRUE(session.wait(kHang)) << integrator.name;
    int said = 0;
    for (const Diagnostic& diagnostic : session.diagnostics())
      said += diagnostic.message.find("Only some kinds of bounces see 'Pane'.") != std::string::npos;
    EXPECT_EQ(said, integrator.follows_hints ? 1 : 0) << integrator.name;
  }
}

TEST(RenderPlan, integrators_that_need_more_than_rays_of_the_camera_refuse_to_bake) {
  for (const IntegratorInfo& integrator : integrator_list()) {
    if (integrator.automatic) continue;
    SceneDescription d = default_cube();
    d.settings.integrator = integrator.name;
    d.camera.kind = CameraKind::Texels;
    d.camera.texels.resize(size_t(d.settings.width) * size_t(d.settings.height));
    const Vec3 up(0, 0, 1);
    d.camera.texels[0] = {true, {Vec3(-1, -1, 1), Vec3(1, -1, 1), Vec3(0, 1, 1)}, {up, up, up}, {0.3f, 0.3f}};
    Session session;
    session.start(std::move(d));
    ASSERT_TRUE(session.wait(kHang)) << integrator.name;
    const std::string error = session.take_error();
    EXPECT_EQ(error.find("cannot bake") == std::string::npos, integrator.bakes) << integrator.name << ": " << error;
  }
}

TEST(RenderPlan, integrators_without_photon_maps_trace_no_photons) {
  // Every ray belongs to a path: it goes to the next surface, or from a surface that scatters to a light.
  SceneDescription d = default_cube();
  for (const char* integrator : {"path", "bdpt", "erpt", "pmc_pt", "metropolis"}) {
    d.settings.integrator = integrator;
    d.settings.vertex_merging = Merging::On;  // the scene has nothing to merge
    const auto told = rendered(d);
    for (const char* key : {"photon_rays", "photons", "photon_bytes"})
      EXPECT_FALSE(told.contains(key)) << integrator << " " << key;
  }
  d.settings.integrator = "path";
  d.settings.bounces.total = 0;
  const auto told = rendered(d);
  const uint64_t paths = told["paths"], rays = told["rays"];
  EXPECT_EQ(paths, 2 * kPixels);
  // One ray from the camera, one to the lamp, and one of BSDF sampling, which hits the lamp or is not continued.
  EXPECT_LE(rays, 3 * paths);
}

TEST(RenderPlan, photons_are_traced_only_where_maps_are_needed) {
  SceneDescription d = default_cube();
  d.settings.integrator = "photon_map";
  d.settings.photons = 500;
  EXPECT_GT(double(rendered(d)["photon_bytes"]), 0.0);
  d.lights.clear();
  set_world(d, Color(0.0f));
  const auto dark = rendered(d);
  EXPECT_FALSE(uses(dark, "photon map"));
  EXPECT_EQ(double(dark["photon_bytes"]), 0.0);
}

TEST(RenderPlan, emissive_meshes_are_lights_only_where_something_scatters_light) {
  SceneDescription d;
  GraphBuilder b;
  b.graph.surface = {b.node("ShaderNodeEmission", {value_input("Color", Vec4(0.5f)), value_input("Strength", 3.0f)}),
                     "Emission"};
  add_object(d, cube(true), add_material(d, b));
  set_camera(d, Vec3(0.1f, -0.5f, 0.2f), Vec3(0.3f, 0.5f, -0.1f), kSize);
  d.settings.samples = 2;
  const auto told = rendered(d);
  EXPECT_FALSE(uses(told, "light sampling"));
  EXPECT_EQ(told["scene"]["lights"], 0);
  for (const char* integrator : {"path", "bdpt", "photon_map", "auto"}) {
    d.settings.integrator = integrator;
    const std::vector<float> image = render(d, integrator, 2, 1);
    for (size_t i = 0; i < image.size(); ++i) EXPECT_NEAR(image[i], i % 4 < 3 ? 1.5f : 1.0f, 1e-5f) << integrator;
  }
  SceneDescription with_lens = d;
  with_lens.camera.aperture_radius = 0.01f;
  EXPECT_EQ(build(std::move(with_lens))->lights().size(), 12u);
  SceneDescription with_grey = d;
  add_object(with_grey, sphere(), add_diffuse(with_grey, Color(0.5f)));
  EXPECT_EQ(build(std::move(with_grey))->lights().size(), 12u);
  SceneDescription with_fog = d;
  b.graph.volume = {b.node("ShaderNodeVolumeScatter", {value_input("Density", 1.0f)}), "Volume"};
  add_object(with_fog, cube(), add_material(with_fog, b));
  EXPECT_EQ(build(std::move(with_fog))->lights().size(), 24u);
}

TEST(RenderPlan, a_table_is_built_only_for_worlds_that_vary) {
  SceneDescription d = default_cube();
  EXPECT_EQ(build(d)->statistics().environment_bytes, 0u);
  GraphBuilder b;
  const int coordinates = b.node("ShaderNodeTexCoord");
  b.graph.surface = {
      b.node("ShaderNodeBackground", {linked_input("Color", coordinates, "Generated"), value_input("Strength", 1.0f)}),
      "Background"};
  d.world.graph = b.graph;
  EXPECT_GT(build(d)->statistics().environment_bytes, 1u << 20);
}

TEST(RenderPlan, no_light_tree_is_built_without_local_lights) {
  SceneDescription d = default_cube();
  const uint64_t of_one = build(d)->statistics().light_tree_bytes;
  EXPECT_LT(of_one, 100u);
  d.lights.clear();
  const auto lit_by_the_world = build(d);
  EXPECT_EQ(lit_by_the_world->statistics().light_tree_bytes, 0u);
  EXPECT_FALSE(lit_by_the_world->lights().can_choose());
  LightDescription sun;
  sun.name = "Sun";
  sun.kind = LightKind::Sun;
  sun.energy = 1.0f;
  d.lights = {sun, sun};
  EXPECT_EQ(build(d)->statistics().light_tree_bytes, 0u) << "suns are chosen without a tree";
  d.lights.assign(50, point_light(Vec3(0, 0, 3), 10.0f));
  EXPECT_GT(build(d)->statistics().light_tree_bytes, 50 * of_one);
}

TEST(RenderPlan, tangents_are_computed_only_where_they_are_used) {
  const auto with = [](float anisotropic) {
    SceneDescription d = default_cube();
    GraphBuilder b;
    const int tangent = b.node("ShaderNodeTangent", {}, {text_property("direction_type", "UV_MAP")});
    b.graph.surface = {
        b.node("ShaderNodeBsdfPrincipled", {value_input("Metallic", 1.0f), value_input("Anisotropic", anisotropic),
                                            linked_input("Tangent", tangent, "Tangent")}),
        "BSDF"};
    d.objects[0].materials = {add_material(d, b)};
    return instructions(*build(d));
  };
  EXPECT_EQ(with(0.0f), 0);
  EXPECT_GT(with(0.5f), 0);
}

TEST(RenderPlan, objects_at_rest_have_no_motion_keys) {
  SceneDescription d = default_cube();
  const auto still = build(d);
  EXPECT_FALSE(still->moves());
  EXPECT_EQ(still->statistics().moving_instances, 0u);
  EXPECT_EQ(still->instances()[0].motion, nullptr);
  EXPECT_TRUE(still->meshes()[0].baked);
  d.motion_keys = {d.instances[0].world_from_object, d.instances[0].world_from_object};
  d.motion_keys[1][3] += 1.0f;
  d.instances[0].first_motion_key = 0;
  d.instances[0].motion_key_count = 2;
  EXPECT_NE(build(d)->instances()[0].motion, nullptr);
}

TEST(RenderPlan, unused_images_are_not_decoded) {
  SceneDescription d = default_cube();
  ImageDescription image;
  image.name = "Big";
  image.width = image.height = 64;
  image.pixels.assign(64 * 64 * 4, 0.5f);
  d.images.push_back(image);
  GraphBuilder b;
  const int texture = b.node("ShaderNodeTexImage", {}, {number_property("image", {0.0f})});
  b.graph.surface = {b.node("ShaderNodeBsdfDiffuse", {linked_input("Color", texture, "Color")}), "BSDF"};
  const int material = add_material(d, b);
  const auto unseen = build(d);
  EXPECT_EQ(unseen->textures().decoded_count(), 0);
  EXPECT_EQ(unseen->statistics().texture_bytes, 0u);
  d.objects[0].materials = {material};
  EXPECT_EQ(build(d)->textures().decoded_count(), 1);
}

TEST(RenderPlan, the_film_stores_only_the_requested_passes) {
  SceneDescription d = default_cube();
  const uint64_t plain = rendered(d)["film_bytes"];
  EXPECT_EQ(
      plain,
      kPixels * (72 + 2 * 12));  // the sums, and the images after one and two samples, from which errors are estimated
  d.settings.passes = {"Combined", "Normal"};
  EXPECT_EQ(uint64_t(rendered(d)["film_bytes"]), plain + kPixels * 184);
}

TEST(RenderPlan, constant_materials_run_no_instructions_at_a_hit) {
  SceneDescription d = default_cube();
  EXPECT_EQ(instructions(*build(d)), 0);
  GraphBuilder b;  // arithmetic of constants is folded
  const int sum = b.node("ShaderNodeMath", {value_input("Value", 0.2f), value_input("Value_001", 0.3f)},
                         {text_property("operation", "ADD")});
  b.graph.surface = {b.node("ShaderNodeBsdfPrincipled", {linked_input("Roughness", sum, "Value")}), "BSDF"};
  d.objects[0].materials = {add_material(d, b)};
  EXPECT_EQ(instructions(*build(d)), 0);
  GraphBuilder textured;
  const int noise = textured.node("ShaderNodeTexNoise");
  textured.graph.surface = {textured.node("ShaderNodeBsdfPrincipled", {linked_input("Base Color", noise, "Color")}),
                            "BSDF"};
  d.objects[0].materials = {add_material(d, textured)};
  EXPECT_GT(instructions(*build(d)), 0);
  EXPECT_TRUE(uses(rendered(d), "shader programs"));
}

TEST(RenderPlan, scenes_without_media_look_up_no_medium) {
  SceneDescription d = default_cube();
  EXPECT_FALSE(rendered(d).contains("media_lookups"));
  GraphBuilder b;
  const int noise = b.node("ShaderNodeTexNoise");
  b.graph.volume = {b.node("ShaderNodeVolumeScatter", {linked_input("Density", noise, "Fac")}), "Volume"};
  d.objects[0].materials = {add_material(d, b)};
  EXPECT_GT(double(rendered(d)["media_lookups"]), 0.0);
}

}  // namespace

}  // namespace ajar::test_render_plan
