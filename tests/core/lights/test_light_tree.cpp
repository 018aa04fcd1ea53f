// The choice of a light by a tree: exact probabilities, correct bounds, and less variance than a choice by power.
#include "statistical.h"

#include <gtest/gtest.h>

#include "lights/light_tree.h"
#include "math/random.h"
#include "math/warps.h"
#include "scene_fixtures.h"

namespace ajar::test_light_tree {

namespace {

using namespace statistical;
using namespace fixtures;

Vec3 direction(Pcg32& rng) { return warp::square_to_sphere({rng.next_float(), rng.next_float()}); }
Vec3 somewhere(Pcg32& rng, float size) {
  return size * Vec3(rng.next_float() - 0.5f, rng.next_float() - 0.5f, rng.next_float() - 0.5f);
}

LightBounds small_light(Vec3 position, Vec3 axis, float cos_normals, float cos_beyond, float intensity) {
  LightBounds b;
  b.lower = b.upper = position;
  b.axis = axis;
  b.cos_normals = cos_normals;
  b.cos_beyond = cos_beyond;
  b.intensity = intensity;
  return b;
}

std::vector<LightTree::Entry> random_lights(int count, uint64_t seed) {
  Pcg32 rng(seed);
  std::vector<LightTree::Entry> entries;
  for (int i = 0; i < count; ++i) {
    LightBounds b = small_light(somewhere(rng, 10.0f), direction(rng), i % 3 == 0 ? -1.0f : 1.0f,
                                i % 2 == 0 ? 0.0f : 0.7f, 0.01f + rng.next_float());
    b.two_sided = i % 5 == 0;
    if (i % 4 == 0) b.upper += Vec3(rng.next_float());
    entries.push_back({uint32_t(2 * i), b});
  }
  return entries;
}

TEST(LightTree, probabilities_are_exact_and_sum_to_one) {
  const LightTree tree(random_lights(300, 7), 600);
  Pcg32 rng(3);
  for (int at = 0; at < 20; ++at) {
    const Vec3 p = somewhere(rng, 14.0f), n = at % 4 == 0 ? Vec3(0.0f) : direction(rng);
    double sum = 0.0;
    for (uint32_t light = 0; light < 600; ++light) {
      const float pmf = tree.pmf(p, n, light);
      if (light % 2 == 1) {
        EXPECT_EQ(pmf, 0.0f) << "not in the tree";
      }
      sum += double(pmf);
    }
    EXPECT_LE(sum, 1.0 + 1e-5);
    std::vector<double> expected(600), seen(600, 0.0);
    constexpr int kDraws = 20000;
    double nothing = 0.0;
    for (uint32_t light = 0; light < 600; ++light) expected[light] = double(tree.pmf(p, n, light)) * kDraws;
    for (int i = 0; i < kDraws; ++i) {
      const auto choice = tree.choose(p, n, (float(i) + rng.next_float()) / kDraws);
      if (choice.pmf == 0.0f) {  // the bounds of a branch are positive, but its lights do not reach p
        nothing += 1.0 / kDraws;
        continue;
      }
      ASSERT_EQ(choice.pmf, tree.pmf(p, n, choice.light));
      ASSERT_GE(choice.u_remapped, 0.0f);
      ASSERT_LT(choice.u_remapped, 1.0f);
      ++seen[choice.light];
    }
    EXPECT_NEAR(sum + nothing, 1.0, 2e-3);
    // Draws are stratified, so that a count differs from its expectation by at most two.
    for (uint32_t light = 0; light < 600; ++light) EXPECT_NEAR(seen[light], expected[light], 2.0) << light;
  }
}

TEST(LightTree, joined_bounds_contain_every_light) {
  Pcg32 rng(11);
  for (int trial = 0; trial < 300; ++trial) {
    const auto entries = random_lights(6, 100 + uint64_t(trial));
    LightBounds all;
    for (const LightTree::Entry& e : entries) all = join(all, e.bounds);
    float intensity = 0.0f;
    for (const LightTree::Entry& e : entries) {
      intensity += e.bounds.intensity;
      EXPECT_TRUE(glm::all(glm::lessThanEqual(all.lower, e.bounds.lower)) &&
                  glm::all(glm::greaterThanEqual(all.upper, e.bounds.upper)));
      EXPECT_LE(all.cos_beyond, e.bounds.cos_beyond);
      float cosine = glm::dot(all.axis, e.bounds.axis);
      if (all.two_sided) cosine = std::abs(cosine);
      const float farthest = std::acos(std::clamp(cosine, -1.0f, 1.0f)) + std::acos(e.bounds.cos_normals);
      EXPECT_LE(std::min(farthest, kPi), std::acos(all.cos_normals) + 2e-3f);
    }
    EXPECT_NEAR(all.intensity, intensity, 1e-5f);
  }
}

TEST(LightTree, every_light_that_reaches_a_point_can_be_chosen) {
  // Flat lights and spots. The tree may omit only lights that do not reach the point.
  Pcg32 rng(5);
  std::vector<LightTree::Entry> entries;
  for (uint32_t i = 0; i < 64; ++i)
    entries.push_back({i, small_light(somewhere(rng, 4.0f), direction(rng), 1.0f, i % 2 == 0 ? 0.0f : 0.9f, 1.0f)});
  const std::vector<LightTree::Entry> kept = entries;
  const LightTree tree(std::move(entries), 64);
  int dark = 0;
  for (int at = 0; at < 2000; ++at) {
    const Vec3 p = somewhere(rng, 8.0f), n = direction(rng);
    for (const LightTree::Entry& e : kept) {
      const Vec3 out = glm::normalize(p - e.bounds.lower);
      const bool shines = glm::dot(out, e.bounds.axis) > e.bounds.cos_beyond + 1e-4f && glm::dot(-out, n) > 0.0f;
      const float pmf = tree.pmf(p, n, e.light);
      if (shines) {
        EXPECT_GT(pmf, 0.0f) << "light " << e.light;
      }
      dark += pmf == 0.0f ? 1 : 0;
    }
  }
  EXPECT_GT(dark, 10000) << "flat lights seen from behind cost no samples";
}

LightStretch random_stretch(Pcg32& rng, int number) {
  LightStretch stretch{somewhere(rng, 14.0f), direction(rng), rng.next_float(), 0.0f, 0.0f};
  stretch.reach = 0.1f + 10.0f * rng.next_float();
  stretch.end = number % 3 == 0 ? kInfinity : stretch.begin + stretch.reach * (1.0f + 3.0f * rng.next_float());
  return stretch;
}

TEST(LightTree, probabilities_for_stretches_are_exact_and_sum_to_one) {
  const LightTree tree(random_lights(300, 7), 600);
  Pcg32 rng(3);
  for (int at = 0; at < 20; ++at) {
    const LightStretch stretch = random_stretch(rng, at);
    double sum = 0.0, nothing = 0.0;
    for (uint32_t light = 0; light < 600; ++light) sum += double(tree.pmf(stretch, light));
    constexpr int kDraws = 5000;
    for (int i = 0; i < kDraws; ++i) {
      const auto choice = tree.choose(stretch, (float(i) + rng.next_float()) / kDraws);
      if (choice.pmf == 0.0f) {
        nothing += 1.0 / kDraws;
      } else {
        ASSERT_EQ(choice.pmf, tree.pmf(stretch, choice.light));
        ASSERT_TRUE(choice.u_remapped >= 0.0f && choice.u_remapped < 1.0f);
      }
    }
    EXPECT_NEAR(sum + nothing, 1.0, 4e-3);
  }
  // A point is a stretch without length.
  for (int at = 0; at < 20; ++at) {
    const Vec3 p = somewhere(rng, 14.0f);
    for (uint32_t light = 0; light < 600; light += 2)
      ASSERT_EQ(tree.pmf(LightStretch::at(p), light), tree.pmf(p, Vec3(0.0f), light));
  }
}

TEST(LightTree, every_light_that_reaches_a_point_of_a_stretch_can_be_chosen) {
  Pcg32 rng(5);
  std::vector<LightTree::Entry> entries;
  for (uint32_t i = 0; i < 64; ++i) {
    entries.push_back({i, small_light(somewhere(rng, 4.0f), direction(rng), 1.0f, i % 2 == 0 ? 0.0f : 0.9f, 1.0f)});
    entries.back().bounds.two_sided = i % 3 == 0;
  }
  const std::vector<LightTree::Entry> kept = entries;
  const LightTree tree(std::move(entries), 64);
  int dark = 0, lit = 0;
  for (int at = 0; at < 2000; ++at) {
    const LightStretch stretch = random_stretch(rng, at);
    for (const LightTree::Entry& e : kept) {
      bool shines = false;
      for (int k = 0; k < 8; ++k) {
        const float last = std::min(stretch.end, 200.0f), t = stretch.begin + (last - stretch.begin) * rng.next_float();
        float cosine = glm::dot(glm::normalize(stretch.point(t) - e.bounds.lower), e.bounds.axis);
        if (e.bounds.two_sided) cosine = std::abs(cosine);
        shines |= cosine > e.bounds.cos_beyond + 1e-3f;
      }
      const float pmf = tree.pmf(stretch, e.light);
      if (shines) {
        ASSERT_GT(pmf, 0.0f) << "light " << e.light;
      }
      dark += pmf == 0.0f ? 1 : 0;
      lit += shines ? 1 : 0;
    }
  }
  EXPECT_GT(lit, 40000);
  EXPECT_GT(dark, 10000) << "cones that the ray does not meet cost no samples";
}

TEST(LightTree, lamps_near_a_stretch_have_larger_probabilities_and_the_variance_falls) {
  // A row of lamps beside a ray that is ten times as long. One sample estimates the integral of 1 / distance^2.
  std::vector<LightTree::Entry> entries;
  constexpr int kLamps = 40;
  for (uint32_t i = 0; i < kLamps; ++i)
    entries.push_back(
        {i, small_light(Vec3(float(i), 0.2f + 0.05f * float(i % 7), 0), Vec3(0, 0, 1), -1.0f, 1.0f, 1.0f)});
  const std::vector<LightTree::Entry> kept = entries;
  const LightTree tree(std::move(entries), kLamps);
  const LightStretch stretch{Vec3(-1, 0, 0), Vec3(1, 0, 0), 0.0f, 400.0f, 400.0f};
  const auto integral = [&](uint32_t light) {
    const double x = double(kept[light].bounds.lower.x) + 1.0, y = double(kept[light].bounds.lower.y);
    return (std::atan((400.0 - x) / y) + std::atan(x / y)) / y;
  };
  double expected = 0.0;
  for (uint32_t i = 0; i < kLamps; ++i) expected += integral(i);
  RunningMoments for_stretch, for_points;
  Pcg32 rng(17);
  for (int i = 0; i < 20000; ++i) {
    const auto choice = tree.choose(stretch, rng.next_float());
    for_stretch.add(integral(choice.light) / double(choice.pmf));
    const auto at_point = tree.choose(stretch.point(400.0f * rng.next_float()), Vec3(0.0f), rng.next_float());
    for_points.add(integral(at_point.light) / double(at_point.pmf));
  }
  EXPECT_TRUE(mean_agrees(for_stretch, expected, {.test_count = 2}, 1e-6));
  EXPECT_LT(for_stretch.variance() * 20.0, for_points.variance());
}

TEST(LightTree, near_lights_have_larger_probabilities_and_the_variance_falls) {
  // A row of equal lamps. One sample estimates the irradiance at a point, with a choice by the tree and by power.
  Pcg32 rng(17);
  std::vector<LightTree::Entry> entries;
  constexpr int kLamps = 1000;
  for (uint32_t i = 0; i < kLamps; ++i)
    entries.push_back(
        {i, small_light(Vec3(float(i), 2.0f * rng.next_float() + 1.0f, 3.0f), Vec3(0, 0, -1), -1.0f, 1.0f, 1.0f)});
  const std::vector<LightTree::Entry> kept = entries;
  const LightTree tree(std::move(entries), kLamps);
  const Vec3 p(500.0f, 0.0f, 0.0f), up(0, 0, 1);
  const auto irradiance = [&](uint32_t light) {
    const Vec3 d = kept[light].bounds.lower - p;
    const double d2 = double(glm::dot(d, d));
    return double(d.z) / (d2 * std::sqrt(d2));
  };
  double expected = 0.0;
  for (uint32_t i = 0; i < kLamps; ++i) expected += irradiance(i);
  RunningMoments by_tree, by_power;
  for (int i = 0; i < 20000; ++i) {
    const auto choice = tree.choose(p, up, rng.next_float());
    by_tree.add(irradiance(choice.light) / double(choice.pmf));
    by_power.add(irradiance(std::min(uint32_t(rng.next_float() * kLamps), uint32_t(kLamps - 1))) * kLamps);
  }
  EXPECT_TRUE(mean_agrees(by_tree, expected, {.test_count = 2}, 1e-6));
  EXPECT_LT(by_tree.variance() * 100.0, by_power.variance());
}

/// Spot lamps above a floor, in all directions, each with the triangles of a glowing lens around it, and a wall that glows.
/// The lamps come first.
std::vector<LightTree::Entry> stage(uint32_t lamps) {
  Pcg32 rng(29);
  std::vector<LightTree::Entry> entries, triangles;
  constexpr uint32_t kOfLens = 24, kOfWall = 2;
  for (uint32_t i = 0; i < lamps; ++i) {
    const Vec3 position = Vec3(10.0f * rng.next_float(), 10.0f * rng.next_float(), 5.0f), at = direction(rng);
    entries.push_back({i, small_light(position, Vec3(at.x, at.y, -std::abs(at.z)), 1.0f, 0.95f, 1000.0f)});
    for (uint32_t t = 0; t < kOfLens; ++t)
      triangles.push_back({0, small_light(position + 0.05f * direction(rng), direction(rng), 1.0f, 0.0f, 0.001f)});
  }
  for (uint32_t t = 0; t < kOfWall; ++t)
    triangles.push_back({0, small_light(Vec3(5.0f, 12.0f, 2.0f + float(t)), Vec3(0, -1, 0), 1.0f, 0.0f, 5.0f)});
  for (LightTree::Entry& e : triangles) {
    e.light = uint32_t(entries.size());
    e.bounds.two_sided = true;
    entries.push_back(e);
  }
  return entries;
}

/// Irradiance of a light of `stage`, which has no extent.
double irradiance(const LightBounds& b, Vec3 p, Vec3 n) {
  const Vec3 d = b.lower - p;
  const double distance2 = double(glm::dot(d, d));
  double cosine = -double(glm::dot(d, b.axis)) / std::sqrt(distance2);
  if (b.two_sided) cosine = std::abs(cosine);
  if (cosine < double(b.cos_beyond)) return 0.0;
  return double(b.intensity) * cosine * std::max(double(glm::dot(d, n)), 0.0) / (distance2 * std::sqrt(distance2));
}

TEST(LightTree, where_no_beam_shines_the_lenses_beside_the_lamps_are_chosen_rarely) {
  // One sample estimates the irradiance. With the bounds of lamps and lenses in one node, the lenses get nearly all choices.
  for (const uint32_t lamps : {13u, 45u}) {
    const std::vector<LightTree::Entry> entries = stage(lamps);
    const LightTree tree(entries, uint32_t(entries.size()));
    Pcg32 rng(31);
    double relative = 0.0;
    constexpr int kPoints = 200, kDraws = 400;
    for (int at = 0; at < kPoints; ++at) {
      const Vec3 p(10.0f * rng.next_float(), 10.0f * rng.next_float(), 0.0f), up(0, 0, 1);
      double expected = 0.0;
      for (const LightTree::Entry& e : entries) expected += irradiance(e.bounds, p, up);
      RunningMoments one;
      for (int i = 0; i < kDraws; ++i) {
        const auto choice = tree.choose(p, up, (float(i) + rng.next_float()) / kDraws);
        one.add(choice.pmf > 0.0f ? irradiance(entries[choice.light].bounds, p, up) / double(choice.pmf) : 0.0);
      }
      EXPECT_NEAR(one.mean(), expected, 0.05 * expected);
      relative += one.variance() / sqr(expected) / kPoints;
    }
    EXPECT_LT(relative, 0.1) << lamps << " lamps";
  }
}

TEST(LightTree, many_lamps_are_chosen_by_the_importances_of_groups) {
  const std::vector<LightTree::Entry> entries = stage(1000);
  const LightTree tree(entries, uint32_t(entries.size()));
  Pcg32 rng(41);
  const Vec3 p(5.0f, 5.0f, 0.0f), up(0, 0, 1);
  double expected = 0.0;
  for (const LightTree::Entry& e : entries) expected += irradiance(e.bounds, p, up);
  RunningMoments one;
  constexpr int kDraws = 40000;
  for (int i = 0; i < kDraws; ++i) {
    const auto choice = tree.choose(p, up, (float(i) + rng.next_float()) / kDraws);
    if (choice.pmf > 0.0f) {
      ASSERT_EQ(choice.pmf, tree.pmf(p, up, choice.light));
    }
    one.add(choice.pmf > 0.0f ? irradiance(entries[choice.light].bounds, p, up) / double(choice.pmf) : 0.0);
  }
  EXPECT_TRUE(mean_agrees(one, expected, {.test_count = 1}, 1e-3));
  EXPECT_LT(one.variance(), 4.0 * sqr(expected));
}

TEST(LightTree, large_lamps_near_a_wall_that_they_graze_do_not_get_most_of_the_samples) {
  // Two lamps beside a wall that shine along it, and one far in front of it. With the most favourable angles of all points
  // of a lamp, the irradiance over the probability differs by factors of 2.7 to 5, and the point behind a lamp chooses it
  // with the probability 0.71.
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.5f)));
  d.lights.push_back(area_lamp(Vec3(-1.0f, 0.0f, 0.9f), Vec3(1.0f, 0.0f, 0.9f), 1.0f, 46.0f));
  d.lights.push_back(area_lamp(Vec3(1.1f, 0.0f, 1.0f), Vec3(-1.0f, 0.0f, 0.9f), 1.0f, 40.0f));
  d.lights.push_back(area_lamp(Vec3(-1.0f, 0.3f, 3.0f), Vec3(0.4f, 0.0f, -1.0f), 0.7f, 38.0f));
  set_camera(d, Vec3(0.0f, 0.0f, 4.0f), Vec3(0.0f), 4, 0.7f);
  const auto scene = build(d);
  const LightSet& lights = scene->lights();
  const Vec3 n(0, 0, 1);
  for (const Vec3 p : {Vec3(0.0f), Vec3(0.1f, 0.4f, 0.0f), Vec3(-0.1f, -0.5f, 0.0f)}) {
    double least = 1e30, most = 0.0;
    for (uint32_t light = 0; light < 3; ++light) {
      double irradiance = 0.0;
      constexpr int kSide = 30;
      for (int i = 0; i < kSide * kSide; ++i) {
        const Vec2 u((float(i % kSide) + 0.5f) / kSide, (float(i / kSide) + 0.5f) / kSide);
        const auto sample = lights.sample_li(light, p, u, kMidShutter);
        if (!sample) continue;
        irradiance += double(sample->radiance.x * std::max(sample->wi.z, 0.0f) / sample->pdf_solid_angle) /
                      (kSide * kSide);
      }
      ASSERT_GT(irradiance, 0.0);
      const double ratio = irradiance / double(lights.choice_pmf(p, n, light));
      least = std::min(least, ratio);
      most = std::max(most, ratio);
    }
    EXPECT_LT(most, 2.5 * least) << p.x << " " << p.y;
  }
  EXPECT_EQ(lights.choice_pmf(Vec3(-0.6f, 0.0f, 0.0f), n, 0), 0.0f);  // behind the lamp
}

