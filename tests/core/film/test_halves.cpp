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

}  // namespace ajar::test_halves
