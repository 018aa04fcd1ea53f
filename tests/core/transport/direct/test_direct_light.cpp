#include <gtest/gtest.h>

#include "integrators/integrator.h"
#include "renders.h"
#include "statistical.h"
#include "transport/direct/direct_light.h"
#include "transport/direct/light_cut_cache.h"
#include "transport/direct/light_groups.h"
#include "transport/direct/share_cache.h"

namespace ajar::test_direct_light {

using namespace fixtures;

namespace {

LightDescription area_light(Vec3 position, float watts, float size, bool downwards = true) {
  LightDescription light;
  light.name = "Area";
  light.kind = LightKind::Area;
  light.energy = watts;
  light.area_size = Vec2(size);
  const float z = downwards ? 1.0f : -1.0f;  // area lamps emit along their local -z
  light.world_from_light = rows(Mat4(Vec4(1, 0, 0, 0), Vec4(0, z, 0, 0), Vec4(0, 0, z, 0), Vec4(position, 1)));
  return light;
}

int add_glossy(SceneDescription& d, Color color, float roughness) {
  MaterialDescription material;
  material.name = "Glossy";
  material.graph.nodes.push_back(closure_node("ShaderNodeBsdfGlossy", color));
  material.graph.nodes.back().inputs.push_back({"Roughness", {}, Vec4(roughness)});
  material.graph.surface = {0, "BSDF"};
  d.materials.push_back(material);
  return int(d.materials.size()) - 1;
}

Mat4 at(Vec3 position) { return Mat4(Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(position, 1)); }

/// Lights of different types: partly occluded, completely occluded, facing away, a point light, an emissive mesh and a
/// world.
SceneDescription assorted_lights(bool glossy) {
  SceneDescription d;
  add_object(d, plane(4.0f), glossy ? add_glossy(d, Color(0.8f), 0.3f) : add_diffuse(d, Color(0.8f)));
  add_object(d, plane(0.4f), add_diffuse(d, Color(0.5f)), at(Vec3(0.2f, 0, 1.0f)));
  d.lights.push_back(area_light(Vec3(0, 0, 2), 50.0f, 1.0f));
  d.lights.push_back(area_light(Vec3(-1.5f, 0.5f, 1.2f), 20.0f, 0.5f));
  d.lights.push_back(area_light(Vec3(1.5f, 0.5f, 1.2f), 30.0f, 0.5f, false));
  d.lights.push_back(point_light(Vec3(1, -1, 1), 10.0f));
  add_object(d, plane(0.2f), add_diffuse(d, Color(0.0f), Color(2.0f, 1.0f, 0.5f)), at(Vec3(-0.6f, -0.6f, 0.8f)));
  set_world(d, Color(0.1f, 0.15f, 0.2f));
  set_camera(d, Vec3(0, -1.5f, 0.6f), Vec3(0, 0, 0), 6);
  d.settings.bounces.total = 0;
  return d;
}

SceneDescription with(SceneDescription d, DirectMethod method, int direct_samples, int samples, int threads = 1) {
  d.settings.direct = method;
  d.settings.direct_samples = direct_samples;
  d.settings.samples = samples;
  d.settings.threads = threads;
  return d;
}
std::vector<float> render(SceneDescription d, DirectMethod method, int direct_samples, int samples, uint32_t seed,
                          int threads = 1) {
  return Renders(with(std::move(d), method, direct_samples, samples, threads)).combined(seed);
}

/// Mean luminance of the image over independent seeds, and the summed variance of its pixels.
struct Replicates {
  RunningMoments mean;
  double variance = 0.0;
};
Replicates replicate(SceneDescription d, DirectMethod method, int direct_samples, int samples, int seeds) {
  Renders renders(with(std::move(d), method, direct_samples, samples));
  Replicates r;
  std::vector<RunningMoments> pixels;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto image = renders.combined(uint32_t(seed) * 7919u + uint32_t(direct_samples));
    pixels.resize(image.size() / 4);
    double sum = 0.0;
    for (size_t i = 0; i < pixels.size(); ++i) {
      const double y = double(luminance(Color(image[4 * i], image[4 * i + 1], image[4 * i + 2])));
      pixels[i].add(y);
      sum += y;
    }
    r.mean.add(sum / double(pixels.size()));
  }
  for (const RunningMoments& pixel : pixels) r.variance += pixel.variance();
  return r;
}

constexpr int kSeeds = 200;

const RunningMoments& truth(bool glossy) {
  static const RunningMoments diffuse = replicate(assorted_lights(false), DirectMethod::Mis, 1, 64, kSeeds).mean;
  static const RunningMoments gloss = replicate(assorted_lights(true), DirectMethod::Mis, 1, 64, kSeeds).mean;
  return glossy ? gloss : diffuse;
}

}  // namespace