TEST(LightTree, lamps_of_one_node_are_chosen_in_proportion_to_their_importances) {
  // The importance of one lamp is that of a tree that holds nothing else.
  for (const uint32_t lamps : {2u, 7u, 8u, 9u, 64u}) {
    std::vector<LightTree::Entry> entries = stage(lamps);
    entries.resize(lamps);
    const LightTree tree(entries, lamps);
    std::vector<LightTree> single;
    for (const LightTree::Entry& e : entries) single.emplace_back(std::vector<LightTree::Entry>{e}, lamps);
    Pcg32 rng(37);
    const auto expect_in_proportion = [&](const auto&... receiver) {
      double sum = 0.0;
      for (const LightTree& one : single) sum += double(one.importance(receiver...));
      EXPECT_NEAR(double(tree.importance(receiver...)), sum, 1e-4 * sum);
      for (uint32_t i = 0; i < lamps; ++i)
        EXPECT_NEAR(double(tree.pmf(receiver..., i)), sum > 0.0 ? double(single[i].importance(receiver...)) / sum : 0.0,
                    1e-4);
    };
    for (int at = 0; at < 100; ++at) {
      expect_in_proportion(somewhere(rng, 12.0f), at % 3 == 0 ? Vec3(0.0f) : direction(rng));
      expect_in_proportion(random_stretch(rng, at));
    }
  }
}

