// Small lights out of focus: light samples from the lens share their light with camera rays, without bias and with less
// noise.
#include "agreement.h"
#include "integrators/render_plan.h"
#include "transport/bidirectional/lens_light.h"

namespace ajar::test_lens_light {

using namespace fixtures;

namespace {

constexpr int kSize = 48;

/// A floor in the plane of focus, with lights far behind it: a ball lamp, an emissive ball and an emissive ball behind a
/// pane that is half transparent. An emissive panel is in focus.
SceneDescription lights_behind(float radius = 0.08f) {
  SceneDescription d;
  set_camera(d, Vec3(0.0f, -1.0f, 0.2f), Vec3(0.0f, 1.0f, 0.2f), kSize, 0.5f);
  d.camera.aperture_radius = 0.06f;
  d.camera.focus_distance = 1.0f;
  d.settings.bounces = {2, 2, 2, 2, 2, 8};
  add_object(d, plane(0.5f), add_diffuse(d, Color(0.5f)), moved(Vec3(0.0f, 0.0f, -0.1f)));
  add_object(d, plane(0.05f), add_diffuse(d, Color(0.0f), Color(2.0f, 1.8f, 1.6f)),
             shining(Vec3(0.2f, 0.0f, 0.05f), Vec3(0.0f, 1.0f, 0.0f)));
  d.lights.push_back(point_light(Vec3(-1.5f, 6.0f, 1.5f), 60.0f, radius));
  const int bulb = add_diffuse(d, Color(0.0f), Color(0.5f, 0.3f, 0.1f) / (radius * radius));
  add_object(d, sphere(), bulb, moved(Vec3(1.2f, 6.0f, 1.4f), radius));
  add_object(d, sphere(), bulb, moved(Vec3(0.0f, 8.0f, 3.0f), radius));
  GraphBuilder b;
  const int clear = b.node("ShaderNodeBsdfTransparent", {value_input("Color", Vec4(0.8f, 0.9f, 1.0f, 1.0f))});
  const int white = b.node("ShaderNodeBsdfDiffuse", {value_input("Color", Vec4(0.8f))});
  b.graph.surface = {b.node("ShaderNodeMixShader", {value_input("Fac", 0.5f), linked_input("Shader", clear, "BSDF"),
                                                    linked_input("Shader_001", white, "BSDF")}),
                     "Shader"};
  add_object(d, plane(1.0f), add_material(d, b), shining(Vec3(0.0f, 7.0f, 3.0f), Vec3(0.0f, 1.0f, 0.0f)));
  return d;
}
/// The same by camera rays alone: a limit of direct light that nothing reaches.
SceneDescription by_camera_rays(SceneDescription d) {
  d.settings.clamp_direct = 1e30f;
  return d;
}

std::vector<float> image(const std::shared_ptr<const Scene>& scene, int samples, uint32_t seed,
                         const std::string& pass = "Combined") {
  const auto integrator = make_integrator("path");
  integrator->prepare(scene, seed);
  Film film(0, 0, kSize, kSize, {"Combined", pass});
  integrator->run_iteration(film, samples, std::atomic<bool>(false));
  return film.resolve(pass, 1.0f);
}

/// The sum over the pixels of the variances of the red channel over seeds.
double variance(const SceneDescription& d, int samples, uint32_t seeds) {
  const auto scene = build(d);
  std::vector<RunningMoments> pixels(size_t(kSize) * kSize);
  for (uint32_t seed = 1; seed <= seeds; ++seed) {
    const auto values = image(scene, samples, seed);
    for (size_t i = 0; i < pixels.size(); ++i) pixels[i].add(double(values[4 * i]));
  }
  double sum = 0.0;
  for (const RunningMoments& pixel : pixels) sum += pixel.variance();
  return sum;
}

/// `precision`: the greatest standard error, relative to the mean.
void expect_mean_of_camera_rays(const SceneDescription& d, double precision) {
  ASSERT_TRUE(LensLight(*build(d)).active());
  const auto expected = whole(by_camera_rays(d), "path", 512, 16, 100), actual = whole(d, "path", 128, 16, 200);
  EXPECT_TRUE(statistical::means_agree(expected, actual, {0.01, 1}))
      << "camera rays " << expected.mean() << ", with light samples " << actual.mean();
  EXPECT_LT(std::sqrt(expected.variance_of_mean() + actual.variance_of_mean()), precision * expected.mean());
}

}  // namespace

TEST(LensLight, keeps_the_mean_of_camera_rays) {
  // Probes find some of the lights and miss others. The test detects a bias of 2 %.
  expect_mean_of_camera_rays(lights_behind(0.25f), 0.006);
}
TEST(LensLight, is_attenuated_by_media_as_camera_rays_are) {
  SceneDescription d = lights_behind(0.25f);
  GraphBuilder b;
  b.graph.volume = {b.node("ShaderNodeVolumeAbsorption",
                           {value_input("Color", Vec4(0.2f, 0.5f, 0.8f, 1.0f)), value_input("Density", 0.2f)}),
                    "Volume"};
  d.world.graph = b.graph;
  ASSERT_TRUE(build(d)->has_media());
  expect_mean_of_camera_rays(d, 0.01);
}
TEST(LensLight, has_less_noise) {
  SceneDescription d = lights_behind();
  // Without the pane and the ball behind it, which stays with camera rays.
  d.objects.resize(3);
  d.instances.resize(3);
  EXPECT_LT(10.0 * variance(d, 16, 4), variance(by_camera_rays(d), 16, 4));
}
TEST(LensLight, does_not_depend_on_threads_or_on_the_division_into_iterations) {
  const SceneDescription d = lights_behind();
  EXPECT_EQ(render(d, "path", 8, 5, 1), render(d, "path", 8, 5, 3));
  const auto scene = build(d);
  const auto film_of = [&](std::initializer_list<int> iterations) {
    const auto integrator = make_integrator("path");
    integrator->prepare(scene, 7);
    Film film(0, 0, kSize, kSize, {"Combined"});
    for (int samples : iterations) integrator->run_iteration(film, samples, std::atomic<bool>(false));
    return film.resolve("Combined", 1.0f);
  };
  EXPECT_EQ(film_of({1, 2, 5}), film_of({8}));
}
TEST(LensLight, is_in_the_pass_of_emission) {
  const auto scene = build(lights_behind());
  const auto combined = image(scene, 16, 3), emission = image(scene, 16, 3, "Emit");
  double all = 0.0, emitted = 0.0;
  for (size_t i = 0; i < size_t(kSize) * kSize; ++i) all += double(combined[4 * i]), emitted += double(emission[3 * i]);
  // The floor and the pane reflect little.
  EXPECT_LT(emitted, all);
  EXPECT_GT(emitted, 0.8 * all);
}
TEST(LensLight, is_not_used_where_camera_rays_find_all_lights) {
  SceneDescription d = lights_behind();
  d.camera.aperture_radius = 0.0f;
  EXPECT_STREQ(LensLight::reason_against(*build(d)), "the camera has no aperture");
  EXPECT_FALSE(make_render_plan(*build(d)).lens_light);
  d = lights_behind();
  d.camera.kind = CameraKind::Orthographic;
  EXPECT_FALSE(make_render_plan(*build(d)).lens_light);
  d = lights_behind();
  EXPECT_TRUE(make_render_plan(*build(d)).lens_light);
  // The panel that is in focus.
  d.lights.clear();
  d.objects.resize(2);
  d.instances.resize(2);
  EXPECT_FALSE(LensLight(*build(d)).active());
}

}  // namespace ajar::test_lens_light
