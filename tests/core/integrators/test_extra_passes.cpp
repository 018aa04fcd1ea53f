// Cryptomatte, AOVs, light groups, ambient occlusion and motion vectors in whole renders.
#include <bit>
#include <chrono>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "feature_scenes.h"
#include "gate.h"
#include "integrators/integrator.h"
#include "math/name_hash.h"
#include "render/session.h"
#include "statistical.h"
#include "transport_scenes.h"

namespace ajar::test_extra_passes_of_renders {

using namespace fixtures;

namespace {

constexpr int kSize = 16;

/// A ball behind a half transparent sheet on a floor, hair, and a lamp.
SceneDescription layers() {
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.6f, 0.5f, 0.4f)), moved(Vec3(0, 0, -0.5f)));
  add_object(d, sphere(), add_glass(d, 0.0f), moved(Vec3(0.2f, 0.3f, 0.0f), 0.5f));
  add_object(d, plane(0.5f), add_half_diffuse(d, "ShaderNodeBsdfTransparent", 0.0f),
             shining(Vec3(0.0f, -0.6f, 0.2f), Vec3(0, 1, 0)));
  add_object(d,
             hair({{{-0.6f, 0, -0.5f}, {-0.6f, 0, 0.5f}}, {{-0.8f, 0, -0.5f}, {-0.7f, 0, 0.5f}}}, 0.05f, 0.02f,
                  StrandShape::Round),
             add_diffuse(d, Color(0.3f)));
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 1.5f), Vec3(0, 0, -1), 0.5f, 20.0f));
  set_world(d, Color(0.2f, 0.3f, 0.5f));
  set_camera(d, Vec3(0.1f, -3.0f, 1.2f), Vec3(0.0f, 0.0f, 0.0f), kSize, 0.5f);
  d.camera.aperture_radius = 0.02f;
  d.camera.focus_distance = 3.0f;
  const char* names[] = {"Floor", "Ball", "Sheet", "Hair"};
  for (size_t i = 0; i < 4; ++i) {
    d.objects[i].name = names[i];
    d.materials[i].name = std::string("M") + names[i];
    d.objects[i].asset = i == 1 || i == 2 ? "Group" : "";
  }
  d.settings.samples = 256;
  d.settings.threads = 2;
  return d;
}

using Passes = std::map<std::string, std::vector<float>>;

Passes render_passes(SceneDescription d, std::vector<std::string> names, const std::string& integrator = "path",
                     Diagnostics* diagnostics = nullptr) {
  names.insert(names.begin(), "Combined");
  d.settings.integrator = integrator;
  d.settings.passes = names;
  Session session;
  session.start(std::move(d));
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  Passes passes;
  for (const std::string& name : names) passes[name] = session.snapshot(name);
  if (diagnostics) *diagnostics = session.diagnostics();
  return passes;
}

/// The coverage of a matte in each pixel.
std::vector<double> coverage(const Passes& passes, const std::string& kind, const std::string& name) {
  std::vector<double> covered(size_t(kSize) * kSize, 0.0);
  for (const auto& [pass, values] : passes)
    if (pass.starts_with(kind))
      for (size_t i = 0; i < values.size(); i += 2)
        if (std::bit_cast<uint32_t>(values[i]) == std::bit_cast<uint32_t>(matte_id(name)))
          covered[i / 4] += double(values[i + 1]);
  return covered;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / double(values.size());
}

}  // namespace

TEST(Mattes, every_integrator_finds_the_same_coverage) {
  const std::vector<std::string> names{"CryptoObject00",   "CryptoObject01", "CryptoMaterial00",
                                       "CryptoMaterial01", "CryptoAsset00",  "CryptoAsset01"};
  const Passes reference = render_passes(layers(), names);
  for (const char* thing : {"Floor", "Ball", "Sheet", "Hair"}) {
    EXPECT_GT(mean_of(coverage(reference, "CryptoObject", thing)), 0.005) << thing;
    EXPECT_EQ(coverage(reference, "CryptoObject", thing),
              coverage(reference, "CryptoMaterial", std::string("M") + thing));
  }
  EXPECT_NEAR(
      mean_of(coverage(reference, "CryptoAsset", "Group")),
      mean_of(coverage(reference, "CryptoObject", "Ball")) + mean_of(coverage(reference, "CryptoObject", "Sheet")),
      1e-4);
  for (const IntegratorInfo& integrator : integrator_list()) {
    if (integrator.automatic) continue;
    SceneDescription d = layers();
    if (integrator.gathers_photons) d.settings.photons = 1000;
    const Passes passes = render_passes(d, names, integrator.name);
    for (const char* thing : {"Floor", "Ball", "Sheet", "Hair"}) {
      const std::vector<double> expected = coverage(reference, "CryptoObject", thing),
                                found = coverage(passes, "CryptoObject", thing);
      EXPECT_NEAR(mean_of(found), mean_of(expected), 0.004) << integrator.name << " " << thing;
      for (size_t i = 0; i < found.size(); ++i)
        EXPECT_NEAR(found[i], expected[i], 0.22) << integrator.name << " " << thing << " pixel " << i;
    }
  }
}

