#include <gtest/gtest.h>

#include <cmath>

#include "agreement.h"
#include "shading/nodes/volume_closures.h"
#include "transport/media/media.h"
#include "transport/media/phase_function.h"

namespace ajar::test_media {

using namespace fixtures;

namespace {

MediumPoint evaluate(const GraphBuilder& b) {
  const ShaderProgram program = compile(b.graph);
  ShadingPoint point;
  point.primitive = kInsideVolume;
  MediumPoint medium;
  program.add_medium(point, medium);
  return medium;
}

void expect_color(Color actual, Color expected) {
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(actual[c], expected[c], 1e-5f * (1.0f + std::abs(expected[c]))) << "channel " << c;
}

/// How the density of a test medium varies.
enum class Density { Constant, NearlyConstant, AlongX, Steep, Sheet };

/// The input socket of the density: `amount`, `amount` plus a millionth of x, `amount` times x of the unit cube or times
/// its 32nd power, or `amount` in a thin sheet.
NodeInput density_input(GraphBuilder& b, Density kind, float amount) {
  if (kind == Density::Constant) return value_input("Density", amount);
  const int coordinates = b.node("ShaderNodeTexCoord");
  const int x = b.node("ShaderNodeSeparateXYZ", {linked_input("Vector", coordinates, "Generated")});
  const auto math = [&](const char* operation, NodeInput first, float second) {
    first.socket = "Value";
    return b.node("ShaderNodeMath", {first, value_input("Value_001", second)}, {text_property("operation", operation)});
  };
  if (kind == Density::AlongX)
    return linked_input("Density", math("MULTIPLY", linked_input("", x, "X"), amount), "Value");
  if (kind == Density::Steep) {
    const int power = math("POWER", linked_input("", x, "X"), 32.0f);
    return linked_input("Density", math("MULTIPLY", linked_input("", power, "Value"), amount), "Value");
  }
  if (kind == Density::NearlyConstant) {
    const int tiny = math("MULTIPLY", linked_input("", x, "X"), 1e-6f);
    return linked_input("Density", math("ADD", linked_input("", tiny, "Value"), amount), "Value");
  }
  // |y - 0.51| < 0.0001, in units of two metres.
  const int middle = math("SUBTRACT", linked_input("", x, "Y"), 0.51f),
            distance = math("ABSOLUTE", linked_input("", middle, "Value"), 0.0f);
  const int within = math("LESS_THAN", linked_input("", distance, "Value"), 0.0001f);
  return linked_input("Density", math("MULTIPLY", linked_input("", within, "Value"), amount), "Value");
}

int add_volume(SceneDescription& d, const std::string& type, Color color, float amount,
               Density density = Density::Constant, float anisotropy = 0.0f) {
  GraphBuilder b;
  const NodeInput socket = density_input(b, density, amount);
  b.graph.volume = {
      b.node(type, {value_input("Color", Vec4(color, 1.0f)), socket, value_input("Anisotropy", anisotropy)}), "Volume"};
  return add_material(d, b);
}
int add_glow(SceneDescription& d, float emission, float absorption, Density density) {
  GraphBuilder b;
  const NodeInput socket = density_input(b, density, absorption);
  const int absorbs = b.node("ShaderNodeVolumeAbsorption", {value_input("Color", Vec4(0.0f)), socket});
  const int emits = b.node("ShaderNodeEmission", {value_input("Color", Vec4(1.0f)), value_input("Strength", emission)});
  b.graph.volume = {b.node("ShaderNodeAddShader",
                           {linked_input("Shader", absorbs, "Volume"), linked_input("Shader_001", emits, "Emission")}),
                    "Shader"};
  return add_material(d, b);
}

/// The camera looks along y from outside through the centre of [-1, 1]^3, at a white world. The bounce limits are very
/// high.
SceneDescription through_a_cube(int material = -1) {
  SceneDescription d;
  set_world(d, Color(1.0f));
  set_camera(d, Vec3(0, -5, 0), Vec3(0), 6, 1e-4f);
  d.settings.bounces = {1000, 1000, 1000, 1000, 8, 1000};
  if (material >= 0) add_object(d, textured_cube(), material);
  return d;
}
int add_cube(SceneDescription& d, int material, Vec3 center = Vec3(0.0f), Vec3 scale = Vec3(1.0f)) {
  return add_object(d, textured_cube(), material,
                    Mat4(Vec4(scale.x, 0, 0, 0), Vec4(0, scale.y, 0, 0), Vec4(0, 0, scale.z, 0), Vec4(center, 1)));
}

/// Moments of the mean of each channel over independent seeds, and the sums of the integrator's counters.
struct Measured {
  std::array<RunningMoments, 3> channels;
  std::map<std::string, double> extra;
};
Measured measure(const SceneDescription& d, int samples, int seeds = 16) {
  const auto scene = build(d);
  const std::atomic<bool> stop{false};
  const auto integrator = make_integrator("path");
  Measured measured;
  for (int seed = 0; seed < seeds; ++seed) {
    Film film(0, 0, d.settings.width, d.settings.height, {"Combined"});
    integrator->prepare(scene, uint32_t(seed));
    integrator->run_iteration(film, samples, stop);
    EXPECT_EQ(film.refused(), 0u);
    const auto image = film.resolve("Combined", 1.0f);
    for (size_t c = 0; c < 3; ++c) {
      double sum = 0.0;
      for (size_t i = c; i < image.size(); i += 4) sum += double(image[i]);
      measured.channels[c].add(4.0 * sum / double(image.size()));
    }
    for (const auto& [name, value] : integrator->statistics().extra) measured.extra[name] += value;
  }
  return measured;
}
/// Tests the mean of each channel. All `tests` calls together have the level 0.01.
void expect_mean(const Measured& measured, Color expected, int tests, double slack = 1e-4) {
  for (size_t c = 0; c < 3; ++c)
    EXPECT_TRUE(statistical::mean_agrees(measured.channels[c], double(expected[int(c)]), {0.01, 3 * tests}, slack))
        << "channel " << c;
}

}  // namespace

TEST(Volume, coefficients_are_those_of_cycles) {
  GraphBuilder scatter;
  scatter.graph.volume = {
      scatter.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(0.8f, 0.5f, 0.2f, 1)),
                                               value_input("Density", 2.0f), value_input("Anisotropy", 0.3f)}),
      "Volume"};
  MediumPoint m = evaluate(scatter);
  expect_color(m.scattering, Color(1.6f, 1.0f, 0.4f));
  expect_color(m.extinction, Color(1.6f, 1.0f, 0.4f));
  ASSERT_EQ(m.lobe_count, 1);
  EXPECT_FLOAT_EQ(m.lobes[0].shape.mean_cosine(), 0.3f);

  GraphBuilder absorb;
  absorb.graph.volume = {absorb.node("ShaderNodeVolumeAbsorption",
                                     {value_input("Color", Vec4(0.8f, 0.5f, 1.2f, 1)), value_input("Density", 2.0f)}),
                         "Volume"};
  m = evaluate(absorb);
  expect_color(m.extinction, Color(0.4f, 1.0f, 0.0f));
  EXPECT_FALSE(m.scatters());

  GraphBuilder principled;
  principled.graph.volume = {
      principled.node("ShaderNodeVolumePrincipled",
                      {value_input("Color", Vec4(0.5f, 0.2f, 1.5f, 1)), value_input("Density", 2.0f),
                       value_input("Anisotropy", -5.0f), value_input("Absorption Color", Vec4(0.25f, 0.0f, 0.0f, 1)),
                       value_input("Emission Strength", 3.0f), value_input("Emission Color", Vec4(1.0f, 0.5f, 0.0f, 1)),
                       value_input("Blackbody Intensity", 0.0f)}),
      "Volume"};
  m = evaluate(principled);
  expect_color(m.scattering, Color(1.0f, 0.4f, 3.0f));
  expect_color(m.extinction, Color(1.0f + 2.0f * 0.5f * 0.5f, 0.4f + 2.0f * 0.8f, 3.0f));
  expect_color(m.emission, Color(3.0f, 1.5f, 0.0f));
  EXPECT_FLOAT_EQ(m.lobes[0].shape.mean_cosine(), -0.999f);

  GraphBuilder mixed;
  const int a = mixed.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(1.0f)), value_input("Density", 4.0f)});
  const int e = mixed.node("ShaderNodeEmission", {value_input("Color", Vec4(1.0f)), value_input("Strength", 2.0f)});
  const int bsdf = mixed.node("ShaderNodeBsdfDiffuse");
  const int both = mixed.node("ShaderNodeAddShader",
                              {linked_input("Shader", e, "Emission"), linked_input("Shader_001", bsdf, "BSDF")});
  mixed.graph.volume = {
      mixed.node("ShaderNodeMixShader", {value_input("Fac", 0.25f), linked_input("Shader", a, "Volume"),
                                         linked_input("Shader_001", both, "Shader")}),
      "Shader"};
  m = evaluate(mixed);
  expect_color(m.scattering, Color(3.0f));
  expect_color(m.emission, Color(0.5f));
}

