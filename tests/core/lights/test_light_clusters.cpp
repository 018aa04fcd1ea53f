// Emissive meshes with many instances: the same light as from a tree of all triangles, and probabilities that fit.
#include "scene_fixtures.h"
#include "statistical.h"

#include "lights/light_set.h"
#include "math/random.h"

namespace ajar::test_light_clusters {

namespace {

using namespace fixtures;

constexpr int kInstances = 20;

/// Shining balls of 16,000 triangles in rows, some stretched or mirrored, and a lamp. `alike`: they share a mesh and a
/// material, so that each is a cluster.
SceneDescription balls(bool alike) {
  SceneDescription d;
  set_camera(d, Vec3(0, -5, 5), Vec3(0.0f), 8);
  d.lights.push_back(area_lamp(Vec3(0, 0, 6), Vec3(0, 0, -1), 1.0f, 50.0f));
  for (int i = 0; i < kInstances; ++i) {
    const float x = float(i % 5) - 2.0f, y = float(i / 5) - 1.5f;
    const Vec3 scale(0.2f, i % 3 == 0 ? 0.05f : 0.2f, i == 8 ? 0.0f : i % 7 == 0 ? -0.2f : 0.2f);  // one is flat
    const Frame turned(glm::normalize(Vec3(0.3f * x, 1.0f, 0.2f * y)));
    const Mat4 at(Vec4(scale.x * turned.s, 0), Vec4(scale.y * turned.t, 0), Vec4(scale.z * turned.n, 0),
                  Vec4(x, y, 1.0f + 0.1f * float(i), 1));
    if (i == 0 || !alike) {
      add_object(d, sphere(64), add_diffuse(d, Color(0.0f), Color(2.0f)), at);
    } else {
      d.instances.push_back(d.instances.back());
      d.instances.back().world_from_object = rows(at);
    }
  }
  set_checker_world(d, Color(0.1f), Color(0.5f), 3.0f);
  return d;
}

RunningMoments irradiance(const LightSet& lights, Vec3 p, Vec3 n, int count, bool by_power) {
  Pcg32 rng(7);
  RunningMoments moments;
  for (int i = 0; i < count; ++i) {
    const float u = rng.next_float();
    const LightSet::Choice choice = by_power ? lights.choose_by_power(u) : lights.choose(p, n, u);
    const float x = rng.next_float();
    const auto s = choice.pmf > 0.0f ? lights.sample_li(choice.light, p, {x, rng.next_float()}, 0.0f) : std::nullopt;
    const bool distant = choice.pmf > 0.0f && int(choice.light) == lights.environment_index();
    moments.add(s && !distant ? double(s->radiance.x) * std::max(0.0f, glm::dot(n, s->wi)) /
                                    (double(s->pdf_solid_angle) * choice.pmf)
                              : 0.0);
  }
  return moments;
}

const std::pair<Vec3, Vec3> kReceivers[] = {
    {{0, 0, 0}, {0, 0, 1}}, {{2, 1, 1.5f}, {-0.8f, 0, 0.6f}}, {{0.1f, 0.1f, 2.0f}, {0, 0.6f, -0.8f}}};

}  // namespace

TEST(LightClusters, lights_have_the_probabilities_by_which_they_are_chosen) {
  const auto scene = build(balls(true));
  const LightSet& lights = scene->lights();
  EXPECT_LT(lights.tree_bytes(), 8u << 20) << "the tree grows with the number of triangles of all instances";
  for (const auto& [p, n] : kReceivers) {
    double sum = 0.0, power = 0.0;
    for (uint32_t i = 0; i < lights.size(); ++i) {
      sum += double(lights.choice_pmf(p, n, i));
      power += double(lights.power_pmf(i));
      if (i % 97 == 0 && lights.flags(i).type == LightType::Triangle && lights.light(i, 0.0f).area > 1e-9f) {
        ASSERT_GT(lights.choice_pmf(p, Vec3(0.0f), i), 0.0f) << i;
      }
    }
    EXPECT_NEAR(sum, 1.0, 1e-3);
    EXPECT_NEAR(power, 1.0, 1e-3);
    for (int k = 0; k < 2000; ++k) {
      const float u = (float(k) + 0.5f) / 2000.0f;
      const LightSet::Choice choice = lights.choose(p, n, u), by_power = lights.choose_by_power(u);
      ASSERT_LT(choice.light, lights.size());
      ASSERT_FLOAT_EQ(choice.pmf, lights.choice_pmf(p, n, choice.light)) << choice.light;
      ASSERT_FLOAT_EQ(by_power.pmf, lights.power_pmf(by_power.light)) << by_power.light;
      ASSERT_GE(choice.u_remapped, 0.0f);
      ASSERT_LT(choice.u_remapped, 1.0f);
    }
  }
}

TEST(LightClusters, lights_have_the_probabilities_by_which_they_are_chosen_for_a_stretch) {
  const auto scene = build(balls(true));
  const LightSet& lights = scene->lights();
  for (const auto& [p, n] : kReceivers) {
    const LightStretch stretch{p, n, 0.0f, kInfinity, 3.0f};
    double sum = 0.0;
    for (uint32_t i = 0; i < lights.size(); ++i) {
      const float pmf = lights.choice_pmf(stretch, i);
      sum += double(pmf);
      if (i % 97 == 0 && lights.flags(i).type == LightType::Triangle && lights.light(i, 0.0f).area > 1e-9f) {
        ASSERT_GT(pmf, 0.0f) << i;
      }
    }
    EXPECT_NEAR(sum, 1.0, 1e-3);
    for (int k = 0; k < 2000; ++k) {
      const LightSet::Choice choice = lights.choose(stretch, (float(k) + 0.5f) / 2000.0f);
      ASSERT_FLOAT_EQ(choice.pmf, lights.choice_pmf(stretch, choice.light)) << choice.light;
    }
  }
}

TEST(LightClusters, have_the_light_of_a_tree_of_all_triangles) {
  const auto alike = build(balls(true)), apart = build(balls(false));
  ASSERT_EQ(alike->lights().size(), apart->lights().size());
  EXPECT_LT(8 * alike->lights().tree_bytes(), apart->lights().tree_bytes());
  EXPECT_NEAR(alike->lights().total_power(), apart->lights().total_power(), 0.1 * apart->lights().total_power());
  for (const auto& [p, n] : kReceivers) {
    const RunningMoments expected = irradiance(apart->lights(), p, n, 200000, false);
    EXPECT_LT(std::sqrt(expected.variance_of_mean()), 0.004 * expected.mean()) << "inconclusive";
    for (const bool by_power : {false, true}) {
      const RunningMoments found = irradiance(alike->lights(), p, n, 400000, by_power);
      EXPECT_TRUE(statistical::means_agree(expected, found, {0.01, 6})) << found.mean() / expected.mean();
      if (by_power) continue;
      // The choice is nearly as good, although a third of the balls is stretched. although a third of the balls is stretched.
      EXPECT_LT(found.variance_of_mean() * 400000.0, 2.0 * expected.variance_of_mean() * 200000.0);
    }
  }
}

// Branches of a cut hold all lights once, and the leaf of a light is that of its cluster.
TEST(LightClusters, branches_of_a_cut_hold_the_lights_of_their_clusters) {
  const auto scene = build(balls(true));
  const LightSet& lights = scene->lights();
  const auto [p, n] = kReceivers[0];
  std::vector<LightSet::Branch> branches;
  lights.cut(p, 0.1f, n, 8, branches);
  ASSERT_GT(branches.size(), 2u);
  Pcg32 rng(3);
  for (const LightSet::Branch& branch : branches)
    for (int k = 0; k < 100; ++k) {
      const LightSet::Choice choice = lights.choose_in(branch.id, p, n, rng.next_float());
      if (!(choice.pmf > 0.0f)) continue;
      ASSERT_FLOAT_EQ(choice.pmf, lights.pmf_in(branch.id, p, n, choice.light));
      uint32_t holder = 0;
      for (const LightSet::Branch& other : branches)
        if (other.id <= lights.place_of(choice.light)) holder = std::max(holder, other.id);
      ASSERT_EQ(holder, branch.id);
    }
}

}  // namespace ajar::test_light_clusters
