// Several techniques render one image: their shares of the work, their mean, and sessions of `auto` that mix.
#include "choice/mixture.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "agreement.h"
#include "denoise/open_image_denoise.h"
#include "hint_fixtures.h"

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

/// Path tracing, bidirectional path tracing and energy redistribution, as a session runs them.
struct Several {
  std::unique_ptr<Integrator> first = make_integrator("path");
  Film film;
  std::unique_ptr<Mixture> mixture;

  Several(const std::shared_ptr<const Scene>& scene, std::vector<double> shares, uint32_t seed, double trial_work = 0.0)
      : film(0, 0, scene->settings().width, scene->settings().height, scene->settings().passes) {
    first->prepare(scene, seed);
    const Learned::Mixed::Technique all[] = {{"path", 0.0, 1.0, 3.0}, {"bdpt", 0.0, 2.0, 1.0}, {"erpt", 0.0, 1.5, 2.0}};
    Learned::Mixed choice;
    choice.trial_work = trial_work;
    std::vector<std::unique_ptr<Integrator>> others;
    for (size_t k = 0; k < shares.size(); ++k) {
      choice.techniques.push_back(all[k]);
      choice.techniques.back().share = shares[k];
      if (k == 0) continue;
      others.push_back(make_integrator(all[k].integrator));
      others.back()->prepare(scene, seed + uint32_t(k) * 1'000'000);
    }
    mixture = std::make_unique<Mixture>(std::move(choice), Mixture::Part{*first, film}, std::move(others),
                                        scene->settings());
  }
  /// Iterations of one sample.
  void run(int iterations) {
    for (int i = 0; i < iterations; ++i) {
      Mixture::Part& part = mixture->due();
      part.integrator.run_iteration(part.film, 1, kGoOn);
      mixture->add_done(1);
    }
  }
  double work(size_t k) const {
    return double(mixture->parts()[k].integrator.statistics().rays) * mixture->choice().techniques[k].ray_cost;
  }
  std::vector<float> pass(const char* name) const { return mixture->of_all(name, film.resolve(name, 1.0f), 1.0f); }
};

TEST(Mixture, each_technique_gets_its_share_of_the_work) {
  const auto scene = build(small_scene());
  for (const std::vector<double>& shares : {std::vector{0.75, 0.25}, {0.5, 0.5}, {0.2, 0.3, 0.5}}) {
    Several several(scene, shares, 1);
    several.run(96);
    double all = 0.0;
    uint64_t samples = 0;
    for (size_t k = 0; k < shares.size(); ++k) {
      all += several.work(k);
      samples += several.mixture->parts()[k].done;
    }
    for (size_t k = 0; k < shares.size(); ++k) EXPECT_NEAR(several.work(k) / all, shares[k], 0.05) << k;
    EXPECT_EQ(samples, 96u);
  }
}

TEST(Mixture, passes_are_weighted_means_or_those_of_the_first) {
  const auto scene = build(small_scene());
  Several several(scene, {0.5, 0.5}, 2);
  several.run(1);
  EXPECT_TRUE(several.pass("Combined") == several.film.resolve("Combined", 1.0f)) << "the second has no samples";
  several.run(31);
  const Film& second = several.mixture->parts()[1].film;
  const std::vector<float> one = several.film.resolve("Combined", 1.0f), two = second.resolve("Combined", 1.0f),
                           mean = several.pass("Combined"), halves = several.pass("Halves");
  // The weight is the work over the noise: 3 and 1, with nearly equal work.
  const double w = several.work(0) / 3.0 / (several.work(0) / 3.0 + several.work(1));
  EXPECT_NEAR(w, 0.25, 0.04);
  for (size_t i = 0; i < mean.size(); ++i)
    ASSERT_NEAR(double(mean[i]), w * double(one[i]) + (1.0 - w) * double(two[i]), 1e-5 * (1.0 + double(mean[i])));
  ASSERT_EQ(halves.size(), 12 * mean.size() / 4);
  const std::vector<float> of_two = second.resolve("Halves", 1.0f);
  for (size_t i = 0; i < halves.size(); ++i) ASSERT_TRUE(i % 12 < 6 || halves[i] == of_two[i / 12 * 6 + i % 12 - 6]);
  EXPECT_EQ(several.pass("Normal"), several.film.resolve("Normal", 1.0f));

  IntegratorStatistics statistics = several.first->statistics();
  const uint64_t rays = statistics.rays;
  several.mixture->add_to(statistics);
  EXPECT_EQ(statistics.rays, rays + several.mixture->parts()[1].integrator.statistics().rays);
  Film::SampleCounts counts = several.film.sample_counts();
  several.mixture->add_to(counts);
  EXPECT_DOUBLE_EQ(counts.mean, 32.0);
  EXPECT_GT(several.mixture->film_bytes(), 0u);
  EXPECT_GT(several.mixture->estimated_error().relmse, 0.0);
}

