// Two techniques render one image: their shares of the work, their mean, and sessions of `auto` that mix.
#include "choice/mixture.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "agreement.h"

namespace ajar::test_mixture {

namespace {

using namespace fixtures;

const std::atomic<bool> kGoOn{false};

SceneDescription small_scene() {
  SceneDescription d = grey_room(12);
  d.lights.push_back(area_lamp(Vec3(0, 0, 0.9f), Vec3(0, 0, -1), 0.3f, 20.0f));
  d.settings.passes = {"Combined", "Halves", "Normal"};
  return d;
}

/// Path tracing and bidirectional path tracing, as a session runs them.
struct Pair {
  std::unique_ptr<Integrator> first = make_integrator("path");
  Film film;
  std::unique_ptr<Mixture> mixture;
  uint64_t done = 0;

  Pair(const std::shared_ptr<const Scene>& scene, double share, uint32_t seed)
      : film(0, 0, scene->settings().width, scene->settings().height, scene->settings().passes) {
    first->prepare(scene, seed);
    auto second = make_integrator("bdpt");
    second->prepare(scene, seed + 1'000'000);
    mixture = std::make_unique<Mixture>(Learned::Second{"bdpt", share, {1.0, 2.0}, {3.0, 1.0}}, std::move(second),
                                        scene->settings());
  }
  void run(int iterations) {
    for (int i = 0; i < iterations; ++i) {
      if (done > 0 && mixture->is_due(*first)) {
        mixture->second().run_iteration(mixture->film(), 1, kGoOn);
        mixture->add_done(1);
      } else {
        first->run_iteration(film, 1, kGoOn);
        ++done;
      }
    }
  }
  std::vector<float> pass(const char* name) const {
    return mixture->of_both(name, film.resolve(name, 1.0f), *first, 1.0f);
  }
};

TEST(Mixture, each_technique_gets_its_share_of_the_work) {
  const auto scene = build(small_scene());
  for (const double share : {0.25, 0.5}) {
    Pair pair(scene, share, 1);
    pair.run(64);
    const double one = double(pair.first->statistics().rays),
                 two = 2.0 * double(pair.mixture->second().statistics().rays);
    EXPECT_NEAR(two / (one + two), share, 0.05);
    EXPECT_EQ(pair.done + pair.mixture->done(), 64u);
  }
}

TEST(Mixture, passes_are_weighted_means_or_those_of_the_first) {
  const auto scene = build(small_scene());
  Pair pair(scene, 0.5, 2);
  EXPECT_TRUE(pair.pass("Combined") == pair.film.resolve("Combined", 1.0f)) << "the second has no samples";
  pair.run(32);
  const std::vector<float> one = pair.film.resolve("Combined", 1.0f),
                           two = pair.mixture->film().resolve("Combined", 1.0f), mean = pair.pass("Combined"),
                           halves = pair.pass("Halves");
  // The weight is the work over the noise: 3 and 1, with nearly equal work.
  const double work = double(pair.first->statistics().rays) / 3.0,
               of_second = 2.0 * double(pair.mixture->second().statistics().rays), w = work / (work + of_second);
  EXPECT_NEAR(w, 0.25, 0.04);
  for (size_t i = 0; i < mean.size(); ++i)
    ASSERT_NEAR(double(mean[i]), w * double(one[i]) + (1.0 - w) * double(two[i]), 1e-5 * (1.0 + double(mean[i])));
  ASSERT_EQ(halves.size(), 12 * mean.size() / 4);
  const std::vector<float> of_two = pair.mixture->film().resolve("Halves", 1.0f);
  for (size_t i = 0; i < halves.size(); ++i)
    ASSERT_TRUE(i % 12 < 6 || halves[i] == of_two[i / 12 * 6 + i % 12 - 6]);
  EXPECT_EQ(pair.pass("Normal"), pair.film.resolve("Normal", 1.0f));

  IntegratorStatistics statistics = pair.first->statistics();
  const uint64_t rays = statistics.rays;
  pair.mixture->add_to(statistics);
  EXPECT_EQ(statistics.rays, rays + pair.mixture->second().statistics().rays);
  Film::SampleCounts counts = pair.film.sample_counts();
  pair.mixture->add_to(counts);
  EXPECT_DOUBLE_EQ(counts.mean, 32.0);
}

TEST(Mixture, the_mean_is_unbiased) {
  const auto scene = build(small_scene());
  RunningMoments of_paths, of_both;
  for (uint32_t seed = 1; seed <= 48; ++seed) {
    Pair pair(scene, 0.4, seed);
    pair.run(24);
    const auto mean = [](const std::vector<float>& image) {
      double sum = 0.0;
      for (size_t i = 0; i < image.size(); ++i) sum += i % 4 == 3 ? 0.0 : double(image[i]);
      return sum / double(image.size());
    };
    of_both.add(mean(pair.pass("Combined")));
    Pair alone(scene, 0.0, 100 + seed);
    alone.run(24);
    of_paths.add(mean(alone.film.resolve("Combined", 1.0f)));
  }
  const double visible = 4.8 * std::sqrt(of_paths.variance_of_mean() + of_both.variance_of_mean()) / of_paths.mean();
  EXPECT_LT(visible, 0.02) << "inconclusive";
  EXPECT_TRUE(statistical::means_agree(of_paths, of_both)) << of_paths.mean() << " " << of_both.mean();
}

TEST(Mixture, not_with_passes_that_have_no_mean) {
  EXPECT_TRUE(can_mix({"Combined", "Halves", "Direct Halves", "Denoising Albedo", "Depth", "CryptoObject00",
                       "AOV Color a", "Combined_key", "Vector"}));
  for (const char* pass : {"DiffDir", "Emit", "VolumeInd", "Shadow Catcher", "Sample Count", "Variance"})
    EXPECT_FALSE(can_mix({"Combined", pass})) << pass;
}

/// Renders a scene in which several techniques are about as good, with `auto` for a denoised image.
struct Auto {
  Session session;
  nlohmann::json statistics;
  std::vector<float> image, halves;

