// Every integrator renders every feature of real scenes with the mean of path tracing.
#include "agreement.h"
#include "feature_scenes.h"
#include "gate.h"

namespace ajar::test_features {

using namespace fixtures;

namespace {

const std::vector<TransportScene> kScenes = feature_scenes();
/// For integrators that walk below surfaces and store photons.
const std::vector<TransportScene> kAllScenes = [] {
  std::vector<TransportScene> scenes = feature_scenes();
  // The gate has no time for enough samples of the volume in glass, nor of photons that hair with facets scatters: the
  // facets for the eye are others than those that sampled the photon's direction.
  std::erase_if(scenes, [](const TransportScene& scene) {
    return scene.name == "volume_in_glass" || scene.name == "hair_of_facets" || scene.name == "oval_hair";
  });
  scenes.push_back(subsurface_scene());
  // Few photons keep the tests short; their blur is within the bias that the tests allow.
  for (TransportScene& scene : scenes) scene.description.settings.photons = 1000;
  return scenes;
}();

}  // namespace

class Feature : public ::testing::TestWithParam<size_t> {};
INSTANTIATE_TEST_SUITE_P(In, Feature, ::testing::Range<size_t>(0, kScenes.size()),
                         [](const auto& info) { return kScenes[info.param].name; });

TEST_P(Feature, bidirectional_path_tracing_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 0, 3)) GTEST_SKIP() << kLeftOut;
  expect_agreement(kScenes[GetParam()], "bdpt", 48, int(kScenes.size()));
}
TEST_P(Feature, energy_redistribution_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 1, 3)) GTEST_SKIP() << kLeftOut;
  expect_agreement(kScenes[GetParam()], "erpt", 48, int(kScenes.size()));
}
TEST_P(Feature, metropolis_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 2, 3)) GTEST_SKIP() << kLeftOut;
  expect_agreement(kScenes[GetParam()], "metropolis", 48, int(kScenes.size()));
}
TEST_P(Feature, population_monte_carlo_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 3, 3)) GTEST_SKIP() << kLeftOut;
  expect_agreement(kScenes[GetParam()], "pmc_pt", 48, int(kScenes.size()));
}

// Light enters a surface or not, depending on what the path from the eye has been through.
const std::vector<TransportScene> kSubsurfaceScenes = subsurface_scenes();
class SubsurfaceFeature : public ::testing::TestWithParam<size_t> {
 protected:
  /// In two scenes, one for each rule, the test must be able to see a bias of this size in the mean of the image.
  void expect_mean_of_path_tracing(const char* integrator, int samples, double visible) {
    const TransportScene& scene = kSubsurfaceScenes[GetParam()];
    const bool precise = scene.name == "skin_all_around" || scene.name == "skin_after_diffuse";
    expect_agreement(scene, integrator, samples, int(kSubsurfaceScenes.size()), precise ? visible : 0.0);
  }
};
INSTANTIATE_TEST_SUITE_P(In, SubsurfaceFeature, ::testing::Range<size_t>(0, kSubsurfaceScenes.size()),
                         [](const auto& info) { return kSubsurfaceScenes[info.param].name; });

TEST_P(SubsurfaceFeature, bidirectional_path_tracing_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 0)) GTEST_SKIP() << kLeftOut;
  expect_mean_of_path_tracing("bdpt", 48, 0.02);
}
TEST_P(SubsurfaceFeature, energy_redistribution_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 1)) GTEST_SKIP() << kLeftOut;
  expect_mean_of_path_tracing("erpt", 96, 0.05);
}
TEST_P(SubsurfaceFeature, metropolis_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 2)) GTEST_SKIP() << kLeftOut;
  expect_mean_of_path_tracing("metropolis", 96, 0.05);
}
TEST_P(SubsurfaceFeature, population_monte_carlo_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 3)) GTEST_SKIP() << kLeftOut;
  expect_mean_of_path_tracing("pmc_pt", 96, 0.05);
}

class GatheredFeature : public ::testing::TestWithParam<size_t> {};
INSTANTIATE_TEST_SUITE_P(In, GatheredFeature, ::testing::Range<size_t>(0, kAllScenes.size()),
                         [](const auto& info) { return kAllScenes[info.param].name; });

TEST_P(GatheredFeature, photon_mapping_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 0, 3)) GTEST_SKIP() << kLeftOut;
  expect_agreement_within_bias(kAllScenes[GetParam()], "photon_map", 0.02, 64);
}
TEST_P(GatheredFeature, metropolis_photon_sampling_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 1, 3)) GTEST_SKIP() << kLeftOut;
  expect_agreement_within_bias(kAllScenes[GetParam()], "mps", 0.03, 56);
}
TEST_P(GatheredFeature, irradiance_caching_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 2, 3)) GTEST_SKIP() << kLeftOut;
  expect_agreement_within_bias(kAllScenes[GetParam()], "irradiance_cache", 0.03);
}

namespace {

/// Expects that a short render drops no energy.
void expect_no_dropped_energy(const TransportScene& scene, const std::shared_ptr<const Scene>& built,
                              const char* integrator) {
  const std::atomic<bool> stop{false};
  Film film(0, 0, scene.description.settings.width, scene.description.settings.height, {"Combined"});
  const auto made = make_integrator(integrator);
  made->prepare(built, 1);
  made->run_iteration(film, 2, stop);
  const IntegratorStatistics statistics = made->statistics();
  EXPECT_EQ(film.refused(), 0u) << scene.name << ", " << integrator;
  for (const char* key : {"refused_paths", "refused_photons", "failed_starts"}) {
    const auto found = statistics.extra.find(key);
    EXPECT_TRUE(found == statistics.extra.end() || found->second == 0.0)
        << key << " " << found->second << ", " << scene.name << ", " << integrator;
  }
}

}  // namespace

// Energy that is left out is counted. In ordinary scenes there is none.
TEST(DroppedEnergy, is_zero_in_ordinary_scenes) {
  std::vector<TransportScene> scenes = transport_scenes();
  for (TransportScene& scene : subsurface_scenes()) scenes.push_back(std::move(scene));
  for (size_t i = 0; i < scenes.size(); ++i) {
    const auto built = build(scenes[i].description);
    for (const char* name : {"bdpt", "erpt", "pmc_pt"}) expect_no_dropped_energy(scenes[i], built, name);
    // Their chains start from thousands of seeds, which take longer.
    if (i % 6 == 0)
      for (const char* name : {"metropolis", "mps"}) expect_no_dropped_energy(scenes[i], built, name);
  }
}

// A vertex in the air can be inside the sphere of a lamp, whose light it sees from inside.
TEST(DroppedEnergy, is_zero_where_vertices_of_a_medium_are_inside_a_lamp) {
  for (const TransportScene& scene : kScenes) {
    if (scene.name != "volume_of_the_world") continue;
    const auto built = build(scene.description);
    for (const char* name : {"bdpt", "erpt", "pmc_pt", "metropolis", "mps"})
      expect_no_dropped_energy(scene, built, name);
  }
}

}  // namespace ajar::test_features