// ---- The unbiased methods with few samples ------------------------------------------------------

class DirectMethods : public ::testing::TestWithParam<DirectMethod> {};

TEST_P(DirectMethods, have_the_same_mean_with_few_samples) {
  for (bool glossy : {false, true}) {
    for (int direct_samples : {1, 3, 12}) {
      const Replicates r = replicate(assorted_lights(glossy), GetParam(), direct_samples, 3, kSeeds);
      EXPECT_TRUE(statistical::means_agree(r.mean, truth(glossy), {0.01, 66}))
          << name_of(GetParam()) << ", " << direct_samples << " samples, glossy " << glossy;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Unbiased, DirectMethods,
                         ::testing::Values(DirectMethod::Mis, DirectMethod::MisBalance, DirectMethod::Bsdf,
                                           DirectMethod::Ris, DirectMethod::Correlated, DirectMethod::PmcHi,
                                           DirectMethod::PmcHiPaper, DirectMethod::Ocv, DirectMethod::OcvProgressive));

/// A ceiling that is lit by a spot light and, with `two`, by a point light. The spot points away from the centre of the
/// scene.
SceneDescription spot_from_the_centre(bool two) {
  SceneDescription d;
  add_object(d, plane(2.0f), add_diffuse(d, Color(0.5f)));
  add_object(d, plane(2.0f), add_diffuse(d, Color(0.8f)), at(Vec3(0, 0, 1.5f)));
  LightDescription spot = point_light(Vec3(0), 20.0f);
  spot.kind = LightKind::Spot;
  spot.spot_angle = 2.0f;
  spot.world_from_light = area_light(Vec3(0, 0, 1.0f), 1.0f, 1.0f, false).world_from_light;
  d.lights.push_back(spot);
  if (two) d.lights.push_back(point_light(Vec3(1, -1, 1), 10.0f));
  set_camera(d, Vec3(0, -0.8f, 0.2f), Vec3(0, 0, 1.5f), 6);
  d.settings.bounces.total = 0;
  return d;
}

TEST(DirectLight, groups_that_do_not_reach_the_centre_of_the_scene_are_sampled) {
  for (const bool two : {false, true}) {
    const SceneDescription d = spot_from_the_centre(two);
    const RunningMoments expected = replicate(d, DirectMethod::Mis, 1, 64, kSeeds).mean;
    EXPECT_GT(expected.mean(), 0.1);
    for (DirectMethod method : {DirectMethod::Correlated, DirectMethod::Ocv})
      EXPECT_TRUE(statistical::means_agree(replicate(d, method, 3, 3, kSeeds).mean, expected, {0.01, 4}))
          << name_of(method) << ", " << (two ? "two lamps" : "one lamp");
  }
}

TEST(DirectLight, light_sampling_alone_has_the_same_mean) {
  const Replicates r = replicate(assorted_lights(false), DirectMethod::Light, 4, 3, kSeeds);
  EXPECT_TRUE(statistical::means_agree(r.mean, truth(false), {0.01, 66}));
}

TEST(DirectLight, smooth_light_of_lamps_has_hardly_more_noise_than_light_samples_alone) {
  // Samples of the lamp are stratified and nearly equal. BSDF samples that hit it must not add more noise than these
  // have. Measured in images of 48 pixels: 1.0 and 1.1 times; with the plain power heuristic 5.7 and 5.8.
  for (const float size : {1.0f, 6.0f}) {
    SceneDescription d;
    add_object(d, plane(10.0f), add_diffuse(d, Color(0.8f)));
    d.lights.push_back(area_light(Vec3(0, 0, 2), 50.0f, size));
    set_camera(d, Vec3(0, -1.0f, 1.0f), Vec3(0, 0, 0), 16);
    d.settings.bounces.total = 0;
    const Replicates both = replicate(d, DirectMethod::Mis, 1, 16, 12),
                     light = replicate(d, DirectMethod::Light, 1, 16, 12);
    EXPECT_TRUE(statistical::means_agree(both.mean, light.mean, {0.005}));
    EXPECT_LT(both.variance, 2.0 * light.variance) << size;
  }
}

// ---- Learning ------------------------------------------------------------------------------------

namespace {

/// Lamps with nine tenths of the power, or more, are occluded.
SceneDescription hidden_lights(int size = 16, float hidden_power = 300.0f) {
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.8f)));
  for (int i = 0; i < 3; ++i) {
    d.lights.push_back(area_light(Vec3(float(i) - 1.0f, 2.0f, 2.0f), hidden_power, 0.4f));
    add_object(d, plane(0.5f), add_diffuse(d, Color(0.5f)), at(Vec3(float(i) - 1.0f, 2.0f, 1.9f)));
  }
  d.lights.push_back(area_light(Vec3(0, 0, 1.5f), 100.0f, 0.5f));
  set_camera(d, Vec3(0, -1.0f, 1.0f), Vec3(0, 0, 0), size, 0.3f);
  d.settings.bounces.total = 0;
  return d;
}

}  // namespace