TEST(Mixture, the_mean_is_unbiased) {
  const auto scene = build(small_scene());
  RunningMoments of_paths, of_all;
  for (uint32_t seed = 1; seed <= 80; ++seed) {
    const auto mean = [](const std::vector<float>& image) {
      double sum = 0.0;
      for (size_t i = 0; i < image.size(); ++i) sum += i % 4 == 3 ? 0.0 : double(image[i]);
      return sum / double(image.size());
    };
    Several several(scene, {0.4, 0.3, 0.3}, seed);
    several.run(48);
    of_all.add(mean(several.pass("Combined")));
    Several alone(scene, {1.0}, 100 + seed);
    alone.run(32);
    of_paths.add(mean(alone.pass("Combined")));
  }
  const double visible = 4.8 * std::sqrt(of_paths.variance_of_mean() + of_all.variance_of_mean()) / of_paths.mean();
  EXPECT_LT(visible, 0.02) << "inconclusive";
  EXPECT_TRUE(statistical::means_agree(of_paths, of_all)) << of_paths.mean() << " " << of_all.mean();
}

TEST(Mixture, shares_follow_from_the_errors_of_the_trial) {
  const auto scene = build(small_scene());
  struct Case {
    std::vector<double> errors, shares;  // of path, bdpt, erpt
  };
  const Case cases[] = {{{1e-3, 1e-3, 5e-3}, {0.5, 0.5, 0.0}},
                        {{1.5e-3, 1e-3, 5e-3}, {0.3125, 0.6875, 0.0}},  // the first stays
                        {{9e-3, 1e-3, 5e-3}, {0.2, 0.8, 0.0}},          // also if it is bad
                        {{1e-3, 9e-3, 1.5e-3}, {0.6875, 0.0, 0.3125}},
                        {{1e-3, 9e-3, 5e-3}, {1.0, 0.0, 0.0}},  // one is enough
                        {{}, {0.5, 0.5, 0.0}}};                 // unknown: the two best of the pilot
  for (const Case& c : cases) {
    Several several(scene, {1.0 / 3, 1.0 / 3, 1.0 / 3}, 3, 1.0);
    several.run(9);
    EXPECT_FALSE(several.mixture->trial_ends()) << "too few samples";
    for (int i = 0; i < 40 && !several.mixture->trial_ends(); ++i) several.run(1);  // to the end of a turn
    EXPECT_TRUE(several.mixture->trial_ends());
    IntegratorStatistics before = several.first->statistics(), after = before;
    several.mixture->add_to(before);
    const PlanStep step = several.mixture->share_by(c.errors);
    several.mixture->add_to(after);
    EXPECT_EQ(before.rays, after.rays) << "those of all techniques";
    EXPECT_FALSE(several.mixture->trial_ends()) << "only once";
    EXPECT_TRUE(step.used);
    const auto& techniques = several.mixture->choice().techniques;
    const char* names[] = {"path", "bdpt", "erpt"};
    size_t k = 0;
    for (size_t i = 0; i < 3; ++i) {
      if (!(c.shares[i] > 0.0)) continue;
      ASSERT_LT(k, techniques.size());
      EXPECT_EQ(techniques[k].integrator, names[i]);
      EXPECT_DOUBLE_EQ(techniques[k].share, c.shares[i]) << names[i] << " of case " << &c - cases;
      ++k;
    }
    EXPECT_EQ(k, techniques.size());
    EXPECT_EQ(k, several.mixture->parts().size());
    several.run(8);
    EXPECT_EQ(several.pass("Halves").size(), 6 * k * 12 * 12);
  }
}

