#include "agreement.h"
#include "gate.h"
#include "transport/bidirectional/path_seeds.h"

namespace ajar::test_erpt {

using namespace fixtures;

namespace {

const std::vector<TransportScene> kScenes = transport_scenes();

}  // namespace

class RedistributionOf : public ::testing::TestWithParam<size_t> {};
TEST_P(RedistributionOf, energy_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 1)) GTEST_SKIP() << kLeftOut;
  expect_agreement(kScenes[GetParam()], "erpt", 32, int(kScenes.size()));
}
INSTANTIATE_TEST_SUITE_P(Scenes, RedistributionOf, ::testing::Range<size_t>(0, kScenes.size()),
                         [](const auto& info) { return kScenes[info.param].name; });

TEST(EnergyRedistribution, short_renders_with_few_chains_have_the_same_mean) {
  // Four steps per pixel: 24 samples and about six chains. The test would detect a bias of 4 %.
  const SceneDescription& d = kScenes[0].description;
  const RunningMoments expected = whole(d, "path", 64, 16, 1000), actual = whole(d, "erpt", 4, 300, 2000);
  EXPECT_LT(std::sqrt(expected.variance_of_mean() + actual.variance_of_mean()), 0.012 * expected.mean());
  EXPECT_TRUE(statistical::means_agree(expected, actual, {0.01, 1}))
      << "path " << expected.mean() << ", erpt " << actual.mean();
}

TEST(EnergyRedistribution, learning_from_few_samples_does_not_change_the_mean) {
  // 69 samples; the importance and the quantum are computed from the first 6, 12, 24 and 48. The test would detect a
  // bias of 5 %.
  SceneDescription d = kScenes[0].description;
  d.settings.exposure = 4.0f;
  const RunningMoments expected = whole(d, "path", 64, 16, 1000), actual = whole(d, "erpt", 12, 200, 3000);
  EXPECT_LT(std::sqrt(expected.variance_of_mean() + actual.variance_of_mean()), 0.015 * expected.mean());
  EXPECT_TRUE(statistical::means_agree(expected, actual, {0.01, 1}))
      << "path " << expected.mean() << ", erpt " << actual.mean();
}

TEST(EnergyRedistribution, the_image_does_not_depend_on_threads_or_the_division_into_iterations) {
  SceneDescription d = kScenes[1].description;
  d.settings.width = 40;
  d.settings.height = 33;
  const auto one = render(d, "erpt", 12, 5, 1);
  EXPECT_EQ(one, render(d, "erpt", 12, 5, 2));
  EXPECT_EQ(one, render(d, "erpt", 12, 5, 8));
  EXPECT_NE(one, render(d, "erpt", 12, 6, 2));
  // A session starts with single samples. One iteration with all samples learns the same and gives the same image.
  const std::atomic<bool> stop{false};
  const auto integrator = make_integrator("erpt");
  Film film(0, 0, 40, 33, {"Combined"});
  integrator->prepare(build(d), 5);
  integrator->run_iteration(film, 12, stop);
  EXPECT_EQ(one, film.resolve("Combined", 1.0f));
}

TEST(EnergyRedistribution, a_scene_without_light_is_black) {
  for (float value : render(grey_room(), "erpt", 2, 1)) EXPECT_TRUE(value == 0.0f || value == 1.0f);
  SceneDescription nothing;
  set_camera(nothing, Vec3(0, -1, 0), Vec3(0), 8, 0.7f);
  for (float value : render(nothing, "erpt", 2, 1)) EXPECT_TRUE(value == 0.0f || value == 1.0f);
}

TEST(PathSeeds, paths_are_taken_in_proportion_to_their_energy) {
  const auto scene = build(kScenes[0].description);
  const PathSpace space(*scene, 0, 0, 12, 12, true);
  PathSeeds seeds(space);
  Sampler sampler(Sampler::Kind::Independent, 3);
  auto path = std::make_unique<Path>();
  // 1 if the path is long, minus the energy share of long paths. 64 equidistant offsets estimate this share with an
  // error of at most 1/64.
  RunningMoments difference;
  for (uint32_t i = 0; i < 800; ++i) {
    sampler.start(i, 0);
    if (!(seeds.sample(sampler) > 0.0)) continue;
    constexpr int kTimes = 64;
    double expected = 0.0;
    for (int k = 0; k < kTimes; ++k) {
      ASSERT_TRUE(seeds.take((k + 0.5) / kTimes, *path));
      EXPECT_GT(path->target, 0.0);
      EXPECT_GT(first_joinable_from_eye(*path), 1);
      expected += double(path->count > 5) / kTimes;
    }
    ASSERT_TRUE(seeds.take(double(sampler.get_1d()), *path));
    difference.add(double(path->count > 5) - expected);
  }
  EXPECT_GT(difference.variance(), 0.0);
  EXPECT_NEAR(difference.mean(), 0.0, 4.0 * std::sqrt(difference.variance_of_mean()));
}

}  // namespace ajar::test_erpt
