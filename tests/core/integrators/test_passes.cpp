#include <gtest/gtest.h>

#include "render/session.h"
#include "transport_scenes.h"

namespace ajar::test_passes {

using namespace fixtures;

namespace {

const std::vector<std::string> kParts{"Emit",     "Env",      "DiffDir",  "DiffInd",  "DiffCol", "GlossDir",
                                      "GlossInd", "GlossCol", "TransDir", "TransInd", "TransCol"};

/// A scene with every type of lobe, an emissive object, a transparent object, and a world.
SceneDescription everything() {
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.6f, 0.5f, 0.0f)), moved(Vec3(0, 0, -0.5f)));
  add_object(d, sphere(), add_glass(d, 0.0f), moved(Vec3(0.2f, 0.3f, -0.1f), 0.4f));
  add_object(d, sphere(), add_glass(d, 0.3f), moved(Vec3(-0.7f, 0.3f, -0.1f), 0.4f));
  add_object(d, cube(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.3f), moved(Vec3(0.9f, 0.3f, -0.2f), 0.25f));
  add_object(d, cube(), add_diffuse(d, Color(0.2f), Color(2.0f, 1.0f, 0.5f)), moved(Vec3(-0.1f, -0.4f, -0.4f), 0.1f));
  add_object(d, plane(0.4f), add_half_diffuse(d, "ShaderNodeBsdfTransparent", 0.0f),
             shining(Vec3(0.2f, -0.5f, 0.1f), Vec3(0, 1, 0)));
  add_object(d, plane(0.3f), add_glass(d, 0.5f), shining(Vec3(-0.6f, -1.2f, 0.7f), Vec3(0, 1, 0)));
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 1.5f), Vec3(0, 0, -1), 0.5f, 20.0f));
  set_world(d, Color(0.2f, 0.3f, 0.5f));
  set_camera(d, Vec3(0.1f, -3.0f, 1.2f), Vec3(0.0f, 0.0f, 0.0f), 24, 0.5f);
  for (size_t i = 0; i < d.objects.size(); ++i) d.objects[i].pass_index = int(i) + 1;
  for (size_t i = 0; i < d.materials.size(); ++i) d.materials[i].pass_index = 10 + int(i);
  d.settings.samples = 8;
  d.settings.threads = 2;
  return d;
}

struct Rendered {
  std::map<std::string, std::vector<float>> passes;
  Diagnostics diagnostics;
};

Rendered render_passes(SceneDescription d, std::vector<std::string> passes, const std::string& integrator = "path") {
  passes.insert(passes.begin(), "Combined");
  d.settings.integrator = integrator;
  d.settings.passes = passes;
  Session session;
  session.start(d);
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  Rendered r;
  for (const std::string& pass : passes) r.passes[pass] = session.snapshot(pass);
  r.diagnostics = session.diagnostics();
  return r;
}

}  // namespace

TEST(Passes, colours_times_light_plus_emission_is_the_image_in_every_pixel) {
  for (const bool clamped : {false, true}) {
    SceneDescription d = everything();
    if (clamped) d.settings.clamp_indirect = 0.3f;
    auto passes = render_passes(d, kParts).passes;
    double largest = 0.0;
    std::map<std::string, double> sums;
    for (size_t pixel = 0; pixel < 24 * 24; ++pixel) {
      for (size_t c = 0; c < 3; ++c) {
        const size_t i = 3 * pixel + c;
        double sum = double(passes["Emit"][i]) + double(passes["Env"][i]);
        for (const char* kind : {"Diff", "Gloss", "Trans"}) {
          const std::string name = kind;
          sum += double(passes[name + "Col"][i]) * (double(passes[name + "Dir"][i]) + double(passes[name + "Ind"][i]));
        }
        const double combined = double(passes["Combined"][4 * pixel + c]);
        largest = std::max(largest, std::abs(sum - combined) / (combined + 0.01));
      }
    }
    EXPECT_LT(largest, 1e-5);
    for (const std::string& name : kParts) {
      double sum = 0.0;
      for (float value : passes[name]) sum += double(value);
      EXPECT_GT(sum, 0.1) << name;  // the scene has light in every pass
    }
  }
}