TEST(Mattes, coverage_behind_a_half_transparent_sheet) {
  SceneDescription d;
  add_object(d, plane(2.0f), add_half_diffuse(d, "ShaderNodeBsdfTransparent", 0.0f));
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.5f)), moved(Vec3(0, 0, -1.0f)));
  d.objects[0].name = "Sheet", d.objects[1].name = "Wall";
  set_camera(d, Vec3(0, 0, 3), Vec3(0), kSize);
  d.settings.samples = 1024;
  // The colour of the transparent part is 0.8, and its share a half.
  const Passes passes = render_passes(d, {"CryptoObject00"});
  EXPECT_NEAR(mean_of(coverage(passes, "CryptoObject", "Sheet")), 0.6, 1e-4);
  EXPECT_NEAR(mean_of(coverage(passes, "CryptoObject", "Wall")), 0.4, 2e-3);
}

TEST(Mattes, do_not_change_the_image) {
  SceneDescription d = layers();
  d.settings.samples = 8;
  for (const char* integrator : {"path", "bdpt", "photon_map", "irradiance_cache"})
    EXPECT_EQ(render_passes(d, {"CryptoObject00", "Vector", "AO", "AOV Color A"}, integrator)["Combined"],
              render_passes(d, {}, integrator)["Combined"])
        << integrator;
}

TEST(Aovs, show_the_values_of_the_first_surface_and_of_the_world) {
  SceneDescription d;
  GraphBuilder b;
  const int diffuse = b.node("ShaderNodeBsdfDiffuse", {value_input("Color", Vec4(0.5f, 0.5f, 0.5f, 1.0f))});
  b.graph.surface = {diffuse, "BSDF"};
  const int geometry = b.node("ShaderNodeNewGeometry");
  b.node("ShaderNodeOutputAOV", {linked_input("Color", geometry, "Normal"), value_input("Value", 3.0f)},
         {text_property("aov_name", "normal")});
  add_object(d, plane(0.5f), add_material(d, b));
  GraphBuilder w;
  const int background = w.node("ShaderNodeBackground",
                                {value_input("Color", Vec4(0.5f)), value_input("Strength", 1.0f)});
  w.graph.surface = {background, "Background"};
  w.node("ShaderNodeOutputAOV", {value_input("Color", Vec4(0.25f, 0.5f, 0.75f, 1.0f)), value_input("Value", 7.0f)},
         {text_property("aov_name", "normal")});
  d.world.name = "World";
  d.world.graph = w.graph;
  set_camera(d, Vec3(0, 0, 3), Vec3(0), kSize, 0.5f);
  d.settings.samples = 16;
  for (const IntegratorInfo& integrator : integrator_list()) {
    if (integrator.automatic) continue;
    const Passes passes = render_passes(d, {"AOV Color normal", "AOV Value normal", "AOV Value other"},
                                        integrator.name);
    const std::vector<float>&color = passes.at("AOV Color normal"), &value = passes.at("AOV Value normal");
    const size_t centre = size_t(kSize) * kSize / 2 + kSize / 2;
    EXPECT_NEAR(color[4 * centre + 2], 1.0f, 1e-5f) << integrator.name;
    EXPECT_NEAR(color[4 * centre + 3], 1.0f, 1e-5f) << integrator.name;
    EXPECT_NEAR(value[centre], 3.0f, 1e-5f) << integrator.name;
    EXPECT_NEAR(color[0], 0.25f, 1e-5f) << integrator.name;
    EXPECT_NEAR(value[0], 7.0f, 1e-5f) << integrator.name;
    for (const float none : passes.at("AOV Value other")) EXPECT_EQ(none, 0.0f);
  }
}