TEST(DirectLight, learning_which_lights_are_occluded_lowers_the_variance) {
  const Replicates plain = replicate(hidden_lights(48, 3000.0f), DirectMethod::Mis, 1, 8, 12),
                   learned = replicate(hidden_lights(48, 3000.0f), DirectMethod::PmcHi, 1, 8, 12);
  EXPECT_TRUE(statistical::means_agree(plain.mean, learned.mean, {0.01}));
  EXPECT_LT(learned.variance, 0.6 * plain.variance);
}

TEST(DirectLight, learning_finds_the_few_lights_that_are_not_occluded) {
  // 200 lamps above the floor. A large plate occludes the nearest ones, so that the light comes from lamps beyond its
  // edge.
  SceneDescription d;
  add_object(d, plane(6.0f), add_diffuse(d, Color(0.8f)));
  const int grey = add_diffuse(d, Color(0.5f));
  for (int i = 0; i < 200; ++i) {
    const float x = 0.3f * float(i % 20) - 3.0f, y = 0.3f * float(i / 20) - 1.5f;
    d.lights.push_back(point_light(Vec3(x, y, 1.0f), 2.0f));
  }
  add_object(d, plane(3.0f), grey, at(Vec3(1.6f, 0, 0.9f)));
  set_camera(d, Vec3(0, -1.0f, 0.8f), Vec3(0, 0, 0), 64, 0.3f);
  d.settings.bounces.total = 0;
  d.settings.seconds =
      1000.0;  // not limited to few samples, so that each iteration of the pilot takes a sample of every pixel
  const Replicates plain = replicate(d, DirectMethod::Mis, 1, 8, 12),
                   learned = replicate(d, DirectMethod::PmcHi, 1, 8, 12),
                   many = replicate(d, DirectMethod::PmcHi, 4, 4, 12);
  EXPECT_TRUE(statistical::means_agree(plain.mean, learned.mean, {0.01}));
  EXPECT_TRUE(statistical::means_agree(plain.mean, many.mean, {0.01}));
  // Measured: 0.42. With the plate 0.8 m further away, which leaves the light of nearer lamps, 0.87: the tree alone chooses
  // among these well.
  EXPECT_LT(learned.variance, 0.6 * plain.variance);
}

