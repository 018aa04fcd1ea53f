// Integrators with photon maps have the mean of path tracing, up to the bias of density estimates.
#include "integrators/integrator.h"

#include <gtest/gtest.h>

#include "gate.h"
#include "graph_fixtures.h"
#include "math/statistics.h"
#include "once.h"
#include "renders.h"
#include "transport/photons/photon_map.h"

namespace ajar::test_photon_mapping {

using namespace fixtures;

namespace {

double mean_of(const std::vector<float>& image) {
  double sum = 0.0;
  for (size_t i = 0; i < image.size(); i += 4) sum += double(image[i] + image[i + 1] + image[i + 2]) / 3.0;
  return sum / double(image.size() / 4);
}

RunningMoments mean_over_seeds(SceneDescription d, const char* integrator, int samples, int seeds) {
  Renders renders(with(std::move(d), integrator, samples));
  RunningMoments moments;
  for (int seed = 1; seed <= seeds; ++seed) moments.add(mean_of(renders.combined(uint32_t(seed))));
  return moments;
}

/// Both integrators have the same mean, up to the relative `bias` of photon maps and four standard errors. Path tracing
/// renders each scene once, with the same `reference_samples` and `seeds` for all integrators.
void expect_agreement(const char* integrator, const SceneDescription& d, int samples, int reference_samples, int seeds,
                      double bias, double precision = 0.01) {
  const RunningMoments photons = mean_over_seeds(d, integrator, samples, seeds);
  const RunningMoments& paths = once(d, [&] { return mean_over_seeds(d, "path", reference_samples, seeds); });
  const double error = std::sqrt(photons.variance_of_mean() + paths.variance_of_mean());
  EXPECT_LT(error, precision * paths.mean()) << "too few samples for the test";
  EXPECT_NEAR(photons.mean() / paths.mean(), 1.0, bias + 4.0 * error / paths.mean());
}

int add_material(SceneDescription& d, const std::string& type, Color color, float roughness) {
  MaterialDescription material;
  material.name = type;
  material.graph.nodes.push_back(closure_node(type, color));
  material.graph.nodes[0].inputs.push_back({"Roughness", {}, Vec4(roughness)});
  material.graph.surface = {0, "BSDF"};
  d.materials.push_back(material);
  return int(d.materials.size()) - 1;
}

SceneDescription lit_room(int size, int photons = 5000) {
  SceneDescription d;
  add_object(d, cube(true), add_diffuse(d, Color(0.7f, 0.5f, 0.6f)));
  d.lights.push_back(point_light(Vec3(0.2f, 0.3f, 0.6f), 10.0f, 0.1f));
  set_camera(d, Vec3(-0.2f, -0.95f, 0.1f), Vec3(0.1f, 0.5f, -0.2f), size);
  d.settings.bounces = {64, 64, 64, 64, 64, 0};
  d.settings.photons = photons;
  return d;
}
/// The standard errors of the following images are those of their samples: 5000 photons have the same.
constexpr int kFewPhotons = 2000;

Mat4 placed(Vec3 at, float scale) {
  return Mat4(Vec4(scale, 0, 0, 0), Vec4(0, scale, 0, 0), Vec4(0, 0, scale, 0), Vec4(at, 1));
}

/// The gate has no time for MPS in tests whose question photon mapping answers as well.
bool leaves_mps_out(const char* integrator) { return std::string(integrator) == "mps" && gate_only(); }

}  // namespace

class PhotonMapping : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(By, PhotonMapping, ::testing::Values("photon_map", "mps"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(PhotonMapping, a_furnace_has_radiance_one_within_two_per_cent) {
  SceneDescription d;
  add_object(d, cube(true), add_diffuse(d, Color(0.6f), Color(0.4f)));
  set_camera(d, Vec3(0.1f, -0.5f, 0.2f), Vec3(0.3f, 0.5f, -0.1f), 8);
  d.settings.bounces = {1000, 1000, 1000, 1000, 1000, 0};
  d.settings.photons = 5000;
  const RunningMoments moments = mean_over_seeds(d, GetParam(), 16, 8);
  // Discs that reach beyond an edge of the room contain too few photons. The bias is that of 5000 photons.
  EXPECT_NEAR(moments.mean(), 1.0, 0.02 + 4.0 * std::sqrt(moments.variance_of_mean()));
}

TEST_P(PhotonMapping, agrees_with_the_path_tracer_in_a_room_of_diffuse_walls) {
  expect_agreement(GetParam(), lit_room(12, kFewPhotons), 16, 64, 8, 0.02);
}

TEST_P(PhotonMapping, agrees_with_the_path_tracer_with_rough_and_sharp_glossy_surfaces) {
  if (leaves_mps_out(GetParam())) GTEST_SKIP() << kLeftOut;
  SceneDescription d = lit_room(12, kFewPhotons);
  add_object(d, sphere(), add_material(d, "ShaderNodeBsdfPrincipled", Color(0.6f), 0.3f),
             placed(Vec3(0.3f, 0.3f, -0.6f), 0.4f));
  add_object(d, sphere(), add_material(d, "ShaderNodeBsdfGlossy", Color(0.8f), 0.1f),
             placed(Vec3(-0.4f, 0.4f, -0.6f), 0.4f));
  expect_agreement(GetParam(), d, 32, 512, 8, 0.025);
}

TEST_P(PhotonMapping, caustics_of_a_polished_box_with_smooth_normals_agree_with_the_path_tracer) {
  if (leaves_mps_out(GetParam())) GTEST_SKIP() << kLeftOut;
  // The normals are those of a ball. Walks from the eye bend them at grazing angles, walks from the lamp do not. The
  // lamp lights the box only.
  SceneDescription d;
  add_object(d, plane(1.0f), add_diffuse(d, Color(0.8f)));
  MeshDescription box = cube();
  box.normal_domain = Domain::Vertex;
  for (const Vec3& p : box.positions) box.normals.push_back(glm::normalize(p));
  Mat4 low = placed(Vec3(0.0f, 0.0f, 0.125f), 0.18f);
  low[2].z = 0.125f;
  add_object(d, box, add_material(d, "ShaderNodeBsdfGlossy", Color(0.9f), 0.1f), low);
  d.objects.back().receiver_set = 1;
  d.lights.push_back(point_light(Vec3(0.0f, 0.0f, 0.55f), 10.0f, 0.26f));
  d.lights.back().links.receivers = 0b10;
  d.lights[0].visibility &= ~uint32_t(kVisibleCamera);
  set_camera(d, Vec3(0.6f, 0.2f, 1.2f), Vec3(0.3f, 0.0f, 0.0f), 12, 0.5f);
  d.settings.bounces = {1, 1, 1, 0, 0, 0};
  d.settings.photons = 20000;
  expect_agreement(GetParam(), d, 64, 8192, 8, 0.02, 0.03);
}

TEST_P(PhotonMapping, light_scattered_by_materials_that_depend_on_the_view_is_that_for_the_eye) {
  // The floor is dark from above and bright from the side. The lamp above it lights the walls by way of the floor only.
  SceneDescription d = lit_room(12, kFewPhotons);
  GraphBuilder b;
  const int weight = b.node("ShaderNodeLayerWeight", {value_input("Blend", 0.5f)});
  b.graph.surface = {
      b.node("ShaderNodeBsdfDiffuse", {linked_input("Color", weight, "Facing"), value_input("Roughness", 0.0f)}),
      "BSDF"};
  MaterialDescription silk;
  silk.name = "Silk";
  silk.graph = b.graph;
  d.materials.push_back(silk);
  add_object(d, plane(1.0f), int(d.materials.size()) - 1, placed(Vec3(0.0f, 0.0f, -0.9f), 1.0f));
  LightDescription spot = point_light(Vec3(0), 20.0f, 0.05f);
  spot.kind = LightKind::Spot;
  spot.spot_angle = 0.6f;
  spot.world_from_light = rows(placed(Vec3(0.0f, 0.0f, 0.8f), 1.0f));
  d.lights = {spot};
  expect_agreement(GetParam(), d, 48, 512, 8, 0.02);
}

TEST_P(PhotonMapping, direct_light_from_both_sides_of_a_translucent_sheet_is_complete) {
  // Gather rays hit the emissive planes. The sheet has no side from which alone it receives light.
  SceneDescription d;
  add_object(d, plane(1.0f), add_material(d, "ShaderNodeBsdfTranslucent", Color(0.8f), 0.0f));
  const int bright = add_diffuse(d, Color(0.0f), Color(4.0f)), dim = add_diffuse(d, Color(0.0f), Color(1.0f));
  for (const float x : {-0.6f, 0.1f, 0.7f}) {
    add_object(d, plane(1.0f), bright, placed(Vec3(x, 0.3f, -0.6f), 0.3f));
    add_object(d, plane(1.0f), dim, placed(Vec3(-x, 0.2f, 0.7f), 0.3f));
  }
  set_camera(d, Vec3(0.0f, -3.0f, 0.8f), Vec3(0.0f), 12);
  d.settings.bounces = {0, 0, 0, 0, 0, 0};
  d.settings.photons = 2000;
  expect_agreement(GetParam(), d, 64, 512, 8, 0.0);
}

TEST_P(PhotonMapping, agrees_with_the_path_tracer_on_coarse_smooth_shaded_meshes) {
  if (leaves_mps_out(GetParam())) GTEST_SKIP() << kLeftOut;
  // The shading normals differ much from the geometric ones, so that the result is wrong without the adjoint
  // correction.
  SceneDescription d = lit_room(12, kFewPhotons);
  add_object(d, sphere(5), 0, placed(Vec3(0.1f, 0.3f, -0.3f), 0.6f));
  expect_agreement(GetParam(), d, 32, 128, 8, 0.025);
}

TEST_P(PhotonMapping, light_that_leaves_below_the_plane_of_the_shading_normal_is_complete) {
  // A room whose corners are smooth-shaded: the shading normals of its walls differ from the geometric ones by up to 55
  // degrees.
  if (leaves_mps_out(GetParam())) GTEST_SKIP() << kLeftOut;
  SceneDescription d;
  add_object(d, plane(1.0f), add_diffuse(d, Color(0.8f)));
  MeshDescription box = cube(true);
  box.normal_domain = Domain::Vertex;
  for (const Vec3& p : box.positions) box.normals.push_back(-glm::normalize(p));
  add_object(d, box, 0, placed(Vec3(0.0f, 0.0f, 0.9f), 0.9f));
  d.lights.push_back(point_light(Vec3(0.0f, 0.0f, 1.2f), 10.0f, 0.1f));
  d.lights[0].visibility &= ~uint32_t(kVisibleCamera);
  set_camera(d, Vec3(-0.6f, -0.7f, 0.3f), Vec3(0.2f, 0.5f, 0.6f), 12);
  d.settings.bounces = {64, 64, 64, 64, 64, 0};
  d.settings.photons = 5000;
  expect_agreement(GetParam(), d, 32, 256, 8, 0.02);
}

TEST_P(PhotonMapping, light_through_a_thin_frosted_pane_is_complete) {
  // The pane is much thinner than the lookups are wide. The camera looks away from it.
  const bool has_chains = std::string(GetParam()) == "mps";  // they bring no light to the pane
  if (has_chains && gate_only()) GTEST_SKIP() << kLeftOut;
  SceneDescription d;
  add_object(d, cube(true), add_diffuse(d, Color(0.6f)));
  Mat4 pane = placed(Vec3(0.0f, 0.2f, 0.0f), 0.999f);
  pane[1] *= 0.0015f;
  add_object(d, cube(), add_material(d, "ShaderNodeBsdfGlass", Color(1.0f), 0.4f), pane);
  add_object(d, plane(1.0f), add_diffuse(d, Color(0.0f), Color(4.0f)), placed(Vec3(0.0f, 0.6f, 0.95f), 0.35f));
  set_camera(d, Vec3(0.0f, 0.0f, 0.1f), Vec3(0.1f, -1.0f, -0.2f), 12);
  d.settings.bounces = {32, 32, 32, 32, 32, 0};
  d.settings.photons = 20000;
  d.settings.photon_radius = 0.15f;
  expect_agreement(GetParam(), d, has_chains ? 128 : 64, 2048, 8, 0.03, 0.03);
}

TEST_P(PhotonMapping, bounce_limits_are_for_whole_paths) {
  if (leaves_mps_out(GetParam())) GTEST_SKIP() << kLeftOut;
  // Behind a pane of glass and in a mirror, the eye's side of a path has used up most of the bounces that are allowed.
  SceneDescription d = lit_room(12, kFewPhotons);
  const int glass = add_material(d, "ShaderNodeBsdfGlass", Color(1.0f), 0.0f),
            mirror = add_material(d, "ShaderNodeBsdfGlossy", Color(0.9f), 0.0f);
  Mat4 pane = placed(Vec3(0.0f, -0.7f, 0.0f), 0.9f);
  pane[1] *= 0.02f;
  add_object(d, cube(), glass, pane);
  add_object(d, sphere(), mirror, placed(Vec3(0.3f, 0.4f, -0.3f), 0.5f));
  for (const BounceLimits& limits : {BounceLimits{4, 4, 4, 4, 8, 0}, BounceLimits{12, 4, 1, 2, 8, 0}}) {
    SCOPED_TRACE("total " + std::to_string(limits.total) + ", glossy " + std::to_string(limits.glossy));
    d.settings.bounces = limits;
    expect_agreement(GetParam(), d, 32, 512, 8, 0.025, 0.02);
  }
}

TEST_P(PhotonMapping, the_last_diffuse_bounce_is_seen_by_rough_reflection) {
  if (leaves_mps_out(GetParam())) GTEST_SKIP() << kLeftOut;
  // The ball reflects walls whose light may not be scattered by a further diffuse surface.
  SceneDescription d = lit_room(12, kFewPhotons);
  add_object(d, sphere(), add_material(d, "ShaderNodeBsdfGlossy", Color(0.9f), 0.5f),
             placed(Vec3(0.1f, 0.4f, -0.1f), 0.5f));
  d.settings.bounces = {12, 0, 4, 4, 8, 0};
  expect_agreement(GetParam(), d, 96, 2048, 8, 0.02, 0.02);
}

TEST_P(PhotonMapping, caustic_of_a_glass_ball_agrees_with_the_path_tracer) {
  if (leaves_mps_out(GetParam())) GTEST_SKIP() << kLeftOut;
  SceneDescription d;
  add_object(d, plane(2.0f), add_diffuse(d, Color(0.8f)));
  add_object(d, sphere(48), add_material(d, "ShaderNodeBsdfGlass", Color(1.0f), 0.0f), placed(Vec3(0, 0, 0.6f), 0.5f));
  d.lights.push_back(point_light(Vec3(0, 0, 2.5f), 100.0f, 0.5f));
  // The camera looks at the focus from the side, below the ball.
  set_camera(d, Vec3(0, -2.0f, 0.4f), Vec3(0, 0, 0), 16, 0.3f);
  // Chains rarely move from one part of the caustic to another and need more samples. Plain photons rarely hit the ball.
  const bool chains = std::string(GetParam()) == "mps";
  d.settings.photons = chains ? 20000 : 80000;
  expect_agreement(GetParam(), d, chains ? 100 : 32, 1024, 4, 0.02, 0.01);
}

TEST(PhotonMap, bias_falls_with_the_number_of_passes_at_the_stated_rate) {
  // A lamp below a mirror illuminates the floor as if from its mirror image at height h = 3. The mean irradiance over a
  // disc of radius r below it is 2 (1 - h / sqrt(h^2 + r^2)) / r^2 times the intensity; the correct value is h^-2.
  SceneDescription d;
  add_object(d, plane(6.0f), add_diffuse(d, Color(0.5f)));
  const int mirror = add_material(d, "ShaderNodeBsdfGlossy", Color(1.0f), 0.0f);
  add_object(d, plane(6.0f), mirror, placed(Vec3(0, 0, 2), 1.0f));
  d.lights.push_back(point_light(Vec3(0, 0, 1), 100.0f));
  set_camera(d, Vec3(0, -0.001f, 0.5f), Vec3(0), 1, 1e-4f);
  d.settings.bounces = {1, 1, 1, 0, 0, 0};  // direct light and one reflection
  d.settings.photons =
      600;  // each disc contains fewer than the 60 neighbours of a lookup, so that the radius alone defines it
  const double h = 3.0, r0 = 1.6;
  d.settings.photon_radius = float(r0);
  const auto scene = build(d);
  constexpr int kSteps = 4;
  const int passes[kSteps] = {1, 4, 16, 64};
  // The direct light of the lamp at height 1 is exact.
  double direct = 0.0;
  {
    SceneDescription only = d;
    only.settings.bounces = {0, 0, 0, 0, 0, 0};
    direct = mean_of(render(only, "path", 4, 1));
  }
  const double exact = direct / (h * h);
  RunningMoments bias[kSteps];
  const std::atomic<bool> go{false};
  for (uint32_t seed = 0; seed < 64; ++seed) {
    auto integrator = make_integrator("photon_map");
    integrator->prepare(scene, seed);
    Film film(0, 0, 1, 1, {"Combined"});
    int done = 0;
    for (int s = 0; s < kSteps; ++s) {
      integrator->run_iteration(film, passes[s] - done, go);
      done = passes[s];
      bias[s].add((double(film.resolve("Combined", 1.0f)[0]) - direct) / exact - 1.0);
    }
  }
  const auto slope = [&](const double(&y)[kSteps]) {
    double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
    for (int s = 0; s < kSteps; ++s) {
      const double log_x = std::log(passes[s]), log_y = std::log(-y[s]);
      sum_x += log_x, sum_y += log_y, sum_xx += log_x * log_x, sum_xy += log_x * log_y;
    }
    return (kSteps * sum_xy - sum_x * sum_y) / (kSteps * sum_xx - sum_x * sum_x);
  };
  double measured[kSteps], expected[kSteps];
  for (int s = 0; s < kSteps; ++s) {
    measured[s] = bias[s].mean();
    expected[s] = 0.0;
    for (int i = 0; i < passes[s]; ++i) {
      const double r2 = r0 * r0 * radius2_factor(uint32_t(i));
      expected[s] += (2.0 * (1.0 - h / std::sqrt(h * h + r2)) / r2 * h * h - 1.0) / passes[s];
    }
    EXPECT_NEAR(measured[s], expected[s], 4.0 * std::sqrt(bias[s].variance_of_mean())) << passes[s] << " passes";
    EXPECT_LT(std::sqrt(bias[s].variance_of_mean()), -0.15 * expected[s]) << "too noisy for the test";
  }
  // The slope is -1/3 in the limit (test_photon_map.cpp) and smaller over the first passes.
  EXPECT_NEAR(slope(measured), slope(expected), 0.03);
  EXPECT_LT(slope(measured), -0.15);
}

TEST(PhotonMap, a_narrow_shadow_in_a_caustic_stays_dark) {
  // The lamp below the mirror illuminates the floor as if from (0, 0, 3). A strip half as high casts a shadow of 10 cm
  // around x = 1.03. About 1500 photons arrive there per square metre: 60 of them need a radius of 11 cm.
  SceneDescription d;
  add_object(d, plane(6.0f), add_diffuse(d, Color(0.5f)));
  add_object(d, plane(6.0f), add_material(d, "ShaderNodeBsdfGlossy", Color(1.0f), 0.0f), placed(Vec3(0, 0, 2), 1.0f));
  Mat4 strip = placed(Vec3(0.515f, 0, 1.5f), 1.0f);
  strip[0].x = 0.025f;
  add_object(d, plane(1.0f), add_diffuse(d, Color(0.0f)), strip);
  d.lights.push_back(point_light(Vec3(0, 0, 1), 100.0f));
  constexpr int kSize = 32, kMiddle = kSize / 2;
  set_camera(d, Vec3(1.03f, -0.001f, 0.9f), Vec3(1.03f, 0, 0), kSize, 0.25f);
  d.settings.bounces = {1, 1, 1, 0, 0, 0};  // direct light and one reflection
  d.settings.photons = 200000;
  SceneDescription only_direct = d;
  only_direct.settings.bounces = {0, 0, 0, 0, 0, 0};
  const std::vector<float> direct = render(only_direct, "path", 16, 1);
  Renders renders(with(d, "photon_map", 2));
  RunningMoments shadow, beside;
  for (uint32_t seed = 1; seed <= 8; ++seed) {
    const std::vector<float> image = renders.combined(seed);
    const auto caustic = [&](int x, int y) {
      const size_t at = 4 * (size_t(y) * kSize + size_t(x));
      return double(image[at]) - double(direct[at]);
    };
    for (int x = kMiddle - 1; x <= kMiddle; ++x)
      for (int y = kMiddle - 1; y <= kMiddle; ++y) shadow.add(caustic(x, y));
    for (int x = 0; x < kSize; x += kSize - 1)
      for (int y = 0; y < kSize; y += kSize - 1) beside.add(caustic(x, y));
  }
  EXPECT_GT(beside.mean(), 5.0 * std::sqrt(beside.variance_of_mean())) << "too noisy for the test";
  EXPECT_LT(shadow.mean(), 0.15 * beside.mean());
}

TEST_P(PhotonMapping, the_error_against_path_tracing_falls_with_the_number_of_passes) {
  SceneDescription d = lit_room(10);
  d.lights[0].visibility &= ~uint32_t(
      kVisibleCamera);  // further samples (transport/bidirectional/further_samples.h) change the rate at its edge
  d.settings.photons = 1000;
  d.settings.gather_rays = 8;
  const std::vector<float> exact = render(d, "path", 4096, 1);
  const auto scene = build(d);
  constexpr int kSteps = 3;
  const int passes[kSteps] = {2, 12, 72};
  RunningMoments square[kSteps];
  const std::atomic<bool> go{false};
  for (uint32_t seed = 0; seed < 2; ++seed) {
    auto integrator = make_integrator(GetParam());
    integrator->prepare(scene, seed);
    Film film(0, 0, 10, 10, {"Combined"});
    for (int s = 0, done = 0; s < kSteps; done = passes[s++]) {
      integrator->run_iteration(film, passes[s] - done, go);
      const std::vector<float> image = film.resolve("Combined", 1.0f);
      for (size_t i = 0; i < image.size(); ++i)
        if (i % 4 < 3) square[s].add(sqr(double(image[i]) / exact[i] - 1.0));
    }
  }
  // The squared error falls as passes^(-2/3) in the limit, and as passes^(-1) where noise dominates. Over these passes,
  // the square of the mean of r^2 falls with a slope of -0.51, which is the slope where bias dominates.
  const double slope = std::log(square[kSteps - 1].mean() / square[0].mean()) /
                       std::log(double(passes[kSteps - 1]) / passes[0]);
  EXPECT_LT(slope, -0.4);
  EXPECT_GT(slope, -1.2);
  EXPECT_LT(std::sqrt(square[kSteps - 1].mean()), 0.1);
}

TEST_P(PhotonMapping, the_image_does_not_depend_on_the_number_of_threads) {
  SceneDescription d = lit_room(33);
  add_object(d, sphere(), add_material(d, "ShaderNodeBsdfGlass", Color(1.0f), 0.0f),
             placed(Vec3(0.1f, 0.3f, -0.3f), 0.4f));
  const auto one = render(d, GetParam(), 3, 5, 1);
  EXPECT_EQ(one, render(d, GetParam(), 3, 5, 2));
  EXPECT_EQ(one, render(d, GetParam(), 3, 5, 8));
  EXPECT_NE(one, render(d, GetParam(), 3, 6, 2));
}

TEST_P(PhotonMapping, the_image_does_not_depend_on_the_division_into_iterations) {
  const auto scene = build(lit_room(8));
  const std::atomic<bool> go{false};
  Film together(0, 0, 8, 8, {"Combined"}), apart(0, 0, 8, 8, {"Combined"});
  auto a = make_integrator(GetParam()), b = make_integrator(GetParam());
  a->prepare(scene, 1);
  a->run_iteration(together, 5, go);
  b->prepare(scene, 1);
  for (int samples : {1, 1, 3}) b->run_iteration(apart, samples, go);
  EXPECT_EQ(together.resolve("Combined", 1.0f), apart.resolve("Combined", 1.0f));
}

TEST_P(PhotonMapping, no_photons_are_stored_in_scenes_without_light_or_surfaces) {
  SceneDescription dark = lit_room(8);
  dark.lights.clear();
  SceneDescription empty;
  empty.lights.push_back(point_light(Vec3(0.0f), 10.0f));
  set_camera(empty, Vec3(0, -1, 0), Vec3(0), 8);
  const std::atomic<bool> go{false};
  for (const SceneDescription& d : {dark, empty}) {
    const auto scene = build(d);
    auto integrator = make_integrator(GetParam());
    integrator->prepare(scene, 1);
    Film film(0, 0, 8, 8, {"Combined"});
    integrator->run_iteration(film, 2, go);
    EXPECT_EQ(integrator->statistics().extra.at("photons"), 0.0);
    EXPECT_EQ(integrator->statistics().extra.at("photon_bytes"), 0.0);
    EXPECT_LE(integrator->statistics().rays, 8u * 8u * 2u * 10u);
    EXPECT_EQ(mean_of(film.resolve("Combined", 1.0f)), 0.0);
  }
}

TEST_P(PhotonMapping, displayed_photons_lie_on_the_walls_and_respect_the_maximum) {
  SceneDescription d = lit_room(12);
  d.settings.integrator = GetParam();
  d.settings.samples = 2;
  Session session;
  session.start(d);
  ASSERT_TRUE(session.wait(kHang));
  const PhotonPoints all = session.photons(~0ull), few = session.photons(100), none = session.photons(0);
  EXPECT_GT(all.stored, 1000u);
  EXPECT_EQ(all.positions.size(), all.stored);
  EXPECT_EQ(all.powers.size(), all.stored);
  for (size_t i = 0; i < all.positions.size(); ++i) {
    ASSERT_NEAR(max_component(glm::abs(all.positions[i])), 1.0f, 1e-5f);
    ASSERT_GT(max_component(all.powers[i]), 0.0f);
  }
  EXPECT_EQ(few.stored, all.stored);
  EXPECT_LE(few.positions.size(), 100u);
  EXPECT_GT(few.positions.size(), 90u);
  EXPECT_TRUE(none.positions.empty());
  EXPECT_EQ(none.stored, all.stored);
}

TEST_P(PhotonMapping, displayed_photons_are_available_during_a_render) {
  SceneDescription d = lit_room(12);
  d.settings.integrator = GetParam();
  d.settings.samples = 1 << 24;
  Session session;
  session.start(d);
  size_t shown = 0;
  while (shown == 0 && !session.wait(0.05)) shown = session.photons(50).positions.size();
  EXPECT_EQ(session.progress().phase, Progress::Phase::Rendering);
  session.cancel();
  EXPECT_GT(shown, 40u);
  EXPECT_LE(shown, 50u);
}

TEST(ShownPhotons, displayed_photons_have_the_power_that_the_walls_receive) {
  SceneDescription d = lit_room(4);
  const float albedo = 0.5f;
  d.materials.clear();
  add_diffuse(d, Color(albedo));
  RunningMoments watts;
  for (uint32_t seed = 1; seed <= 16; ++seed) {
    d.settings.integrator = "photon_map";
    d.settings.seed = seed;
    d.settings.samples = 1;
    Session session;
    session.start(d);
    ASSERT_TRUE(session.wait(kHang));
    const PhotonPoints points = session.photons(2000);
    double sum = 0.0;
    for (const Color& power : points.powers) sum += double(luminance(power));
    watts.add(sum * double(points.stored) / double(points.powers.size()));
  }
  // The sum over all bounces is a geometric series of the albedo.
  const double expected = build(d)->lights().total_power() / (1.0 - albedo);
  EXPECT_NEAR(watts.mean() / expected, 1.0, 4.0 * std::sqrt(watts.variance_of_mean()) / expected);
  EXPECT_LT(std::sqrt(watts.variance_of_mean()), 0.01 * expected) << "too noisy for the test";
}

TEST(ShownPhotons, path_tracing_has_no_displayed_photons) {
  SceneDescription d = lit_room(4);
  d.settings.samples = 1;
  Session session;
  session.start(d);
  ASSERT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.photons(100).stored, 0u);
}

}  // namespace ajar::test_photon_mapping