TEST(Volume, fire_has_the_luminance_of_cycles) {
  GraphBuilder b;
  b.graph.volume = {
      b.node("ShaderNodeVolumePrincipled", {value_input("Density", 0.0f), value_input("Blackbody Intensity", 1.0f),
                                            value_input("Temperature", 1500.0f)}),
      "Volume"};
  // A millionth of the Stefan-Boltzmann law divided by pi: 5.670373e-14 / pi * 1500^4, times a colour of luminance 1
  // (blackbody.h of Blender).
  EXPECT_NEAR(luminance(evaluate(b).emission), 5.670373e-14f / kPi * 1500.0f * 1500.0f * 1500.0f * 1500.0f, 2e-3f);
}

TEST(Volume, invalid_values_are_treated_as_zero) {
  for (const float density : {0.0f, -3.0f, NAN, -INFINITY}) {
    GraphBuilder b;
    b.graph.volume = {
        b.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(-1.0f, 0.5f, NAN, 1)),
                                           value_input("Density", density), value_input("Anisotropy", NAN)}),
        "Volume"};
    EXPECT_TRUE(evaluate(b).empty()) << density;
  }
  // The product of zero and an infinite emission is zero.
  GraphBuilder fire;
  fire.graph.volume = {
      fire.node("ShaderNodeVolumePrincipled",
                {value_input("Density", 0.0f), value_input("Blackbody Intensity", 1.0f),
                 value_input("Temperature", 1e30f), value_input("Blackbody Tint", Vec4(1.0f, 1.0f, 0.0f, 1.0f))}),
      "Volume"};
  EXPECT_GT(evaluate(fire).emission.x, 1e9f);
  EXPECT_EQ(evaluate(fire).emission.z, 0.0f);
  // Invalid values that a program computes are counted.
  const float constants[] = {1.0f, NAN, NAN, NAN, INFINITY};
  MediumPoint m;
  add_volumes({{.kind = VolumeKind::Scatter, .weight = -1, .color = -2, .density = -5, .anisotropy = -1}}, nullptr,
              constants, m);
  EXPECT_TRUE(m.empty());
  EXPECT_GT(m.refused, 0);
}