TEST(DirectLight, passes_show_the_shares_of_the_lights) {
  // Lamps in two clusters, one of which is occluded; and two lamps.
  SceneDescription many;
  add_object(many, plane(6.0f), add_diffuse(many, Color(0.8f)));
  for (int i = 0; i < 100; ++i)
    many.lights.push_back(
        point_light(Vec3((i % 2 ? 2.0f : -2.0f) + 0.03f * float(i % 10), 0.03f * float(i / 10), 1.0f), 2.0f));
  add_object(many, plane(1.5f), add_diffuse(many, Color(0.5f)), at(Vec3(2.4f, 0, 0.8f)));
  SceneDescription two = hidden_lights();
  two.lights.erase(two.lights.begin() + 1, two.lights.begin() + 3);
  for (SceneDescription* d : {&many, &two}) {
    set_camera(*d, Vec3(0, -1.0f, 1.0f), Vec3(0, 0, 0), 16, 0.3f);
    d->settings.bounces.total = 0;
    d->settings.passes = {"Combined", "Share Light 1", "Share Light 2"};
    d->settings.direct = DirectMethod::PmcHi;
    const auto shares = [&](int samples) {  // mean shares of the first and the second over the image
      d->settings.samples = samples;
      Session session;
      session.start(*d);
      EXPECT_TRUE(session.wait(kHang));
      const auto first = session.snapshot("Share Light 1"), second = session.snapshot("Share Light 2");
      std::array<double, 2> sums{};
      for (size_t i = 0; i < first.size(); ++i) {
        EXPECT_NEAR(first[i] + second[i], 1.0f, 1e-4f);
        sums[0] += double(first[i]) / double(first.size());
        sums[1] += double(second[i]) / double(first.size());
      }
      return sums;
    };
    const auto learned = shares(64);
    const double dark = std::min(learned[0], learned[1]);
    EXPECT_LT(dark, 0.35);  // the share of the occluded one
    EXPECT_GT(dark, 0.02);  // but not less than its floor
  }
}

TEST(DirectLight, the_pilot_takes_a_small_share_of_the_samples) {
  const std::atomic<bool> go{false};
  const auto rendered = [&](DirectMethod method, int direct_samples, int samples, Film& film) {
    SceneDescription d = hidden_lights();
    d.settings.direct = method;
    d.settings.direct_samples = direct_samples;
    d.settings.samples = samples;
    const auto integrator = make_integrator("path");
    integrator->prepare(build(std::move(d)), 1);
    integrator->run_iteration(film, samples, go);
    return integrator->statistics();
  };
  for (int direct_samples : {1, 8}) {
    for (int samples : {2, 4, 16, 64}) {
      Film film(0, 0, 16, 16, {"Combined"}), plain(0, 0, 16, 16, {"Combined"});
      IntegratorStatistics statistics = rendered(DirectMethod::PmcHi, direct_samples, samples, film);
      const double pilot = statistics.extra["pilot_rays"];
      EXPECT_LT(pilot, 0.1 * double(statistics.rays)) << samples << " samples";
      EXPECT_EQ(pilot > 0.0, samples > 2) << samples << " samples";
      if (samples > 2) continue;
      rendered(DirectMethod::Mis, direct_samples, samples, plain);
      EXPECT_EQ(film.resolve("Combined", 1.0f), plain.resolve("Combined", 1.0f));
    }
  }
}

TEST(DirectLight, only_the_published_control_variates_are_listed_as_biased_and_are_biased) {
  for (const Choice<DirectMethod>& choice : choices<DirectMethod>().all)
    EXPECT_EQ(choice.biased, choice.value == DirectMethod::OcvPaper);
  // Three of four lights are occluded, so that all their samples are zero.
  SceneDescription d = hidden_lights();
  const Replicates biased = replicate(d, DirectMethod::OcvPaper, 8, 4, kSeeds),
                   cross_fitted = replicate(d, DirectMethod::Ocv, 8, 4, kSeeds),
                   mis = replicate(d, DirectMethod::Mis, 1, 64, kSeeds);
  EXPECT_TRUE(statistical::means_agree(cross_fitted.mean, mis.mean, {0.01}));
  EXPECT_FALSE(statistical::means_agree(biased.mean, mis.mean, {0.001}));
}

TEST(DirectLight, images_of_learning_methods_do_not_depend_on_threads) {
  for (DirectMethod method : {DirectMethod::PmcHi, DirectMethod::OcvProgressive, DirectMethod::PmcHiPaper}) {
    for (int direct_samples : {1, 8}) {
      const auto one = render(assorted_lights(true), method, direct_samples, 9, 5, 1),
                 three = render(assorted_lights(true), method, direct_samples, 9, 5, 3);
      EXPECT_EQ(one, three) << name_of(method);
    }
  }
}

// ---- Groups and caches -------------------------------------------------------------------------