  explicit Auto(std::vector<std::string> passes, int threads = 2, bool keeps_checkpoints = false) {
    SceneDescription d = with(hidden_lamp(), "auto", 256, threads);
    d.settings.width = d.settings.height = 96;
    d.settings.denoised = true;
    d.settings.passes = std::move(passes);
    if (keeps_checkpoints) session.checkpoint();
    session.start(std::move(d));
    EXPECT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.take_error(), "");
    statistics = nlohmann::json::parse(session.statistics_json());
    image = session.snapshot("Combined");
    halves = session.snapshot("Halves");
  }
};

TEST(Mixture, a_denoised_render_mixes_what_the_pilot_cannot_tell_apart) {
  const Auto mixed({"Combined", "Halves"});
  ASSERT_TRUE(mixed.statistics.contains("second_technique")) << mixed.statistics["plan"].dump(1);
  const auto& second = mixed.statistics["second_technique"];
  EXPECT_NE(second["integrator"], mixed.statistics["integrator"]);
  EXPECT_GE(second["share_of_work"], 0.25);
  EXPECT_LE(second["share_of_work"], 0.5);
  EXPECT_GT(second["samples_per_pixel"], 0);
  EXPECT_EQ(mixed.statistics["samples_per_pixel"]["mean"], 256.0) << "of both";
  EXPECT_EQ(mixed.halves.size(), 12u * 96 * 96);
  for (const float v : mixed.halves) ASSERT_TRUE(std::isfinite(v));
  int steps = 0;
  for (const auto& step : mixed.statistics["plan"]) steps += step["step"] == "second technique";
  EXPECT_EQ(steps, 1);
  EXPECT_EQ(Auto({"Combined", "Halves"}, 1).image, mixed.image) << "for any number of threads";
}

TEST(Mixture, checkpoints_and_separated_light_are_those_of_one_technique) {
  const Auto checkpoints({"Combined", "Halves"}, 2, true), parts({"Combined", "Halves", "DiffDir"});
  for (const Auto* one : {&checkpoints, &parts}) {
    EXPECT_FALSE(one->statistics.contains("second_technique"));
    EXPECT_EQ(one->halves.size(), 6u * 96 * 96);
  }
  ASSERT_TRUE(checkpoints.session.checkpoint());
  EXPECT_EQ(checkpoints.session.checkpoint()->samples, 256.0);
}

}  // namespace

}  // namespace ajar::test_mixture