TEST(Aovs, are_neither_part_of_the_program_of_a_surface_nor_of_a_constant_one) {
  GraphBuilder b;
  b.graph.surface = {b.node("ShaderNodeBsdfDiffuse", {value_input("Color", Vec4(0.5f))}), "BSDF"};
  const int noise = b.node("ShaderNodeTexNoise", {value_input("Scale", 5.0f)});
  b.node("ShaderNodeOutputAOV", {linked_input("Color", noise, "Color")}, {text_property("aov_name", "noise")});
  const ShaderProgram program = compile(b.graph);
  EXPECT_TRUE(program.is_constant());
  EXPECT_TRUE(program.has_aovs());
}

/// The layers with a glowing cube; cube, lamp and world are in the groups "glow", "key" and "sky".
SceneDescription grouped_layers(int samples) {
  SceneDescription d = layers();
  d.settings.samples = samples;
  add_object(d, cube(), add_diffuse(d, Color(0.2f), Color(2.0f, 1.0f, 0.5f)), moved(Vec3(-0.1f, -0.4f, -0.4f), 0.1f));
  d.objects.back().light_group = "glow";
  d.lights[0].light_group = "key";
  d.world.light_group = "sky";
  return d;
}

TEST(LightGroups, the_sum_of_all_groups_and_the_rest_is_the_image) {
  SceneDescription d = grouped_layers(256);
  for (const float clamp : {0.0f, 0.5f}) {
    d.settings.clamp_indirect = clamp;
    const Passes passes = render_passes(d, {"Combined_glow", "Combined_key", "Combined_sky", "Combined_empty"});
    for (size_t i = 0; i < size_t(kSize) * kSize; ++i)
      for (size_t c = 0; c < 3; ++c) {
        float sum = 0.0f;
        for (const char* group : {"Combined_glow", "Combined_key", "Combined_sky"}) sum += passes.at(group)[3 * i + c];
        ASSERT_NEAR(sum, passes.at("Combined")[4 * i + c], 1e-4f * (1.0f + sum));
        ASSERT_EQ(passes.at("Combined_empty")[3 * i + c], 0.0f);
      }
    // A group has the light that is left when the other lights are switched off.
    SceneDescription alone = d;
    alone.lights.clear();
    set_world(alone, Color(0.0f));
    const Passes only = render_passes(alone, {});
    double group = 0.0, image = 0.0;
    for (size_t i = 0; i < size_t(kSize) * kSize; ++i)
      group += double(passes.at("Combined_glow")[3 * i]), image += double(only.at("Combined")[4 * i]);
    if (clamp == 0.0f) {
      EXPECT_NEAR(group, image, 0.03 * image);
    }
  }
}

const std::vector<std::string> kParts{"Emit",     "Env",      "VolumeDir", "VolumeInd", "DiffDir",
                                      "DiffInd",  "DiffCol",  "GlossDir",  "GlossInd",  "GlossCol",
                                      "TransDir", "TransInd", "TransCol"};

/// The light of each part of a pixel and channel. The passes of light that a kind of lobes scatters are divided by its
/// colour.
std::map<std::string, double> light_of_parts(const Passes& passes, size_t pixel, size_t channel) {
  const auto at = [&](const std::string& name) { return double(passes.at(name)[3 * pixel + channel]); };
  std::map<std::string, double> light;
  for (const char* name : {"Emit", "Env", "VolumeDir", "VolumeInd"}) light[name] = at(name);
  for (const std::string kind : {"Diff", "Gloss", "Trans"})
    for (const char* part : {"Dir", "Ind"}) light[kind + part] = at(kind + "Col") * at(kind + part);
  return light;
}

double sum_of(const std::map<std::string, double>& parts) {
  double sum = 0.0;
  for (const auto& [name, light] : parts) sum += light;
  return sum;
}