TEST(LightGroups, every_light_with_power_is_in_one_of_few_groups) {
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.8f)));
  for (int i = 0; i < 200; ++i)
    d.lights.push_back(point_light(Vec3(float(i % 20), float(i / 20), 1.0f), 1.0f + float(i % 7)));
  set_world(d, Color(0.1f));
  set_camera(d, Vec3(0, -1, 1), Vec3(0), 4);
  const auto scene = build(std::move(d));
  const LightGroups groups(scene->lights(), 16, scene->center());
  EXPECT_LE(groups.size(), 16);
  EXPECT_GE(groups.size(), 15);
  float prior = 0.0f;
  std::vector<float> mass(size_t(groups.size()), 0.0f);
  for (uint32_t light = 0; light < scene->lights().size(); ++light) {
    // A world without structure is sampled by the BSDF only.
    if (!(scene->lights().choice_pmf(scene->center(), Vec3(0.0f), light) > 0.0f)) continue;
    ASSERT_GE(groups.group_of(light), 0);
    mass[size_t(groups.group_of(light))] += groups.pmf_in_group(light);
  }
  for (int g = 0; g < groups.size(); ++g) {
    EXPECT_NEAR(mass[size_t(g)], 1.0f, 1e-4f);
    prior += groups.prior(g);
  }
  EXPECT_NEAR(prior, 1.0f, 1e-4f);
}

namespace {

SceneDescription many_points_and_suns(int points, int suns) {
  SceneDescription d;
  add_object(d, plane(20.0f), add_diffuse(d, Color(0.8f)));
  for (int i = 0; i < points; ++i)
    d.lights.push_back(point_light(Vec3(float(i % 20), float(i / 20), 1.0f), 1.0f + float(i % 7)));
  for (int i = 0; i < suns; ++i) {
    d.lights.push_back(area_light(Vec3(0.0f), 1.0f + float(i), 0.0f));
    d.lights.back().kind = LightKind::Sun;
  }
  set_camera(d, Vec3(0, -1, 1), Vec3(0), 4);
  return d;
}

/// A cell of the cache that has learned from samples. Only those of the light `bright` are not black.
struct LearnedCell {
  std::shared_ptr<const Scene> scene;
  LightCutCache cache;
  uint32_t cell;
  Vec3 p{3.0f, 2.0f, 0.0f}, n{0, 0, 1};
  LearnedCell(int points, int suns, uint32_t bright)
      : scene(build(many_points_and_suns(points, suns))), cache(scene->lights(), Vec3(0, -1, 1), 0.1f, 1.0f) {
    const uint64_t key = cache.key(p, n, 0, 0);
    cell = cache.cell(key);
    EXPECT_EQ(cell, LightCutCache::kNone);
    cache.publish();
    cell = cache.cell(key);
    Pcg32 rng(7);
    while (cache.learning()) {
      for (int i = 0; i < 2000; ++i) {
        const auto choice = cache.choose(cell, p, n, rng.next_float());
        cache.record(cell, choice, choice.choice.light == bright ? 1.0f / choice.choice.pmf : 0.0f);
      }
      cache.publish();
    }
  }
};

}  // namespace

TEST(LightCutCache, every_light_is_chosen_with_the_probability_it_reports) {
  for (auto [points, suns] : {std::pair{3, 0}, {300, 0}, {300, 2}, {50, 12}, {0, 12}}) {
    LearnedCell learned(points, suns, 5);
    const size_t lights = learned.scene->lights().size();
    std::vector<int> counts(lights, 0);
    constexpr int kDraws = 400000;
    // The choice inverts one random number. The counts of equidistant numbers are exact up to one at each end of an
    // interval.
    for (int i = 0; i < kDraws; ++i) {
      const auto choice = learned.cache.choose(learned.cell, learned.p, learned.n, (float(i) + 0.5f) / float(kDraws))
                              .choice;
      ++counts[choice.light];
      if (i % 97 == 0) {
        EXPECT_NEAR(choice.pmf, learned.cache.pmf(learned.cell, learned.p, learned.n, choice.light),
                    1e-5f * choice.pmf);
      }
    }
    double sum = 0.0;
    for (uint32_t light = 0; light < lights; ++light) {
      const float pmf = learned.cache.pmf(learned.cell, learned.p, learned.n, light);
      EXPECT_GT(pmf, 0.0f) << light;
      EXPECT_NEAR(double(counts[light]), double(pmf) * kDraws, 2.5 + 1e-4 * double(pmf) * kDraws)
          << light << " of " << points << " and " << suns;
      sum += double(pmf);
    }
    EXPECT_NEAR(sum, 1.0, 1e-4);
  }
}