TEST(LightTree, probabilities_are_finite_for_extreme_lights_and_points) {
  std::vector<LightTree::Entry> entries;
  for (uint32_t i = 0; i < 40; ++i) {  // many lights at the same point, so that no split by cost exists
    LightBounds b = small_light(Vec3(1.0f), Vec3(0, 0, 1), 1.0f, 0.0f, i % 2 == 0 ? 1e-30f : 1e20f);
    b.two_sided = true;
    entries.push_back({i, b});
  }
  entries.push_back({40, small_light(Vec3(1e18f), Vec3(1, 0, 0), -1.0f, 1.0f, 1.0f)});
  const LightTree tree(std::move(entries), 41);
  for (Vec3 p : {Vec3(1.0f), Vec3(1.0f, 1.0f, 1.0f + 1e-6f), Vec3(0.0f), Vec3(1e18f), Vec3(-1e15f)})
    for (Vec3 n : {Vec3(0.0f), Vec3(0, 0, 1), Vec3(0, 0, -1)})
      for (float u : {0.0f, 0.5f, kOneMinusEpsilon}) {
        const auto choice = tree.choose(p, n, u);
        EXPECT_TRUE(std::isfinite(choice.pmf) && choice.pmf >= 0.0f && choice.light < 41);
        for (float reach : {0.0f, 1e-30f, 1.0f, 1e18f}) {
          const auto along = tree.choose({p, Vec3(0, 0, n.z < 0.0f ? -1.0f : 1.0f), 0.0f, kInfinity, reach}, u);
          EXPECT_TRUE(std::isfinite(along.pmf) && along.pmf >= 0.0f && along.light < 41);
          EXPECT_TRUE(along.pmf == 0.0f ||
                      along.pmf ==
                          tree.pmf({p, Vec3(0, 0, n.z < 0.0f ? -1.0f : 1.0f), 0.0f, kInfinity, reach}, along.light));
        }
      }
}