TEST(Volume, lobes_of_many_anisotropies_are_merged) {
  MediumPoint m;
  for (int i = 0; i < 9; ++i) m.add_scattering(Color(1.0f), PhaseShape::henyey_greenstein(-0.8f + 0.2f * float(i)));
  EXPECT_EQ(m.lobe_count, MediumPoint::kMaxMixtureLobes);
  expect_color(m.scattering, Color(9.0f));
}

TEST(Volume, phase_functions_are_sampled_with_their_density) {
  MediumPoint m;
  m.add_scattering(Color(1.0f, 0.5f, 0.0f), PhaseShape::henyey_greenstein(0.7f));
  m.add_scattering(Color(0.2f, 0.5f, 1.0f), PhaseShape::henyey_greenstein(-0.4f));
  const PhaseFunction phase(m);
  const Vec3 direction = glm::normalize(Vec3(1, 2, -0.5f));
  statistical::DensityTest test;
  test.domain = statistical::SampleDomain::Sphere;
  const auto sample = [&](Pcg32& rng) -> std::optional<Vec3> {
    const float u_lobe = rng.next_float(), x = rng.next_float();
    return phase.sample(direction, u_lobe, Vec2(x, rng.next_float()));
  };
  const auto pdf = [&](Vec3 wi) { return double(phase.pdf_solid_angle(glm::dot(direction, wi))); };
  EXPECT_TRUE(statistical::chi_square_agrees(sample, pdf, test));
  // The integral is 1 in each channel.
  Color integral(0.0f);
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i)
    integral += 4.0f * kPi / float(kSteps) * phase.evaluate(-1.0f + 2.0f * (float(i) + 0.5f) / float(kSteps));
  expect_color(glm::round(integral * 1e4f) / 1e4f, Color(1.0f));
}

TEST(Media, slabs_follow_the_beer_lambert_law) {
  for (const Density density : {Density::Constant, Density::NearlyConstant}) {
    SceneDescription d = through_a_cube();
    add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.9f, 0.5f, 0.0f), 0.8f, density));
    expect_mean(measure(d, 64), glm::exp(-1.6f * Color(0.1f, 0.5f, 1.0f)), 2);
  }
}

TEST(Media, a_varying_density_absorbs_by_its_integral) {
  SceneDescription d = through_a_cube();
  add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 3.0f, Density::AlongX));
  set_camera(d, Vec3(-5, 0, 0), Vec3(0), 6, 1e-4f);
  expect_mean(measure(d, 64), Color(std::exp(-3.0f)), 1);
}

TEST(Media, extinction_above_its_majorant_is_unbiased_and_counted) {
  SceneDescription d = through_a_cube();
  // The sheet of 0.4 mm is not found by the samples for the majorant. Its extinction is fifty times the majorant, so
  // that weights are -50. If it were clamped to the majorant, it would absorb nearly nothing.
  add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 100.0f, Density::Sheet));
  const Measured measured = measure(d, 512);
  expect_mean(measured, Color(std::exp(-0.04f)), 1);
  EXPECT_GT(measured.extra.at("media_majorant_exceeded"), 0.0);
}

TEST(Media, a_steep_density_is_looked_up_where_it_is_dense) {
  SceneDescription d = through_a_cube();
  add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 1000.0f, Density::Steep));
  const auto lookups_at = [&](float x, double transmittance) {
    set_camera(d, Vec3(x, -5, 0), Vec3(x, 0, 0), 6, 1e-4f);
    const Measured measured = measure(d, 64);
    expect_mean(measured, Color(float(transmittance)), 2);
    return measured.extra.at("media_lookups") / (16.0 * 64 * 36);
  };
  EXPECT_LT(lookups_at(0.0f, 1.0), 10.0);  // in the thin half; the density at the side is 1000
  const double depth = 2.0 * 1000.0 * std::pow(0.85, 32.0);
  EXPECT_LT(lookups_at(0.7f, std::exp(-depth)), 3.0 * depth);
}

TEST(Media, white_furnaces_stay_white) {
  // Nothing absorbs, so that the image is that of the world for any number of scattering events. The channels have
  // different scattering coefficients.
  int test = 0;
  for (const Density density : {Density::Constant, Density::NearlyConstant, Density::AlongX}) {
    for (const float g : {0.0f, 0.7f}) {
      SceneDescription d = through_a_cube();
      add_cube(d, add_volume(d, "ShaderNodeVolumeScatter", Color(1.0f, 0.5f, 0.05f), 1.5f, density, g));
      expect_mean(measure(d, 48), Color(1.0f), 6);
      ++test;
    }
  }
  EXPECT_EQ(test, 6);
}

TEST(Media, a_furnace_with_fog_of_the_world_has_radiance_one) {
  SceneDescription d;
  add_object(d, cube(true), add_diffuse(d, Color(0.5f, 0.3f, 0.7f), Color(0.5f, 0.7f, 0.3f)));
  set_camera(d, Vec3(0.1f, -0.8f, 0.1f), Vec3(0.0f, 0.5f, -0.25f), 6, 0.7f);
  d.settings.bounces = {1000, 1000, 1000, 1000, 8, 1000};
  GraphBuilder b;
  b.graph.volume = {b.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(1.0f)), value_input("Density", 1.0f),
                                                       value_input("Anisotropy", 0.4f)}),
                    "Volume"};
  d.world.graph = b.graph;
  expect_mean(measure(d, 48), Color(1.0f), 1);
}