// Splats can reach a pixel whose samples have met no surface of their kind. Its colour is 0, and their light is in the
// image alone: less and less with more samples.
TEST(LightParts, their_sum_is_the_image_in_every_feature_scene_also_in_volumes) {
  double volume = 0.0;
  for (const TransportScene& scene : feature_scenes()) {
    SceneDescription d = scene.description;
    d.settings.threads = 2;
    d.settings.photons = 1000;
    for (const IntegratorInfo& integrator : integrator_list()) {
      if (!integrator.knows_parts || integrator.automatic) continue;
      d.settings.samples = integrator.splats ? 64 : 4;
      const Passes passes = render_passes(d, kParts, integrator.name);
      const std::vector<float>& combined = passes.at("Combined");
      double all = 0.0, missing = 0.0;
      for (size_t i = 0; i < combined.size() / 4; ++i)
        for (size_t c = 0; c < 3; ++c) {
          const auto parts = light_of_parts(passes, i, c);
          const double image = double(combined[4 * i + c]), difference = std::abs(image - sum_of(parts));
          if (!integrator.splats) {
            ASSERT_LE(difference, 1e-4 * (0.01 + std::abs(image)))
                << scene.name << " " << integrator.name << " pixel " << i;
          }
          all += std::abs(image);
          missing += difference;
          volume += parts.at("VolumeDir") + parts.at("VolumeInd");
        }
      EXPECT_LE(missing, (integrator.splats ? 0.02 : 1e-4) * all) << scene.name << " " << integrator.name;
    }
  }
  EXPECT_GT(volume, 0.1);
}

/// Scenes in which all parts have light.
std::vector<TransportScene> scenes_with_parts() {
  std::vector<TransportScene> scenes{subsurface_scene()};
  scenes.push_back({"layers", layers()});
  SceneDescription& d = scenes.back().description;
  add_object(d, cube(), add_diffuse(d, Color(0.2f), Color(2.0f, 1.0f, 0.5f)), moved(Vec3(-0.1f, -0.4f, -0.4f), 0.1f));
  add_object(d, sphere(), add_glossy(d, 0.3f), moved(Vec3(0.6f, -0.3f, -0.2f), 0.3f));
  add_object(d, plane(0.3f), add_glass(d, 0.4f), shining(Vec3(-0.4f, -0.8f, 0.3f), Vec3(0.0f, 0.8f, 0.6f)));
  for (const TransportScene& scene : feature_scenes())
    if (scene.name == "volume_in_glass" || scene.name == "uneven_smoke") scenes.push_back(scene);
  return scenes;
}

/// Means over seeds of the light of each part in the whole image.
std::map<std::string, RunningMoments> means_of_parts(SceneDescription d, const std::string& integrator,
                                                     uint32_t first_seed, int seeds) {
  std::map<std::string, RunningMoments> means;
  for (int i = 0; i < seeds; ++i) {
    d.settings.seed = first_seed + uint32_t(i);
    const Passes passes = render_passes(d, kParts, integrator);
    std::map<std::string, double> sums;
    for (size_t pixel = 0; pixel < passes.at("Combined").size() / 4; ++pixel)
      for (size_t c = 0; c < 3; ++c)
        for (const auto& [name, light] : light_of_parts(passes, pixel, c)) sums[name] += light;
    for (const auto& [name, sum] : sums) means[name].add(sum);
  }
  return means;
}

// Photon mapping and MPS may differ by the blur of their maps.
TEST(LightParts, techniques_find_the_parts_of_path_tracing) {
  const std::vector<TransportScene> scenes = scenes_with_parts();
  ASSERT_EQ(scenes.size(), 4u);
  std::map<std::string, double> most;  // of each part, as a fraction of the image
  for (size_t s = 0; s < scenes.size(); ++s) {
    SceneDescription d = scenes[s].description;
    d.settings.samples = 64;
    d.settings.threads = 2;
    auto expected = means_of_parts(d, "path", 100, 16);
    double image = 0.0;
    for (const auto& [name, moments] : expected) image += moments.mean();
    for (const auto& [name, moments] : expected) most[name] = std::max(most[name], moments.mean() / image);
    for (size_t t = 0; t < integrator_list().size(); ++t) {
      const IntegratorInfo& integrator = integrator_list()[t];
      if (!integrator.knows_parts || integrator.automatic || std::string(integrator.name) == "path") continue;
      if (is_left_out(s, t)) continue;
      const bool photons = integrator.gathers_photons;
      // Rough glass that photons are stored on is too noisy for a short test (test_features.cpp).
      if (photons && scenes[s].name == "volume_in_glass") continue;
      SceneDescription same = d;
      same.settings.samples = photons ? 8 : 64;
      same.settings.photons = 4000;
      auto found = means_of_parts(same, integrator.name, 200, 8);
      const double blur = photons ? 0.02 : 0.0;
      for (const auto& [name, theirs] : expected) {
        const RunningMoments& ours = found[name];
        const double error = std::sqrt(ours.variance_of_mean() + theirs.variance_of_mean());
        EXPECT_NEAR(ours.mean(), theirs.mean(), 4.0 * error + blur * theirs.mean() + 1e-4 * image)
            << scenes[s].name << " " << integrator.name << " " << name << " of " << image << ", error " << error;
        // With volumes, single parts are too noisy for a short test.
        if (theirs.mean() > 0.1 * image && !build(d)->has_media()) {
          EXPECT_LT(error, (photons ? 0.06 : 0.03) * theirs.mean())
              << scenes[s].name << " " << integrator.name << " " << name << " inconclusive";
        }
      }
    }
  }
  for (const auto& [name, share] : most) EXPECT_GT(share, 0.005) << name << " has no light in any scene";
}