TEST(Mixture, not_with_passes_that_have_no_mean) {
  EXPECT_TRUE(can_mix({"Combined", "Halves", "Direct Halves", "Denoising Albedo", "Depth", "CryptoObject00",
                       "AOV Color a", "Combined_key", "Vector"}));
  for (const char* pass : {"DiffDir", "Emit", "VolumeInd", "Shadow Catcher", "Sample Count", "Variance"})
    EXPECT_FALSE(can_mix({"Combined", pass})) << pass;
}

/// Renders a scene in which several techniques are about as good, with `auto` for a denoised image.
struct Auto {
  static constexpr int kSize = 64;
  Session session;
  nlohmann::json statistics;
  std::vector<float> image, halves;

  explicit Auto(std::vector<std::string> passes, int threads = 2, bool keeps_checkpoints = false,
                const char* integrator = "auto") {
    OpenImageDenoise::load(AJAR_STAND_IN_DENOISER);
    SceneDescription d = with(keyhole(false, 0.2f), integrator, 256, threads);
    d.settings.width = d.settings.height = kSize;
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
  ASSERT_TRUE(mixed.statistics.contains("techniques")) << mixed.statistics["plan"].dump(1);
  const auto& techniques = mixed.statistics["techniques"];
  ASSERT_EQ(techniques.size(), 2u) << "after the trial: " << mixed.statistics["plan"].dump(1);
  EXPECT_EQ(techniques[0]["integrator"], mixed.statistics["integrator"]);
  EXPECT_NE(techniques[1]["integrator"], mixed.statistics["integrator"]);
  EXPECT_EQ(mixed.statistics["bias"], "consistent");
  double samples = 0.0;
  for (const auto& technique : techniques) {
    EXPECT_GE(technique["share_of_work"], 0.15);
    samples += double(technique["samples_per_pixel"]);
  }
  // Samples of chains count where they see light directly, not in each pixel.
  EXPECT_LE(double(mixed.statistics["samples_per_pixel"]["mean"]), samples);
  EXPECT_GT(double(mixed.statistics["samples_per_pixel"]["mean"]), 32.0);
  EXPECT_LE(samples, 256.0);
  EXPECT_EQ(mixed.halves.size(), 12u * Auto::kSize * Auto::kSize);
  for (const float v : mixed.halves) ASSERT_TRUE(std::isfinite(v));
  int steps = 0;
  for (const auto& step : mixed.statistics["plan"])
    steps += step["step"] == "several techniques" || step["step"] == "shares of the work";
  EXPECT_EQ(steps, 2);
  EXPECT_EQ(Auto({"Combined", "Halves"}, 1).image, mixed.image) << "for any number of threads";
}

TEST(Mixture, checkpoints_and_separated_light_are_those_of_one_technique) {
  const Auto checkpoints({"Combined", "Halves"}, 2, true), parts({"Combined", "Halves", "DiffDir"});
  for (const Auto* one : {&checkpoints, &parts}) {
    EXPECT_FALSE(one->statistics.contains("techniques"));
    EXPECT_EQ(one->halves.size(), 6u * Auto::kSize * Auto::kSize);
  }
  ASSERT_TRUE(checkpoints.session.checkpoint());
  EXPECT_EQ(checkpoints.session.checkpoint()->samples, checkpoints.statistics["samples_per_pixel"]["mean"]);
}

TEST(Mixture, any_choice_takes_about_the_work_of_the_samples_of_path_tracing) {
  const Auto path({"Combined", "Halves"}, 2, false, "path"), several({"Combined", "Halves"}),
      one({"Combined", "Halves", "DiffDir"});
  EXPECT_EQ(path.statistics["samples_per_pixel"]["mean"], 256.0);
  EXPECT_TRUE(several.statistics.contains("techniques"));
  EXPECT_NE(one.statistics["integrator"], "path");
  for (const Auto* chosen : {&several, &one}) {
    // Rays of other techniques cost 1.3 to 2 times as much.
    const double rays = double(chosen->statistics["rays"]) / double(path.statistics["rays"]);
    EXPECT_GT(rays, 0.4);
    EXPECT_LT(rays, 1.1);
    int steps = 0;
    for (const auto& step : chosen->statistics["plan"]) steps += step["step"] == "samples";
    EXPECT_EQ(steps, 1) << "the plan tells the number";
  }
}

}  // namespace

}  // namespace ajar::test_mixture
