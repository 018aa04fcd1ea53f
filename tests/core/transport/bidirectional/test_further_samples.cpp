// Further samples of the light that the eye sees directly, and branches at delta lobes. They keep the mean and reduce
// the noise; further samples are taken only where this is efficient.
#include "transport/bidirectional/further_samples.h"

#include <gtest/gtest.h>

#include "integrators/integrator.h"
#include "math/statistics.h"
#include "statistical.h"
#include "transport/bidirectional/direct_pass.h"
#include "transport/bidirectional/direct_paths.h"
#include "transport/bidirectional/seen_light.h"
#include "transport_scenes.h"

namespace ajar::test_further_samples {

namespace {

using namespace fixtures;
using statistical::means_agree;

constexpr uint32_t kSeed = 11;
const std::atomic<bool> kGoOn{false};

std::shared_ptr<const Scene> build(SceneDescription d) {
  Diagnostics diagnostics;
  return Scene::build(std::move(d), {}, diagnostics);
}

/// A small emissive plate beside a mirror ball and a glass ball, in a room with walls of this albedo.
SceneDescription plate_and_balls(float albedo, int size) {
  SceneDescription d;
  add_object(d, cube(true), add_diffuse(d, Color(albedo)));
  add_object(d, plane(0.15f), add_diffuse(d, Color(0.0f), Color(20.0f)),
             shining(Vec3(0.3f, 0.9f, 0.3f), Vec3(0, 1, 0)));
  add_object(d, sphere(24), add_glossy(d, 0.0f), moved(Vec3(-0.4f, 0.4f, -0.3f), 0.3f));
  add_object(d, sphere(24), add_glass(d, 0.0f), moved(Vec3(0.3f, 0.1f, -0.3f), 0.25f));
  set_camera(d, Vec3(0.0f, -0.9f, 0.0f), Vec3(0.0f, 0.5f, 0.0f), size, 0.7f);
  d.settings.bounces = {8, 8, 8, 8, 8, 0};
  return d;
}

double mean_luminance(const Film& film) {
  const std::vector<float> image = film.resolve("Combined", 1.0f);
  double sum = 0.0;
  for (size_t i = 0; i < image.size(); i += 4) sum += double(luminance(Color(image[i], image[i + 1], image[i + 2])));
  return sum / double(image.size() / 4);
}

TEST(SeenLight, has_the_mean_of_path_tracing) {
  // With black walls, all light is seen directly, in the mirror, or through glass.
  constexpr int kSize = 16, kSamples = 64, kReplicates = 16;
  SceneDescription d = plate_and_balls(0.0f, kSize);
  const std::vector<int> limits{0, 1, 2, 8};
  for (int limit : limits) {
    d.settings.bounces.total = limit;
    const std::shared_ptr<const Scene> scene = build(d);
    const PixelFilter filter(scene->settings().filter, scene->settings().filter_width);
    RunningMoments seen, traced;
    uint64_t rays = 0;
    for (uint32_t replicate = 0; replicate < kReplicates; ++replicate) {
      double sum = 0.0;
      Sampler sampler(Sampler::Kind::Sobol, hash_combine(11, replicate));
      for (uint32_t pixel = 0; pixel < kSize * kSize; ++pixel)
        for (uint32_t i = 0; i < kSamples; ++i) {
          sampler.start(pixel, i);
          const Vec2 at = Vec2(float(pixel % kSize) + 0.5f, float(pixel / kSize) + 0.5f) +
                          filter.sample(sampler.get_2d());
          sum += double(
              luminance(trace_seen_light(*scene, scene->camera().generate_ray(at, Vec2(0.5f), 0.0f), sampler, rays)));
        }
      seen.add(sum / (kSize * kSize * kSamples));
      const auto path = make_integrator("path");
      path->prepare(scene, 1000 + replicate);
      Film film(0, 0, kSize, kSize, {"Combined"});
      path->run_iteration(film, kSamples, kGoOn);
      traced.add(mean_luminance(film));
    }
    EXPECT_GT(traced.mean(), 0.01);
    EXPECT_LT(std::sqrt(seen.variance_of_mean()), 0.01 * seen.mean()) << "too few samples for the test";
    EXPECT_TRUE(means_agree(seen, traced, {0.01, int(limits.size())})) << limit << " bounces";
  }
}

/// An image whose left half shows an emissive plate. The rest of each sample is 1 plus noise.
class FurtherSamplesTest : public ::testing::Test {
 protected:
  static constexpr int kSize = 24, kBorder = 12;
  void SetUp() override {
    SceneDescription d;
    add_object(d, plane(5.0f), add_diffuse(d, Color(0.0f), Color(10.0f)), moved(Vec3(-5.0f, 0.0f, 0.0f)));
    set_camera(d, Vec3(0.0f, 0.0f, 2.0f), Vec3(0.0f), kSize, 0.7f);
    scene_ = build(d);
    filter_ = PixelFilter(scene_->settings().filter, scene_->settings().filter_width);
  }
  /// Takes one sample of every pixel. The noise of its rest has this standard deviation.
  void sample(FurtherSamples& further, uint32_t index, float deviation, RunningMoments* at_border = nullptr) {
    Sampler sampler(Sampler::Kind::Sobol, 5);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        sampler.start(uint32_t(y * kSize + x), index);
        const Vec2 at = Vec2(float(x) + 0.5f, float(y) + 0.5f) + filter_.sample(sampler.get_2d());
        const Color found = trace_seen_light(*scene_, scene_->camera().generate_ray(at, Vec2(0.5f), 0.0f), sampler,
                                             rest_rays_);
        const Color mean = further.mean_with(found, false, 1.0f + deviation * (sampler.get_1d() < 0.5f ? -1.0f : 1.0f),
                                             x, y, [&](Vec2 on_film, Sampler& numbers) {
                                               return trace_seen_light(
                                                   *scene_, scene_->camera().generate_ray(on_film, Vec2(0.5f), 0.0f),
                                                   numbers, further_rays_);
                                             });
        if (at_border && x == kBorder) at_border->add(double(mean.x));
      }
    rest_rays_ += 10 * kSize * kSize;  // an assumed cost of the light at surfaces
  }
  std::shared_ptr<const Scene> scene_;
  Film film_{0, 0, kSize, kSize, {"Combined"}};
  PixelFilter filter_;
  uint64_t rest_rays_ = 0, further_rays_ = 0;
};

TEST_F(FurtherSamplesTest, further_rays_are_taken_at_the_edge_of_the_lamp) {
  FurtherSamples further;
  further.prepare(*scene_, film_, filter_, 1, {4, 0.25});
  ASSERT_TRUE(further.active());
  for (uint32_t i = 0; i < 4; ++i) {
    sample(further, i, 0.5f);
    further.learn(i + 1, rest_rays_, further_rays_);
  }
  for (int y = 4; y < kSize - 4; ++y) {
    EXPECT_GE(further.taken_at(kBorder, y), 3);
    EXPECT_EQ(further.taken_at(2, y), 1) << "inside the lamp, all rays have the same value";
    EXPECT_EQ(further.taken_at(kSize - 3, y), 1) << "outside the lamp, all rays are black";
  }
}

TEST_F(FurtherSamplesTest, the_mean_does_not_change_and_the_noise_falls) {
  FurtherSamples further;
  further.prepare(*scene_, film_, filter_, 1, {4, 0.25});
  RunningMoments first, later, plain;
  for (uint32_t i = 0; i < 32; ++i) {
    sample(further, i, 0.5f, i < 2 ? &first : i >= 4 ? &later : nullptr);
    further.learn(i + 1, rest_rays_, further_rays_);
  }
  Sampler sampler(Sampler::Kind::Independent, 7);
  for (uint32_t i = 0; i < 4000; ++i) {
    sampler.start(0, i);
    const Vec2 at = Vec2(float(kBorder) + 0.5f, 0.5f * kSize) + filter_.sample(sampler.get_2d());
    plain.add(
        double(trace_seen_light(*scene_, scene_->camera().generate_ray(at, Vec2(0.5f), 0.0f), sampler, rest_rays_).x));
  }
  EXPECT_TRUE(means_agree(later, plain, {0.01, 2}));
  EXPECT_TRUE(means_agree(first, plain, {0.01, 2}));
  EXPECT_LT(later.variance(), plain.variance() / 4.0);
}

TEST_F(FurtherSamplesTest, further_rays_stay_below_their_limit) {
  FurtherSamples further;
  further.prepare(*scene_, film_, filter_, 1, {4, 0.25});
  for (uint32_t i = 0; i < 2; ++i) {
    sample(further, i, 0.0f);  // only the edge of the lamp has noise: the maximum number of further rays
    further.learn(i + 1, rest_rays_, further_rays_);
  }
  const uint64_t before = further_rays_, rest_before = rest_rays_;
  sample(further, 2, 0.0f);
  EXPECT_GT(further_rays_, before);
  EXPECT_LT(double(further_rays_ - before), 0.3 * double(rest_rays_ - rest_before));
}

TEST(SpecularBranches, every_sample_contains_the_reflection_of_a_lamp_in_glass) {
  // A pane, seen at 45 degrees, reflects about five per cent of a lamp that fills the image. There is no other light.
  constexpr int kRays = 256;
  SceneDescription d;
  add_object(d, plane(4.0f), add_glass(d, 0.0f));
  add_object(d, plane(8.0f), add_diffuse(d, Color(0.0f), Color(10.0f)),
             shining(Vec3(0.0f, 3.0f, 3.0f), Vec3(0, -1, -1)));
  set_camera(d, Vec3(0.0f, -3.0f, 3.0f), Vec3(0.0f), 1, 0.02f);
  const std::shared_ptr<const Scene> scene = build(d);
  RunningMoments seen, direct;
  Sampler sampler(Sampler::Kind::Independent, 3);
  uint64_t rays = 0;
  for (uint32_t i = 0; i < kRays; ++i) {
    sampler.start(0, i);
    seen.add(double(luminance(
        trace_seen_light(*scene, scene->camera().generate_ray(Vec2(0.5f), Vec2(0.5f), 0.0f), sampler, rays))));
    sampler.start(1, i);
    direct.add(
        double(luminance(trace_direct_paths({*scene}, Vec2(0.5f), sampler, nullptr, rays, nullptr, nullptr).radiance)));
  }
  const auto path = make_integrator("path");
  path->prepare(scene, 5);
  Film film(0, 0, 1, 1, {"Combined"});
  path->run_iteration(film, 1 << 20, kGoOn);
  EXPECT_GT(seen.mean(), 0.3);
  EXPECT_NEAR(seen.mean(), mean_luminance(film), 0.01 * seen.mean());
  EXPECT_NEAR(direct.mean(), seen.mean(), 1e-4 * seen.mean());
  EXPECT_LT(seen.variance() + direct.variance(), 1e-6 * seen.mean() * seen.mean());
}

TEST(DirectPass, does_not_depend_on_the_division_into_iterations) {
  SceneDescription d = plate_and_balls(0.3f, 12);
  d.settings.vertex_merging = Merging::Off;
  const std::shared_ptr<const Scene> scene = build(d);
  const PathSpace space(*scene, 0, 0, 12, 12, true);
  const auto picture = [&](const std::vector<int>& shares) {
    DirectPass pass;
    pass.prepare(*scene, nullptr, false, 9);
    Film film(0, 0, 12, 12, {"Combined"});
    for (int samples : shares) pass.add(film, space, samples * int(DirectPass::kShare), kGoOn);
    return film.resolve("Combined", 1.0f);
  };
  const std::vector<float> at_once = picture({16});
  EXPECT_EQ(picture({1, 2, 4, 9}), at_once);
  EXPECT_EQ(picture({3, 4, 8, 1}), at_once);
}

TEST(DirectPass, further_samples_and_branches_keep_the_mean) {
  constexpr int kSize = 16, kSamples = 32, kReplicates = 24;
  SceneDescription d = plate_and_balls(0.3f, kSize);
  add_object(d, sphere(24), add_glossy(d, 0.15f), moved(Vec3(0.0f, 0.5f, 0.5f), 0.2f));
  d.settings.vertex_merging = Merging::Off;
  const std::shared_ptr<const Scene> scene = build(d);
  const PathSpace space(*scene, 0, 0, kSize, kSize, true);
  RunningMoments passes, plain;
  uint64_t further = 0;
  for (uint32_t replicate = 0; replicate < kReplicates; ++replicate) {
    DirectPass pass;
    pass.prepare(*scene, nullptr, false, 100 + replicate);
    Film film(0, 0, kSize, kSize, {"Combined"});
    for (int i = 0; i < kSamples; ++i) pass.add(film, space, DirectPass::kShare, kGoOn);
    passes.add(mean_luminance(film));
    uint64_t rays = 0;
    double sum = 0.0;
    Sampler sampler(Sampler::Kind::Sobol, hash_combine(77, replicate));
    for (uint32_t pixel = 0; pixel < kSize * kSize; ++pixel)
      for (uint32_t i = 0; i < kSamples; ++i) {
        sampler.start(pixel, i);
        const Vec2 at = Vec2(float(pixel % kSize) + 0.5f, float(pixel / kSize) + 0.5f) +
                        space.filter.sample(sampler.get_2d());
        sum += double(luminance(trace_direct_paths({*scene}, at, sampler, nullptr, rays, nullptr, nullptr).radiance));
      }
    plain.add(sum / (kSize * kSize * kSamples));
    further += pass.rays() - rays;
  }
  EXPECT_TRUE(means_agree(passes, plain));
  EXPECT_LT(std::sqrt(plain.variance_of_mean()), 0.01 * plain.mean()) << "too few samples for the test";
  EXPECT_LT(passes.variance(), plain.variance());
  EXPECT_GT(further, 0u);
}

}  // namespace

}  // namespace ajar::test_further_samples
