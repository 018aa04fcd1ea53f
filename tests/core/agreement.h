// Tests that an integrator renders images of the same mean as the path tracer, over independent replicates.
#pragma once

#include <gtest/gtest.h>

#include "once.h"
#include "renders.h"
#include "statistical.h"
#include "transport_scenes.h"

namespace ajar::fixtures {

/// Means of 3 x 3 blocks of the image, for three colours and alpha, then the mean of the whole image and all colours.
/// The moments are over independent seeds.
inline constexpr int kBlocks = 3, kValues = kBlocks * kBlocks * 4;
inline std::vector<RunningMoments> blocks(SceneDescription d, const std::string& integrator, int samples, int seeds,
                                          uint32_t first_seed) {
  Renders renders(with(std::move(d), integrator, samples));
  std::vector<RunningMoments> moments(kValues + 1);
  const int size = renders.width();
  for (int seed = 0; seed < seeds; ++seed) {
    const auto image = renders.combined(first_seed + uint32_t(seed));
    std::vector<double> sums(kValues, 0.0);
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x)
        for (int c = 0; c < 4; ++c)
          sums[size_t(((y * kBlocks / size) * kBlocks + x * kBlocks / size) * 4 + c)] += double(
              image[size_t((y * size + x) * 4 + c)]);
    double whole = 0.0;
    for (int i = 0; i < kValues; ++i) {
      moments[size_t(i)].add(sums[size_t(i)] * kBlocks * kBlocks / (size * size));
      if (i % 4 != 3) whole += sums[size_t(i)] / (3.0 * size * size);
    }
    moments[kValues].add(whole);
  }
  return moments;
}

/// The blocks of this scene by path tracing. The number of samples decides the number of seeds.
inline const std::vector<RunningMoments>& reference(SceneDescription d, int samples, int seeds) {
  d.settings.photons = RenderSettings{}.photons;  // path tracing uses none
  d.settings.samples = samples;
  return once(d, [&] { return blocks(d, "path", samples, seeds, 100); });
}

/// Welch's tests of all blocks. All `tests` calls together have the level 0.01. With `visible`, the mean of the whole
/// image is tested too, and the test fails as inconclusive if it could not see a relative bias of this size: the limit
/// is that of the level (about 3.5 standard errors) and of a power of 90 % (1.3 standard errors).
inline void expect_agreement(const TransportScene& scene, const std::string& integrator, int samples, int tests,
                             double visible = 0.0, int samples_of_reference = 64) {
  const auto& expected = reference(scene.description, samples_of_reference, 16);
  const auto actual = blocks(scene.description, integrator, samples, 16, 200);
  const RunningMoments &whole = expected[kValues], &found = actual[kValues];
  const double power = 4.8 * std::sqrt(whole.variance_of_mean() + found.variance_of_mean()) / std::abs(whole.mean());
  ::testing::Test::RecordProperty("visible_bias_of_" + integrator, std::to_string(power));
  if (visible > 0.0) {
    EXPECT_LT(power, visible) << "inconclusive";
    EXPECT_TRUE(statistical::means_agree(whole, found, {0.01, tests}))
        << "path " << whole.mean() << ", " << integrator << " " << found.mean();
  }
  for (int i = 0; i < kValues; ++i) {
    if (i % 4 == 3 && std::abs(expected[size_t(i)].mean() - actual[size_t(i)].mean()) < 1e-5)
      continue;  // alpha differs by rounding
    EXPECT_TRUE(statistical::means_agree(expected[size_t(i)], actual[size_t(i)], {0.01, kValues * tests}))
        << "block " << i / 4 << " channel " << i % 4 << ": path " << expected[size_t(i)].mean() << ", " << integrator
        << " " << actual[size_t(i)].mean();
  }
}

/// The mean of the image agrees with that of path tracing within `bias` (relative, of density estimates and caches) and
/// four standard errors. Fails as inconclusive if the standard error exceeds 0.8 %: a bias of `bias` + 3.2 % would show.
inline void expect_agreement_within_bias(const TransportScene& scene, const std::string& integrator, double bias,
                                         int samples = 48) {
  const auto& expected = reference(scene.description, 256, 8);
  const auto actual = blocks(scene.description, integrator, samples, 8, 200);
  double sum_expected = 0.0, sum_actual = 0.0, variance = 0.0;
  for (size_t i = 0; i < size_t(kValues); ++i) {
    if (i % 4 == 3) continue;
    sum_expected += expected[i].mean();
    sum_actual += actual[i].mean();
    variance += expected[i].variance_of_mean() + actual[i].variance_of_mean();
  }
  const double error = std::sqrt(variance) / std::abs(sum_expected);
  EXPECT_LT(error, 0.008) << "inconclusive";
  EXPECT_NEAR(sum_actual / sum_expected, 1.0, bias + 4.0 * error);
}

/// Moments over independent seeds of the mean of all pixels and colours. The integrator renders `samples` samples in
/// one iteration.
inline RunningMoments whole(const SceneDescription& d, const std::string& name, int samples, int seeds,
                            uint32_t first_seed) {
  const auto scene = build(d);
  const std::atomic<bool> stop{false};
  const auto integrator = make_integrator(name);
  RunningMoments moments;
  for (int seed = 0; seed < seeds; ++seed) {
    Film film(0, 0, d.settings.width, d.settings.height, {"Combined"});
    integrator->prepare(scene, first_seed + uint32_t(seed));
    integrator->run_iteration(film, samples, stop);
    double sum = 0.0;
    const auto image = film.resolve("Combined", 1.0f);
    for (size_t i = 0; i < image.size(); ++i)
      if (i % 4 != 3) sum += double(image[i]);
    moments.add(sum / double(image.size()));
  }
  return moments;
}

}  // namespace ajar::fixtures