TEST(Media, the_volume_of_the_world_is_infinite) {
  SceneDescription d = through_a_cube();
  add_object(d, cube(), add_diffuse(d, Color(0.0f), Color(1.0f)), moved(Vec3(0, 0.5f, 0)));  // 4.5 m away
  GraphBuilder b;
  b.graph.volume = {
      b.node("ShaderNodeVolumeAbsorption", {value_input("Color", Vec4(0.0f)), value_input("Density", 0.2f)}), "Volume"};
  b.graph.surface = {b.node("ShaderNodeBackground", {value_input("Color", Vec4(1.0f)), value_input("Strength", 1.0f)}),
                     "Background"};
  d.world.graph = b.graph;
  expect_mean(measure(d, 4), Color(std::exp(-0.2f * 4.5f)), 2);
  d.instances.clear();
  d.objects.clear();
  d.meshes.clear();
  expect_mean(measure(d, 4), Color(0.0f), 2);
}

/// A volume of the world with `amount` where lower < coordinate < upper. The sky is white.
void fill_world_between(SceneDescription& d, const char* type, const char* axis, float lower, float upper, float amount,
                        Color color) {
  GraphBuilder b;
  const int geometry = b.node("ShaderNodeNewGeometry");
  const int place = b.node("ShaderNodeSeparateXYZ", {linked_input("Vector", geometry, "Position")});
  const auto math = [&](const char* operation, NodeInput first, NodeInput second) {
    first.socket = "Value";
    second.socket = "Value_001";
    return b.node("ShaderNodeMath", {first, second}, {text_property("operation", operation)});
  };
  const int above = math("GREATER_THAN", linked_input("", place, axis), value_input("", lower)),
            below = math("LESS_THAN", linked_input("", place, axis), value_input("", upper)),
            both = math("MULTIPLY", linked_input("", above, "Value"), linked_input("", below, "Value")),
            density = math("MULTIPLY", linked_input("", both, "Value"), value_input("", amount));
  b.graph.volume = {b.node(type, {value_input("Color", Vec4(color, 1.0f)), linked_input("Density", density, "Value")}),
                    "Volume"};
  b.graph.surface = {b.node("ShaderNodeBackground", {value_input("Color", Vec4(1.0f)), value_input("Strength", 1.0f)}),
                     "Background"};
  d.world.graph = b.graph;
}

TEST(Media, a_volume_of_the_world_varies_near_and_far) {
  for (const auto& [lower, upper, amount] :
       {std::tuple(-4.0f, -2.0f, 0.4f), {30.0f, 50.0f, 0.05f}, {1000.0f, 2000.0f, 1e-3f}, {2e5f, 3e5f, 1e-5f}}) {
    SceneDescription d = through_a_cube();
    add_cube(d, add_diffuse(d, Color(0.5f)), Vec3(0, 0, -3));  // out of sight
    fill_world_between(d, "ShaderNodeVolumeAbsorption", "Y", lower, upper, amount, Color(0.0f));
    expect_mean(measure(d, 256), Color(std::exp(-amount * (upper - lower))), 2);
  }
}

TEST(Media, ground_fog_that_absorbs_nothing_stays_white) {
  SceneDescription d = through_a_cube();
  add_cube(d, add_diffuse(d, Color(0.5f)), Vec3(0, 0, -3), Vec3(0.1f));
  fill_world_between(d, "ShaderNodeVolumeScatter", "Z", -2.0f, 2.0f, 1.0f, Color(1.0f));
  expect_mean(measure(d, 48), Color(1.0f), 1);
}

TEST(Media, light_of_the_sky_and_the_sun_enters_ground_fog) {
  // One scattering at most: the sun above fog of the depth 2, seen from its middle to the side. The path to the sun has
  // the length 1 in the fog.
  SceneDescription d = through_a_cube();
  d.settings.bounces.volume = 0;
  fill_world_between(d, "ShaderNodeVolumeScatter", "Z", -1.0f, 1.0f, 0.5f, Color(1.0f));
  d.world.graph.surface = {-1, ""};
  LightDescription sun;
  sun.kind = LightKind::Sun;
  sun.energy = 3.0f;
  d.lights.push_back(sun);
  expect_mean(measure(d, 256), Color(3.0f * std::exp(-0.5f) / (4.0f * kPi)), 1, 2e-3);
}

TEST(Media, a_sky_behind_fog_is_not_left_to_the_chance_that_nothing_scatters) {
  // Only rays of the camera see the world, so that the fog itself is black. What passes it has no noise.
  SceneDescription d = through_a_cube(-1);
  add_cube(d, add_volume(d, "ShaderNodeVolumeScatter", Color(1.0f), 0.4f));
  d.world.visibility = kVisibleCamera;
  const Measured measured = measure(d, 1, 4);
  for (const RunningMoments& channel : measured.channels) {
    EXPECT_NEAR(channel.mean(), std::exp(-0.8), 1e-5);
    EXPECT_LT(channel.variance(), 1e-10);
  }
}

