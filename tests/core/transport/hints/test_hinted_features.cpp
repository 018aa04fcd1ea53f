// Light hints in scenes with fog, hair and a moving object, and in denoised images: a good, a useless and a wrong one
// move no mean.
#include "agreement.h"
#include "denoise/denoise.h"
#include "feature_scenes.h"
#include "gate.h"
#include "hint_fixtures.h"

namespace ajar::test_hinted_features {

using namespace fixtures;

namespace {

/// A room that is lit through a wide opening in its floor, so that all techniques converge in a short test. The light hints
/// of keyhole() lead through the opening, stay above it, or are wrong.
SceneDescription opening(const std::string& feature) {
  SceneDescription d = keyhole(false, 0.6f);
  d.lights.back().area_size = Vec2(0.4f);
  if (feature == "fog") {
    add_object(d, textured_cube(), add_medium(d, "ShaderNodeVolumeScatter", Color(0.9f, 0.7f, 0.4f), Vec2(0.3f)),
               moved(Vec3(0.0f), 0.98f));
    d.settings.bounces.volume = 4;
  } else if (feature == "hair") {
    add_object(d, curls(150, StrandShape::Ribbon), add_diffuse(d, Color(0.8f, 0.5f, 0.3f)),
               moved(Vec3(0.2f, 0.2f, -0.3f), 1.2f));
  } else {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)));
    move_instance(d, d.instances.size() - 1, moved(Vec3(-0.5f, 0.3f, -0.4f), 0.4f),
                  moved(Vec3(0.5f, 0.3f, 0.0f), 0.4f));
  }
  return d;
}

/// Moments over independent seeds of the mean of the denoised image. The denoiser is a mean over 3 x 3 pixels.
RunningMoments denoised_whole(SceneDescription d, const std::string& integrator, int samples, int seeds,
                              uint32_t first_seed) {
  d.settings.denoised = true;
  d.settings.passes = {"Combined", "Halves"};
  Renders renders(with(std::move(d), integrator, samples));
  const int width = renders.width();
  RunningMoments moments;
  for (int seed = 0; seed < seeds; ++seed) {
    const std::vector<float> image = rgb_of(renders.combined(first_seed + uint32_t(seed)));
    const int height = int(image.size()) / (3 * width);
    const auto blur = [&](std::vector<float> noisy) {
      std::vector<float> scratch;
      window_mean(noisy, {width, height, 3}, 1, scratch);
      return noisy;
    };
    const Denoised result = denoise(image, renders.pass("Halves"), width, height, blur);
    EXPECT_FALSE(result.error.empty()) << "no halves";
    double sum = 0.0;
    for (const float value : result.image) sum += double(value);
    moments.add(sum / double(result.image.size()));
  }
  return moments;
}

/// `render(d, first_seed)`: moments of the scene with a set of hints. `visible`: relative bias that the test must be able
/// to see. All `tests` tests together have the level 0.01.
template <class Render>
void expect_hints_move_no_mean(const SceneDescription& plain, const RunningMoments& expected, double visible, int tests,
                               Render&& render) {
  std::vector<HintDescription> bad = kUseless;
  bad.insert(bad.end(), kWrong.begin(), kWrong.end());
  const std::pair<const char*, std::vector<HintDescription>> sets[] = {{"good", kGood}, {"useless and wrong", bad}};
  uint32_t first_seed = 1000;
  for (const auto& [name, hints] : sets) {
    SceneDescription hinted = plain;
    hinted.hints = hints;
    const RunningMoments found = render(hinted, first_seed += 1000);
    const double power = 4.8 * std::sqrt(expected.variance_of_mean() + found.variance_of_mean()) / expected.mean();
    EXPECT_LT(power, visible) << name << ": inconclusive";
    EXPECT_TRUE(statistical::means_agree(expected, found, {0.01, tests}))
        << name << ": " << found.mean() / expected.mean();
  }
}

}  // namespace

/// `visible`: relative bias that the test must be able to see. Energies of erpt vary most, so its precision would cost
/// most. The gate tests each feature and each integrator once.
struct Case {
  const char *feature, *integrator;
  int samples, seeds;
  double visible;
  bool in_gate = false;
};
constexpr Case kCases[] = {{"fog", "bdpt", 48, 16, 0.02, true},  {"hair", "bdpt", 48, 24, 0.02},
                           {"moving", "bdpt", 48, 16, 0.02},     {"fog", "metropolis", 32, 64, 0.02},
                           {"hair", "metropolis", 32, 64, 0.02}, {"moving", "metropolis", 48, 48, 0.02, true},
                           {"fog", "erpt", 384, 16, 0.05},       {"hair", "erpt", 384, 16, 0.05, true},
                           {"moving", "erpt", 384, 16, 0.05}};
constexpr int kTests = 2 * int(std::size(kCases));

class HintsWith : public ::testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(In, HintsWith, ::testing::ValuesIn(kCases), [](const auto& info) {
  return std::string(info.param.feature) + "_" + info.param.integrator;
});

TEST_P(HintsWith, move_no_mean) {
  const auto& [feature, integrator, samples, seeds, visible, in_gate] = GetParam();
  if (!in_gate && gate_only()) GTEST_SKIP() << kLeftOut;
  const SceneDescription plain = opening(feature);
  const RunningMoments& expected = once(plain, [&] { return whole(plain, "bdpt", 96, 24, 100); });
  expect_hints_move_no_mean(plain, expected, visible, kTests, [&](const SceneDescription& d, uint32_t first_seed) {
    return whole(d, integrator, samples, seeds, first_seed);
  });
}

/// Weights of the planes follow the halves of the samples. Hints that learn from both halves must not move the result.
/// `visible`: as above. The renders without denoising have the same hints with a smaller one.
struct DenoisedCase {
  const char* integrator;
  int samples, seeds;
  double visible;
};
class HintsDenoised : public ::testing::TestWithParam<DenoisedCase> {};
INSTANTIATE_TEST_SUITE_P(By, HintsDenoised,
                         ::testing::Values(DenoisedCase{"bdpt", 16, 24, 0.02}, DenoisedCase{"metropolis", 24, 28, 0.04},
                                           DenoisedCase{"photon_map", 6, 16, 0.05}),
                         [](const auto& info) { return std::string(info.param.integrator); });

TEST_P(HintsDenoised, move_no_mean) {
  const auto& [integrator, samples, seeds, visible] = GetParam();
  if (std::string(integrator) == "metropolis" && gate_only()) GTEST_SKIP() << kLeftOut;
  const SceneDescription plain = opening("moving");
  const RunningMoments expected = denoised_whole(plain, integrator, samples, seeds, 100);
  expect_hints_move_no_mean(plain, expected, visible, 6, [&](const SceneDescription& d, uint32_t first_seed) {
    return denoised_whole(d, integrator, samples, seeds, first_seed);
  });
}

}  // namespace ajar::test_hinted_features