// Bidirectional path tracing with and without photons for the caustics that are seen through the glass.
TEST(LightGroups, techniques_of_paths_find_the_groups_of_path_tracing) {
  SceneDescription d = grouped_layers(128);
  const std::vector<std::string> groups{"Combined_glow", "Combined_key", "Combined_sky"};
  using Means = std::map<std::string, RunningMoments>;
  const auto render = [&](const std::string& integrator, uint32_t first_seed) {
    Means means;
    for (uint32_t seed = first_seed; seed < first_seed + 16; ++seed) {
      d.settings.seed = seed;
      Diagnostics diagnostics;
      const Passes found = render_passes(d, groups, integrator, &diagnostics);
      for (const Diagnostic& diagnostic : diagnostics)
        EXPECT_EQ(diagnostic.message.find("stay black"), std::string::npos) << integrator;
      for (const std::string& group : groups) {
        double sum = 0.0;
        for (const float value : found.at(group)) sum += double(value);
        means[group].add(sum);
      }
      for (size_t i = 0; i < size_t(kSize) * kSize; ++i)
        for (size_t c = 0; c < 3; ++c) {
          float sum = 0.0f;
          for (const std::string& group : groups) sum += found.at(group)[3 * i + c];
          EXPECT_NEAR(sum, found.at("Combined")[4 * i + c], 1e-4f * (1.0f + sum)) << integrator;
        }
    }
    return means;
  };
  Means expected = render("path", 100);
  const std::vector<std::pair<std::string, Merging>> techniques{{"bdpt", Merging::Off},
                                                                {"bdpt", Merging::On},
                                                                {"erpt", Merging::Off},
                                                                {"metropolis", Merging::On},
                                                                {"pmc_pt", Merging::Off}};
  for (const auto& [integrator, merging] : techniques) {
    d.settings.vertex_merging = merging;
    Means found = render(integrator, 200);
    for (const std::string& group : groups) {
      const RunningMoments &ours = found[group], &theirs = expected[group];
      EXPECT_TRUE(statistical::means_agree(theirs, ours, {0.01, 15}))
          << integrator << " " << group << " " << theirs.mean() << " " << ours.mean();
      EXPECT_LT(std::sqrt(ours.variance_of_mean() + theirs.variance_of_mean()), 0.02 * theirs.mean())
          << integrator << " " << group << " inconclusive";
    }
  }
}

/// The plan of `auto` for light that is hard to find with these passes, and the image.
std::pair<std::string, Passes> render_by_auto(const std::vector<std::string>& passes) {
  SceneDescription d = hidden_lamp();
  d.lights[0].light_group = "key";
  d.settings.samples = 64;
  d.settings.threads = 2;
  d.settings.integrator = "auto";
  d.settings.passes = passes;
  Session session;
  session.start(std::move(d));
  EXPECT_TRUE(session.wait(kHang));
  Passes found;
  for (const std::string& pass : passes) found[pass] = session.snapshot(pass);
  return {session.statistics_json(), std::move(found)};
}