TEST(Media, both_trackers_have_the_same_mean) {
  std::array<Measured, 2> found;
  for (int k = 0; k < 2; ++k) {
    SceneDescription d = through_a_cube();
    set_camera(d, Vec3(0, -5, 0), Vec3(0), 6, 0.25f);
    set_world(d, Color(0.0f));
    GraphBuilder b;
    const NodeInput density = density_input(b, k == 0 ? Density::Constant : Density::NearlyConstant, 1.2f);
    b.graph.volume = {b.node("ShaderNodeVolumePrincipled",
                             {value_input("Color", Vec4(0.7f, 0.9f, 0.3f, 1)), density, value_input("Anisotropy", 0.4f),
                              value_input("Absorption Color", Vec4(0.2f)), value_input("Emission Strength", 0.05f)}),
                      "Volume"};
    add_cube(d, add_material(d, b));
    d.lights.push_back(point_light(Vec3(2.0f, -2.0f, 2.0f), 300.0f, 0.2f));
    d.lights.push_back(area_lamp(Vec3(-0.4f, 0.3f, 0.2f), Vec3(1, -1, 0), 0.5f, 20.0f));  // inside the medium
    found[size_t(k)] = measure(d, 128);
  }
  for (size_t c = 0; c < 3; ++c)
    EXPECT_TRUE(statistical::means_agree(found[0].channels[c], found[1].channels[c], {0.01, 3}));
  EXPECT_EQ(found[0].extra["media_lookups"], 0.0);
  EXPECT_GT(found[1].extra["media_lookups"], 0.0);
}

TEST(Media, single_scattering_is_the_integral_along_the_ray) {
  // With `hidden_lamp`, a lamp of ten thousand times the power is behind a wall. It is also chosen and must not change
  // the mean.
  for (const auto& [varies, hidden_lamp] : {std::pair(false, false), {true, false}, {false, true}, {true, true}}) {
    SceneDescription d = through_a_cube();
    set_world(d, Color(0.0f));
    set_camera(d, Vec3(0.2f, -5, 0.1f), Vec3(0.2f, 0, 0.1f), 6, 1e-4f);
    d.settings.bounces.volume = 0;
    const float g = 0.6f, amount = 0.9f;
    const Vec3 lamp(0.5f, 0.3f, 2.0f);  // above the cube
    add_cube(d, add_volume(d, "ShaderNodeVolumeScatter", Color(1.0f), amount,
                           varies ? Density::AlongX : Density::Constant, g));
    d.lights.push_back(point_light(lamp, 200.0f));
    if (hidden_lamp) {
      add_object(d, plane(1000.0f), add_diffuse(d, Color(0.0f)),
                 Mat4(Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, 0, -1.5f, 1)));
      d.lights.push_back(point_light(Vec3(0, 0, -2.5f), 2e6f, 0.1f));
    }
    const auto scene = build(d);
    // The midpoint rule. The density is linear, so that the optical depth of a segment is its length times the mean
    // density.
    double expected = 0.0;
    constexpr int kSteps = 4000;
    const auto density = [&](Vec3 p) { return varies ? amount * 0.5f * (p.x + 1.0f) : amount; };
    for (int i = 0; i < kSteps; ++i) {
      const Vec3 p(0.2f, -1.0f + 2.0f * (float(i) + 0.5f) / kSteps, 0.1f);
      const auto sample = scene->lights().sample_li(0, p, Vec2(0.5f), 0.0f);
      ASSERT_TRUE(sample);
      const float rise = (1.0f - p.z) / sample->wi.z;
      const float depth = density(p) * (p.y + 1.0f) + density(p + 0.5f * rise * sample->wi) * rise;
      expected += 2.0 / kSteps *
                  double(density(p) * std::exp(-depth) * PhaseShape::henyey_greenstein(g).evaluate(sample->wi.y) *
                         sample->radiance.x);
    }
    expect_mean(measure(d, 512), Color(float(expected)), 4, 1e-3);
  }
}

TEST(Media, lobes_of_overlapping_media_are_weighted_by_their_scattering) {
  SceneDescription d = through_a_cube();
  set_world(d, Color(0.0f));
  d.settings.bounces.volume = 0;
  const float amounts[] = {0.3f, 0.6f}, g[] = {0.7f, -0.4f};
  for (int i = 0; i < 2; ++i)
    add_cube(d, add_volume(d, "ShaderNodeVolumeScatter", Color(1.0f), amounts[i], Density::Constant, g[i]), Vec3(0.0f),
             Vec3(1.0f + 1e-4f * float(i)));
  d.lights.push_back(point_light(Vec3(0.5f, 0.3f, 2.0f), 200.0f));
  const auto scene = build(d);
  double expected = 0.0;
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 p(0.0f, -1.0f + 2.0f * (float(i) + 0.5f) / kSteps, 0.0f);
    const auto sample = scene->lights().sample_li(0, p, Vec2(0.5f), 0.0f);
    ASSERT_TRUE(sample);
    const float through = std::exp(-0.9f * (p.y + 1.0f + 1.0f / sample->wi.z));
    for (int k = 0; k < 2; ++k)
      expected += 2.0 / kSteps *
                  double(amounts[k] * through * PhaseShape::henyey_greenstein(g[k]).evaluate(sample->wi.y) *
                         sample->radiance.x);
  }
  expect_mean(measure(d, 512), Color(float(expected)), 1, 2e-3);
}

TEST(Media, light_of_a_lamp_in_fog_of_the_world_is_the_integral_to_infinity) {
  SceneDescription d = through_a_cube();
  d.settings.bounces.volume = 0;
  const float sigma = 0.08f, g = 0.2f;
  GraphBuilder b;
  b.graph.volume = {b.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(1.0f)), value_input("Density", sigma),
                                                       value_input("Anisotropy", g)}),
                    "Volume"};
  d.world.graph = b.graph;
  add_cube(d, add_diffuse(d, Color(0.5f)), Vec3(0, 0, -50));  // out of sight
  d.lights.push_back(point_light(Vec3(0.5f, 0.3f, 2.0f), 200.0f));
  const auto scene = build(d);
  double expected = 0.0;
  constexpr int kSteps = 40000;
  for (int i = 0; i < kSteps; ++i) {
    const double t = 300.0 * (i + 0.5) / kSteps;
    const Vec3 p(0.0f, float(-5.0 + t), 0.0f);
    const auto sample = scene->lights().sample_li(0, p, Vec2(0.5f), 0.0f);
    ASSERT_TRUE(sample);
    expected += 300.0 / kSteps * double(sigma) * std::exp(-double(sigma) * (t + double(sample->distance))) *
                double(PhaseShape::henyey_greenstein(g).evaluate(sample->wi.y) * sample->radiance.x);
  }
  expect_mean(measure(d, 512), Color(float(expected)), 1, 1e-4);
}