TEST(LightCutCache, shares_grow_for_lights_that_contribute_and_stay_above_their_floors) {
  // Light 47 is 2.2 m away, and the tree rarely chooses it.
  LearnedCell learned(300, 2, 47);
  const float before = learned.scene->lights().choice_pmf(learned.p, learned.n, 47);
  EXPECT_GT(learned.cache.pmf(learned.cell, learned.p, learned.n, 47), 5.0f * before);
  float sum = 0.0f, floors = 0.0f;
  for (int k = 0; k < learned.cache.branches(learned.cell); ++k) {
    EXPECT_GE(learned.cache.share(learned.cell, k), 0.99f * learned.cache.floor(learned.cell, k));
    EXPECT_GT(learned.cache.floor(learned.cell, k), 0.0f);
    sum += learned.cache.share(learned.cell, k);
    floors += learned.cache.floor(learned.cell, k);
  }
  EXPECT_NEAR(sum, 1.0f, 1e-5f);
  EXPECT_NEAR(floors, 0.2f, 1e-3f);
}

TEST(LightCutCache, points_without_a_cell_choose_as_the_tree_does) {
  LearnedCell learned(300, 2, 47);
  const uint32_t other = learned.cache.cell(learned.cache.key(Vec3(-3, 7, 2), Vec3(0, 0, 1), 3, 0));
  EXPECT_EQ(other, LightCutCache::kNone);
  for (float u : {0.1f, 0.5f, 0.9f}) {
    const auto a = learned.cache.choose(other, learned.p, learned.n, u).choice,
               b = learned.scene->lights().choose(learned.p, learned.n, u);
    EXPECT_EQ(a.light, b.light);
    EXPECT_EQ(a.pmf, b.pmf);
  }
}

TEST(ShareCache, learns_the_optimum_of_components_that_do_not_overlap) {
  // The conditional root-mean-square contributions are 1 and 3. The optimal shares are 1/4 and 3/4, independent of the
  // initial ones.
  ShareCache cache(4, 2, 1.0f, 1.0f);
  const auto shares_of = [&](uint32_t cell) {
    std::array<float, 2> shares;
    cache.shares(cell, std::array{0.9f, 0.1f}, std::array{0.0f, 0.0f}, shares);
    return shares;
  };
  Pcg32 rng(1);
  for (int iteration = 0; iteration < 4; ++iteration) {
    const auto shares = shares_of(3);
    for (int i = 0; i < 20000; ++i) {
      const int k = rng.next_float() < shares[0] ? 0 : 1;
      const float y = (k == 0 ? 1.0f : 3.0f) / shares[size_t(k)];
      cache.count(3);
      cache.add_square(3, y * y);
      cache.add_moment(3, k, shares[size_t(k)] * y * y);
    }
    cache.publish();
  }
  EXPECT_NEAR(shares_of(3)[0], 0.25f, 0.02f);
  EXPECT_FALSE(cache.learned(2));
  EXPECT_FLOAT_EQ(shares_of(2)[0], 0.9f);
}

TEST(ShareCache, floors_are_kept_with_extreme_values) {
  ShareCache cache(2, 3, 1.0f, 1e-6f);
  for (float y : {1e30f, 1e-30f, 0.0f}) {
    cache.count(0);
    cache.add_square(0, y * y);
    cache.add_moment(0, 1, y * y);
  }
  cache.publish();
  std::array<float, 3> shares;
  cache.shares(0, std::array{0.5f, 0.5f, 0.0f}, std::array{0.1f, 0.05f, 0.0f}, shares);
  EXPECT_GE(shares[0], 0.1f);
  EXPECT_NEAR(shares[0] + shares[1], 1.0f, 1e-5f);
  EXPECT_EQ(shares[2], 0.0f);  // a component without a prior gets no samples
}

}  // namespace ajar::test_direct_light
