// The means of the two halves of a film are independent: their difference has the variance of the image.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "film/film.h"
#include "integrators/integrator.h"
#include "transport_scenes.h"

namespace ajar::test_halves {

namespace {

using namespace fixtures;

struct Variances {
  double of_images = 0.0;  ///< variance of the luminance of a pixel over seeds, mean over the pixels
  double of_halves = 0.0;  ///< the same, from the halves: (A - B)^2 / 4
};

Variances variances_of(const char* integrator_name, int samples, int seeds) {
  SceneDescription d = grey_room();
  d.settings.width = d.settings.height = 24;
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f));
  d.settings.integrator = integrator_name;
  d.settings.photons = 2000;  // enough for a ratio of variances
  const auto scene = build(d);
  const std::atomic<bool> stop{false};
  const auto integrator = make_integrator(integrator_name);
  const size_t pixels = size_t(d.settings.width) * size_t(d.settings.height);
  std::vector<double> sum(pixels), squares(pixels);
  Variances found;
  for (int seed = 0; seed < seeds; ++seed) {
    Film film(0, 0, d.settings.width, d.settings.height, {"Combined", "Halves"});
    integrator->prepare(scene, uint32_t(seed));
    for (int i = 0; i < samples; i += 2) integrator->run_iteration(film, 2, stop);
    const auto image = film.resolve("Combined", 1.0f), halves = film.resolve("Halves", 1.0f);
    for (size_t i = 0; i < pixels; ++i) {
      const double value = double(image[4 * i + 1]);
      sum[i] += value;
      squares[i] += value * value;
      const double difference = double(halves[6 * i + 1]) - double(halves[6 * i + 4]);
      EXPECT_NEAR(0.5 * (double(halves[6 * i + 1]) + double(halves[6 * i + 4])), value, 1e-4 * (1.0 + value));
      found.of_halves += 0.25 * difference * difference / double(pixels) / seeds;
    }
  }
  for (size_t i = 0; i < pixels; ++i)
    found.of_images += (squares[i] - sum[i] * sum[i] / seeds) / (seeds - 1) / double(pixels);
  return found;
}

class HalvesOf : public testing::TestWithParam<const char*> {};

TEST_P(HalvesOf, have_the_variance_of_the_image) {
  const Variances found = variances_of(GetParam(), 8, 24);
  const double ratio = found.of_halves / found.of_images;
  EXPECT_GT(ratio, 0.8);
  // Stratified samples have less variance than two independent halves of them. Chains are not stratified.
  const std::string name = GetParam();
  EXPECT_LT(ratio, name == "erpt" || name == "metropolis" || name == "pmc_pt" ? 1.25 : 3.0);
}

INSTANTIATE_TEST_SUITE_P(All, HalvesOf, testing::Values("path", "bdpt", "erpt", "metropolis", "pmc_pt", "photon_map"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace

// In a diffuse room, direct halves have the light that is left with no bounce after the first surface.
TEST(DirectHalves, have_the_light_of_direct_paths) {
  SceneDescription d = grey_room();
  d.settings.width = d.settings.height = 24;
  add_object(d, cube(), add_diffuse(d, Color(0.2f), Color(2.0f, 1.0f, 0.5f)), moved(Vec3(0.3f, 0.2f, -0.4f), 0.2f));
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f));
  const auto scene = build(d);
  d.settings.bounces.total = 0;
  const auto alone = build(d);
  const std::atomic<bool> stop{false};
  const auto sums_of = [&](const std::shared_ptr<const Scene>& of, const char* name, uint32_t seed) {
    const auto integrator = make_integrator(name);
    Film film(0, 0, d.settings.width, d.settings.height, {"Combined", "Halves", "Direct Halves"});
    integrator->prepare(of, seed);
    integrator->run_iteration(film, 64, stop);
    const auto direct = film.resolve("Direct Halves", 1.0f), halves = film.resolve("Halves", 1.0f);
    double of_direct = 0.0, of_all = 0.0;
    for (size_t i = 0; i < direct.size(); ++i) of_direct += double(direct[i]), of_all += double(halves[i]);
    return std::pair(of_direct, of_all);
  };
  for (const IntegratorInfo& info : integrator_list()) {
    const std::string name = info.name;
    if (info.automatic) continue;
    if (name != "path" && name != "bdpt" && name != "photon_map" && name != "mps") {
      EXPECT_TRUE(std::isnan(sums_of(scene, info.name, 1).first)) << name;
      continue;
    }
    const auto [direct, all] = sums_of(scene, info.name, 1);
    const double expected = sums_of(alone, "path", 2).second;
    EXPECT_NEAR(direct, expected, 0.01 * expected) << name;
    EXPECT_LT(direct, 0.9 * all) << name;
  }
}

// Also at mirrors and in glass, for integrators that know the same classes of paths.
TEST(DirectHalves, of_bidirectional_path_tracing_are_those_of_path_tracing) {
  SceneDescription d = grey_room();
  d.settings.width = d.settings.height = 24;
  add_object(d, sphere(), add_glass(d, 0.0f), moved(Vec3(0.3f, 0.2f, -0.4f), 0.4f));
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f));
  const auto scene = build(d);
  const std::atomic<bool> stop{false};
  double sums[2] = {0.0, 0.0};
  for (int k = 0; k < 2; ++k) {
    const auto integrator = make_integrator(k == 0 ? "path" : "bdpt");
    Film film(0, 0, d.settings.width, d.settings.height, {"Combined", "Halves", "Direct Halves"});
    integrator->prepare(scene, 3);
    integrator->run_iteration(film, 256, stop);
    for (const float v : film.resolve("Direct Halves", 1.0f)) sums[k] += double(v);
  }
  EXPECT_NEAR(sums[0], sums[1], 0.01 * sums[0]);
}

}  // namespace ajar::test_halves