TEST(Media, emission_is_attenuated_by_absorption) {
  for (const Density density : {Density::Constant, Density::NearlyConstant}) {
    for (const float absorption : {0.0f, 0.7f}) {
      SceneDescription d = through_a_cube();
      set_world(d, Color(0.0f));
      add_cube(d, add_glow(d, 3.0f, absorption, density));
      const float expected = absorption > 0.0f ? 3.0f * (1.0f - std::exp(-2.0f * absorption)) / absorption : 6.0f;
      expect_mean(measure(d, 256), Color(expected), 4);
    }
  }
}

TEST(Media, the_camera_can_be_inside_a_medium) {
  for (const bool bake : {true, false}) {
    SceneDescription d = through_a_cube();
    add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 0.5f), Vec3(0),
             Vec3(2.0f, 2.0f, -2.0f));  // mirrored
    add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 0.25f),
             Vec3(0, 3.1f, 0));  // in front of the camera
    add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 9.0f), Vec3(0, 0, 4),
             Vec3(1, 1, 0.5f));  // above the camera
    set_camera(d, Vec3(0, 0, 0), Vec3(0, 1, 0), 6, 1e-4f);
    const auto scene = build(d, nullptr, bake);
    MediaCounters counters;
    const Media media(*scene);
    EXPECT_EQ(media.around(Vec3(0), 0.0f, counters).size(), 1);
    EXPECT_EQ(media.around(Vec3(0, 3.1f, 0), 0.0f, counters).size(), 1);
    EXPECT_EQ(media.around(Vec3(0, 2.0f - 1e-3f, 0), 0.0f, counters).size(), 1);
    EXPECT_EQ(media.around(Vec3(0, 0, 7), 0.0f, counters).size(), 0);
    expect_mean(measure(d, 4), Color(std::exp(-0.5f * 2.0f - 0.25f * 2.0f)), 2);
  }
}

TEST(Media, overlapping_media_add_up) {
  SceneDescription d = through_a_cube();
  add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 0.5f));  // 2 m
  add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 0.3f),
           Vec3(0, 0.7f, 0));  // 2 m, partly inside the first
  add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 0.9f), Vec3(0.0f),
           Vec3(0.4f));  // 0.8 m, inside the first
  add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 0.2f, Density::NearlyConstant),
           Vec3(0, 0.05f, 0), Vec3(0.3f));  // 0.6 m
  expect_mean(measure(d, 256), Color(std::exp(-1.0f - 0.6f - 0.72f - 0.12f)), 1);
}

TEST(Media, the_atmosphere_of_a_planet_is_looked_up_where_it_is_dense) {
  // The density falls off from a point by powers of ten within a cell of the grid of majorants.
  constexpr double kDensity = 20.0, kRadius = 0.5, kHeight = 0.04, kPlace = 0.6;
  SceneDescription d = through_a_cube();
  GraphBuilder b;
  const int place = b.node("ShaderNodeTexCoord");
  const int length = b.node("ShaderNodeVectorMath", {linked_input("Vector", place, "Object")},
                            {text_property("operation", "LENGTH")});
  const int fall = b.node(
      "ShaderNodeMath",
      {value_input("Value", float(std::exp(-1.0 / kHeight))), linked_input("Value_001", length, "Value")},
      {text_property("operation", "POWER")});
  const int density = b.node(
      "ShaderNodeMath",
      {linked_input("Value", fall, "Value"), value_input("Value_001", float(kDensity * std::exp(kRadius / kHeight)))},
      {text_property("operation", "MULTIPLY")});
  b.graph.volume = {b.node("ShaderNodeVolumeAbsorption",
                           {value_input("Color", Vec4(0.0f)), linked_input("Density", density, "Value")}),
                    "Volume"};
  add_cube(d, add_material(d, b));
  set_camera(d, Vec3(kPlace, -5, 0), Vec3(kPlace, 0, 0), 6, 1e-4f);
  double depth = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double y = 2.0 * (i + 0.5) / kSteps - 1.0;
    depth += 2.0 / kSteps * kDensity * std::exp((kRadius - std::sqrt(kPlace * kPlace + y * y)) / kHeight);
  }
  const Measured measured = measure(d, 64);
  expect_mean(measured, Color(float(std::exp(-depth))), 1);
  EXPECT_LT(measured.extra.at("media_lookups"), 6.0 * 64 * 16 * 36);  // samples, seeds, pixels
  EXPECT_GT(measured.extra.at("media_bytes") / 16, 2e5) << "cells are divided";
  EXPECT_LE(measured.extra.at("media_bytes") / 16, double(Media::max_bytes(1, 1)));
}

/// Only direct light.
SceneDescription floor_below_a_lamp() {
  SceneDescription d;
  add_object(d, plane(4.0f), add_diffuse(d, Color(0.8f)));
  d.lights.push_back(point_light(Vec3(0, 0, 4), 500.0f));
  set_camera(d, Vec3(0, -0.5f, 0.4f), Vec3(0, 0, 0), 6, 1e-4f);
  d.settings.bounces = {0, 0, 0, 0, 8, 0};
  return d;
}