TEST(Passes, light_passes_do_not_change_the_image) {
  const SceneDescription d = everything();
  EXPECT_EQ(render_passes(d, kParts).passes["Combined"], render_passes(d, {}).passes["Combined"]);
  const Film plain(0, 0, 8, 8, {"Combined", "Depth"}), parts(0, 0, 8, 8, {"Combined", "DiffDir"});
  EXPECT_FALSE(plain.wants_parts());
  EXPECT_TRUE(parts.wants_parts());
  EXPECT_FALSE(parts.wants_aux());
}

TEST(Passes, a_diffuse_floor_in_a_constant_world_has_only_direct_diffuse_light) {
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.5f, 0.25f, 1.0f)));
  set_world(d, Color(2.0f));
  set_camera(d, Vec3(0, 0, 3), Vec3(0), 8);
  d.settings.samples = 16;
  auto passes = render_passes(d, kParts).passes;
  for (size_t i = 0; i < 3 * 64; ++i) {
    EXPECT_NEAR(passes["DiffDir"][i], 2.0f, 1e-4f);  // radiance of a white diffuse surface in a world of radiance 2
    EXPECT_NEAR(passes["DiffCol"][i], (i % 3 == 0 ? 0.5f : i % 3 == 1 ? 0.25f : 1.0f), 1e-6f);
    for (const char* name : {"Emit", "Env", "DiffInd", "GlossDir", "GlossInd", "TransDir", "TransInd"})
      EXPECT_EQ(passes[name][i], 0.0f) << name;
  }
}

TEST(Passes, indices_and_mist_are_correct) {
  SceneDescription d = everything();
  d.settings.mist = {2.0f, 2.0f, 1.0f};
  auto passes = render_passes(d, {"IndexOB", "IndexMA", "Mist", "Position", "Depth"}).passes;
  bool sky = false, surface = false;
  for (size_t i = 0; i < 24 * 24; ++i) {
    const int object = int(passes["IndexOB"][i]);
    EXPECT_EQ(int(passes["IndexMA"][i]), object == 0 ? 0 : 9 + object);
    if (passes["Depth"][i] > 1e9f) {
      EXPECT_EQ(object, 0);
      sky = true;
    } else {
      EXPECT_GE(object, 1);
      surface = true;
    }
  }
  EXPECT_TRUE(sky && surface);
  EXPECT_EQ(passes["Mist"][24 * 24 - 12], 1.0f);  // the sky
  const Vec3 seen(passes["Position"][3 * 12], passes["Position"][3 * 12 + 1], passes["Position"][3 * 12 + 2]);
  EXPECT_NEAR(passes["Mist"][12], (glm::length(seen - Vec3(0.1f, -3.0f, 1.2f)) - 2.0f) / 2.0f, 0.05f);
}

TEST(Passes, integrators_without_light_passes_report_it) {
  SceneDescription d = everything();
  d.settings.samples = 1;
  const auto said = [](const Rendered& r) {
    int count = 0;
    for (const Diagnostic& diagnostic : r.diagnostics) count += diagnostic.message.find("DiffDir") != std::string::npos;
    return count;
  };
  EXPECT_EQ(said(render_passes(d, {"DiffDir", "Emit"})), 0);
  EXPECT_EQ(said(render_passes(d, {"DiffDir", "Emit"}, "bdpt")), 0);
  EXPECT_EQ(said(render_passes(d, {"DiffDir", "Emit"}, "irradiance_cache")), 1);
  EXPECT_EQ(said(render_passes(d, {"Depth"}, "irradiance_cache")), 0);
  d.settings.direct = DirectMethod::Ris;
  EXPECT_EQ(said(render_passes(d, {"DiffDir", "Emit"})), 1);
}

}  // namespace ajar::test_passes