TEST(LightTree, lights_at_the_limits_of_floats_are_split) {
  std::vector<LightTree::Entry> entries;
  for (uint32_t i = 0; i < 100; ++i)
    entries.push_back({i, small_light(Vec3(float(i) * 3e36f, 0, 0), Vec3(0, 0, 1), -1.0f, 1.0f, 1.0f)});
  // Intensities that grow with the distance leave none at the distance 0, over an area that is infinite.
  for (size_t i = 0; i < entries.size(); i += 3) let_grow(entries[i].bounds, 1, 1e-3f);
  for (const uint32_t count : {100u, 9u}) {  // several nodes of lamps, and one
    const LightTree tree(std::vector<LightTree::Entry>(entries.begin(), entries.begin() + count), count);
    for (const Vec3 p : {Vec3(0.0f), Vec3(5e36f, 0, 0), Vec3(1e38f, 0, 1e-38f)})
      for (const float u : {0.0f, 0.5f, kOneMinusEpsilon}) {
        const auto choice = tree.choose(p, Vec3(0.0f), u);
        EXPECT_TRUE(std::isfinite(choice.pmf) && choice.pmf >= 0.0f && choice.light < count);
        EXPECT_TRUE(choice.u_remapped >= 0.0f && choice.u_remapped < 1.0f);
        EXPECT_TRUE(choice.pmf == 0.0f || choice.pmf == tree.pmf(p, Vec3(0.0f), choice.light));
      }
  }
}

TEST(LightTree, the_tree_does_not_depend_on_the_number_of_threads) {
  const LightTree a(random_lights(20000, 23), 40000), b(random_lights(20000, 23), 40000);
  Pcg32 rng(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = somewhere(rng, 12.0f), n = direction(rng);
    const float u = rng.next_float();
    const auto x = a.choose(p, n, u), y = b.choose(p, n, u);
    ASSERT_TRUE(x.light == y.light && x.pmf == y.pmf);
  }
}

}  // namespace

}  // namespace ajar::test_light_tree