TEST(Media, volumes_hidden_from_shadow_rays_do_not_dim_light) {
  const SceneDescription lit = floor_below_a_lamp();
  const double bright = measure(lit, 4).channels[0].mean();
  const float distance = std::sqrt(0.5f * 0.5f + 0.4f * 0.4f);
  for (const Density density : {Density::Constant, Density::NearlyConstant})
    for (const bool is_seen : {true, false}) {
      SceneDescription d = lit;  // the camera, the floor and the lamp are inside
      add_cube(d, add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 0.6f, density), Vec3(0, 0, 2), Vec3(5));
      d.objects.back().visibility &= ~(kVisibleShadow | (is_seen ? 0u : uint32_t(kVisibleCamera)));
      expect_mean(measure(d, 64), Color(float(bright) * (is_seen ? std::exp(-0.6f * distance) : 1.0f)), 4, 1e-3);
    }
}

TEST(Media, shadow_rays_are_attenuated_by_media) {
  const SceneDescription lit = floor_below_a_lamp();
  SceneDescription dimmed = lit;
  add_cube(dimmed, add_volume(dimmed, "ShaderNodeVolumeAbsorption", Color(0.0f), 0.6f), Vec3(0, 0, 2),
           Vec3(2, 2, 0.5f));
  const auto bright = measure(lit, 4);
  expect_mean(measure(dimmed, 4), Color(float(bright.channels[0].mean()) * std::exp(-0.6f)), 2, 1e-3);
  // A medium inside glass: glass blocks shadow rays, so that the floor is black.
  SceneDescription covered = lit;
  GraphBuilder b;
  b.graph.surface = {b.node("ShaderNodeBsdfGlass", {value_input("Color", Vec4(1.0f)), value_input("Roughness", 0.0f),
                                                    value_input("IOR", 1.45f)}),
                     "BSDF"};
  b.graph.volume = {
      b.node("ShaderNodeVolumeAbsorption", {value_input("Color", Vec4(0.0f)), value_input("Density", 0.6f)}), "Volume"};
  add_cube(covered, add_material(covered, b), Vec3(0, 0, 2), Vec3(2, 2, 0.5f));
  expect_mean(measure(covered, 4), Color(0.0f), 2);
}

/// Cubes of fog on a floor; `below`: the part of their height that is under the floor.
SceneDescription fog_on_a_floor(float below, const std::vector<float>& amounts, Vec3 shift) {
  SceneDescription d;
  set_world(d, Color(1.0f));
  set_camera(d, shift + Vec3(0.3f, -4, 3), shift, 6, 0.4f);
  d.settings.bounces = {8, 8, 8, 8, 8, 8};
  const Mat4 placed = glm::translate(Mat4(1.0f), shift);
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.8f)), placed);
  const float height = 2.0f + below;
  for (const float amount : amounts)
    add_object(d, textured_cube(), add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.2f), amount),
               glm::scale(glm::translate(placed, Vec3(0, 0, 2.0f - 0.5f * height)), Vec3(2, 2, 0.5f * height)));
  return d;
}

TEST(Media, fog_that_ends_on_a_surface_is_as_fog_that_ends_below) {
  for (const Vec3 shift : {Vec3(0.0f), Vec3(1.7f, 0.3f, 0.9f), Vec3(-130.1f, 70.3f, 11.7f)}) {
    const Measured below = measure(fog_on_a_floor(0.1f, {0.4f}, shift), 64),
                   on = measure(fog_on_a_floor(0.0f, {0.4f}, shift), 64);
    expect_mean(on, Color(float(below.channels[0].mean())), 6, 3e-3);
    EXPECT_LT(below.channels[0].mean(), 0.6) << "the fog is dark";
    // Two in the same place.
    expect_mean(measure(fog_on_a_floor(0.0f, {0.15f, 0.25f}, shift), 64), Color(float(below.channels[0].mean())), 6,
                3e-3);
  }
}

TEST(Media, glass_is_tinted_by_its_thickness) {
  SceneDescription d = through_a_cube();
  GraphBuilder b;
  b.graph.surface = {
      b.node("ShaderNodeBsdfRefraction",
             {value_input("Color", Vec4(1.0f)), value_input("Roughness", 0.0f), value_input("IOR", 1.45f)},
             {text_property("distribution", "SHARP")}),
      "BSDF"};
  b.graph.volume = {b.node("ShaderNodeVolumeAbsorption",
                           {value_input("Color", Vec4(0.9f, 0.5f, 0.2f, 1)), value_input("Density", 1.0f)}),
                    "Volume"};
  add_cube(d, add_material(d, b));
  expect_mean(measure(d, 4), glm::exp(-2.0f * Color(0.1f, 0.5f, 0.8f)), 1);
}

TEST(Media, meshes_with_holes_end_at_the_last_surface) {
  SceneDescription d = through_a_cube();
  add_object(d, plane(3.0f), add_volume(d, "ShaderNodeVolumeAbsorption", Color(0.0f), 5.0f),
             Mat4(Vec4(1, 0, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, -1, 0, 0), Vec4(0, 0, 0, 1)));  // faces the camera
  const Measured measured = measure(d, 4);
  expect_mean(measured, Color(1.0f), 1);
  EXPECT_GT(measured.extra.at("media_open_ends"), 0.0);
}