// All techniques separate the parts of light. Those with photon maps do not separate light groups, and the irradiance
// cache is never a candidate.
TEST(LightGroups, auto_tries_the_techniques_that_separate_what_is_asked_for) {
  const auto [plan_of_parts, parts] = render_by_auto({"Combined", "DiffDir"});
  EXPECT_NE(plan_of_parts.find("trial of photon mapping"), std::string::npos) << plan_of_parts;
  const auto [plan, images] = render_by_auto({"Combined", "Combined_key"});
  EXPECT_NE(plan.find("trial of energy redistribution"), std::string::npos) << plan;
  EXPECT_EQ(plan.find("trial of photon mapping"), std::string::npos);
  for (size_t i = 0; i < images.at("Combined").size() / 4; ++i)
    for (size_t c = 0; c < 3; ++c) {
      const float key = images.at("Combined_key")[3 * i + c], image = images.at("Combined")[4 * i + c];
      ASSERT_NEAR(key, image, 1e-4f * image + 1e-6f);
    }
}

TEST(LightGroups, integrators_that_do_not_separate_light_report_it) {
  SceneDescription d = layers();
  d.settings.samples = 1;
  d.lights[0].light_group = "key";
  Diagnostics diagnostics;
  render_passes(d, {"Combined_key"}, "photon_map", &diagnostics);
  EXPECT_TRUE(std::any_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& diagnostic) {
    return diagnostic.message.find("Combined_key") != std::string::npos;
  }));
}

// The sum over the pixels is the time that the threads have needed, without the build and the waiting.
TEST(RenderTime, is_that_of_the_samples) {
  SceneDescription d = layers();
  d.settings.threads = 1;
  for (const char* integrator : {"path", "bdpt", "photon_map", "erpt"}) {
    d.settings.photons = 1000;
    const auto start = std::chrono::steady_clock::now();
    const std::vector<float> time = render_passes(d, {"Render Time"}, integrator).at("Render Time");
    const double whole = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    double sum = 0.0;
    for (const float milliseconds : time) {
      EXPECT_GT(milliseconds, 0.0f);
      sum += 1e-3 * double(milliseconds);
    }
    EXPECT_LT(sum, whole) << integrator;
    EXPECT_GT(sum, (std::string(integrator) == "path" ? 0.5 : 0.02) * whole) << integrator;
  }
}

TEST(Occlusion, is_one_on_an_open_floor_and_less_below_a_roof) {
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.5f)));
  set_camera(d, Vec3(0, 0, 1.5f), Vec3(0, 0, 0), kSize, 0.2f);
  d.settings.samples = 64;
  const std::vector<float> open = render_passes(d, {"AO"}).at("AO");
  for (const float value : open) EXPECT_NEAR(value, 1.0f, 1e-5f);
  add_object(d, plane(50.0f), add_diffuse(d, Color(0.5f)), moved(Vec3(0, 0, 2.0f)));
  d.settings.ao_distance = 4.0f;  // rays at more than 60 degrees to the normal are free: a share of cos^2
  const std::vector<float> below = render_passes(d, {"AO"}).at("AO");
  for (const float value : below) EXPECT_NEAR(value, 0.25f, 0.15f);
}

TEST(Motion, vectors_of_a_moving_object_and_a_still_camera) {
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.5f)));
  set_camera(d, Vec3(0, 0, 2), Vec3(0), kSize, 0.5f);
  d.settings.samples = 4;
  d.motion_keys = {rows(moved(Vec3(-0.25f, 0, 0))), rows(moved(Vec3(0.125f, 0.25f, 0)))};
  d.instances[0].first_frame_key = 0;
  const std::vector<float> motion = render_passes(d, {"Vector"}).at("Vector");
  // At the distance 2, the frame of 16 pixels shows 2 metres.
  for (size_t i = 0; i < motion.size(); i += 4) {
    EXPECT_NEAR(std::abs(motion[i]), 2.0f, 1e-3f);
    EXPECT_NEAR(std::abs(motion[i + 2]), 1.0f, 1e-3f);
    EXPECT_EQ(motion[i] > 0.0f, motion[i + 2] > 0.0f);
    EXPECT_NEAR(motion[i + 1], 0.0f, 1e-3f);
    EXPECT_NEAR(std::abs(motion[i + 3]), 2.0f, 1e-3f);
  }
  d.instances[0].first_frame_key = -1;
  const std::vector<float> still = render_passes(d, {"Vector"}).at("Vector");
  for (const float value : still) EXPECT_NEAR(value, 0.0f, 1e-4f);
}

}  // namespace ajar::test_extra_passes_of_renders