TEST(Media, degenerate_shapes_and_extreme_densities_are_rendered) {
  for (const Density density : {Density::Constant, Density::NearlyConstant, Density::AlongX}) {
    for (const float amount : {1e-30f, 1e10f, -4.0f}) {
      SceneDescription d = through_a_cube();
      d.settings.bounces = {8, 8, 8, 8, 8, 8};
      const int material = add_volume(d, "ShaderNodeVolumeScatter", Color(0.9f, 0.0f, 7.0f), amount, density, 0.99f);
      for (const Vec3 scale : {Vec3(1.0f), Vec3(0.0f), Vec3(1.0f, 0.0f, 1.0f), Vec3(1e-20f), Vec3(1e9f), Vec3(-1.0f)})
        add_cube(d, material, Vec3(0), scale);
      for (int i = 0; i < 20; ++i)
        add_cube(d, material, Vec3(0.01f * float(i), 0, 0), Vec3(0.5f));  // more than the maximum of the stack
      measure(d, 2, 1);
    }
  }
}

TEST(Media, surfaces_that_only_enclose_a_volume_are_invisible) {
  // Such surfaces count no bounce, for any number of them. An empty volume changes nothing.
  SceneDescription d = through_a_cube();
  GraphBuilder b;
  b.graph.volume = {b.node("ShaderNodeVolumeScatter", {value_input("Density", 0.0f)}), "Volume"};
  const int nothing = add_material(d, b);
  for (int i = 0; i < 12; ++i) add_cube(d, nothing, Vec3(0.0f), Vec3(0.1f * float(i + 1)));
  d.settings.bounces.transparent = 0;
  expect_mean(measure(d, 2), Color(1.0f), 1);
}

TEST(Media, alpha_is_one_minus_the_transmittance) {
  SceneDescription d = through_a_cube();
  d.settings.transparent_film = true;
  add_cube(d, add_volume(d, "ShaderNodeVolumeScatter", Color(0.5f), 0.8f));
  RunningMoments alpha;
  for (uint32_t seed = 0; seed < 16; ++seed) {
    const auto image = render(d, "path", 64, seed);
    double sum = 0.0;
    for (size_t i = 3; i < image.size(); i += 4) sum += double(image[i]);
    alpha.add(4.0 * sum / double(image.size()));
  }
  EXPECT_TRUE(statistical::mean_agrees(alpha, 1.0 - std::exp(-0.8), {0.01, 1}));
}

TEST(Media, passes_sum_to_the_image) {
  SceneDescription d = through_a_cube();
  set_camera(d, Vec3(0, -3, 0.5f), Vec3(0), 12, 0.6f);
  add_object(d, plane(4.0f), add_diffuse(d, Color(0.5f, 0.3f, 0.7f)), moved(Vec3(0, 0, -0.5f)));
  add_cube(d, add_volume(d, "ShaderNodeVolumeScatter", Color(0.9f), 0.8f, Density::Constant, 0.3f));
  add_cube(d, add_glow(d, 0.4f, 0.3f, Density::NearlyConstant), Vec3(0.3f, 0, 0), Vec3(0.4f));
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 2.5f), Vec3(0, 0, -1), 0.5f, 20.0f));
  std::vector<std::string> names{"Emit", "Env", "VolumeDir", "VolumeInd", "DiffDir", "DiffInd", "DiffCol"};
  Film film(0, 0, 12, 12, [&] {
    auto all = names;
    all.push_back("Combined");
    return all;
  }());
  const auto integrator = make_integrator("path");
  integrator->prepare(build(d), 1);
  integrator->run_iteration(film, 16, std::atomic<bool>{false});
  std::map<std::string, std::vector<float>> passes;
  for (const std::string& name : names) passes[name] = film.resolve(name, 1.0f);
  const auto combined = film.resolve("Combined", 1.0f);
  std::map<std::string, double> sums;
  for (size_t pixel = 0; pixel < 144; ++pixel)
    for (size_t c = 0; c < 3; ++c) {
      const size_t i = 3 * pixel + c;
      const double sum = double(passes["Emit"][i]) + double(passes["Env"][i]) + double(passes["VolumeDir"][i]) +
                         double(passes["VolumeInd"][i]) +
                         double(passes["DiffCol"][i]) * (double(passes["DiffDir"][i]) + double(passes["DiffInd"][i]));
      EXPECT_NEAR(sum, double(combined[4 * pixel + c]), 1e-4 * (1.0 + std::abs(sum)));
      for (const std::string& name : names) sums[name] += double(passes[name][i]);
    }
  for (const std::string& name : names) EXPECT_GT(sums[name], 0.1) << name;
}

/// In such a medium, the lengths of grid cells overflow. Without a bound on the distant extinction, which is part of
/// the majorant here, rays would take steps of picometres.
TEST(Media, of_extreme_extent_are_rendered) {
  for (const float far : {1e15f, 1e31f, 3e38f}) {
    SceneDescription d = through_a_cube();
    add_cube(d, add_volume(d, "ShaderNodeVolumeScatter", Color(0.8f), 1.0f, Density::AlongX));
    d.meshes.back().positions[7] = Vec3(far, 0.5f * far, 1.0f);
    for (float value : render(d, "path", 1, 1)) EXPECT_TRUE(std::isfinite(value)) << far;
  }
}

TEST(Media, images_do_not_depend_on_threads) {
  SceneDescription d = through_a_cube();
  set_camera(d, Vec3(0, -5, 0), Vec3(0), 24, 0.3f);
  add_cube(d, add_volume(d, "ShaderNodeVolumeScatter", Color(0.9f), 2.0f, Density::AlongX, 0.3f));
  EXPECT_EQ(render(d, "path", 4, 1, 1), render(d, "path", 4, 1, 2));
}

TEST(Media, a_scene_without_volumes_has_no_media) {
  SceneDescription clear = through_a_cube();
  add_cube(clear, add_diffuse(clear, Color(0.5f)));
  EXPECT_FALSE(build(clear)->has_media());
}

}  // namespace ajar::test_media
