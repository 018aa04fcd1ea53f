#include <gtest/gtest.h>

#include "hint_fixtures.h"
#include "statistical.h"
#include "transport/bidirectional/bidirectional.h"
#include "transport/chains/chain.h"
#include "transport/chains/mutations/hint_mutation.h"
#include "transport/chains/mutations/standard_mutations.h"
#include "transport_scenes.h"

namespace ajar::test_hint_mutation {

using namespace fixtures;

namespace {

/// A scene, its attached hints, and its path space.
struct Hinted {
  std::shared_ptr<const Scene> scene;
  PathSpace space;
  std::vector<HintReport> reports;
  Hints hints;

  Hinted(SceneDescription d, std::vector<HintDescription> described, bool without_direct = true)
      : scene([&] {
          d.hints = std::move(described);
          return build(d);
        }()),
        space(*scene, 0, 0, 12, 12, without_direct),
        hints(Hints::attach(*scene, reports)) {
    for (const HintReport& r : reports) EXPECT_TRUE(r.attached) << r.name << ": " << r.reason;
  }

  std::unique_ptr<Path> find(const std::function<bool(const Path&)>& wanted, uint32_t seed = 1) const {
    BidirectionalWalks walks(*scene, space.film_area());
    Sampler sampler(Sampler::Kind::Independent, seed);
    auto path = std::make_unique<Path>();
    for (uint32_t i = 0; i < 100000; ++i) {
      sampler.start(i, 0);
      for (const FoundPath& found : walks.sample(space.film_at(sampler.get_2d()), sampler)) {
        path->count = walks.copy_path(found, path->vertices.data(), path->edges.data());
        path->film = found.film;
        if (space.complete(*path, 1, path->count - 2) && wanted(*path)) return path;
      }
    }
    return nullptr;
  }
};

const std::vector<HintDescription> kGlassHints = {
    hint("Caustic", {{0.3f, 0.1f, 0.95f}, {0.25f, 0.25f, -0.1f}, {0.2f, 0.3f, -1.0f}}, 0.2f),
    hint("Wall", {{0.3f, 0.1f, 0.95f}, {-1.0f, 0.2f, 0.0f}}, 0.6f),
    hint("Two walls", {{0.3f, 0.1f, 0.95f}, {-1.0f, 0.2f, 0.0f}, {0.0f, 1.0f, 0.2f}}, 0.6f)};
const std::vector<HintDescription> kPointHints = {
    hint("Wall", {{-0.3f, 0.2f, 0.6f}, {-1.0f, 0.2f, 0.0f}}, 0.5f),
    hint("Two walls", {{-0.3f, 0.2f, 0.6f}, {-1.0f, 0.2f, 0.0f}, {0.0f, 1.0f, 0.2f}}, 0.5f)};
std::vector<HintDescription> hints_for(const std::string& name) {
  return name == "point_light" ? kPointHints : kGlassHints;
}

}  // namespace

class HintMutationsIn : public ::testing::TestWithParam<const char*> {};

TEST_P(HintMutationsIn, have_a_density_in_both_directions_and_keep_the_eye_subpath_or_the_lens) {
  const Hinted h(scene_named(GetParam()), hints_for(GetParam()));
  const HintMutation mutation(h.space, h.hints, 0.7f, 0.3f);
  auto to = std::make_unique<Path>(), again = std::make_unique<Path>();
  Sampler sampler(Sampler::Kind::Independent, 3);
  sampler.start(0, 0);
  uint64_t rays = 0, proposed = 0, unpaired = 0, unknown = 0, by_lens = 0;
  std::vector<uint64_t> by_hint(h.hints.size(), 0);
  for (uint32_t start = 0; start < 30; ++start) {
    const auto from = h.find([](const Path&) { return true; }, start);
    ASSERT_TRUE(from);
    for (int i = 0; i < 300; ++i) {
      to->hint = -1;
      if (!mutation.sample(*from, sampler, *to, rays)) continue;
      ++proposed;
      const double there = mutation.pdf(*from, *to), back = mutation.pdf(*to, *from);
      ASSERT_TRUE(std::isfinite(there) && std::isfinite(back));
      unknown += !(there > 0.0);
      const int kept = shared_ends(*from, *to).eye;
      // Otherwise the eye subpath has another end, for example after a mirror, and there is no single step back.
      if (kept == 1 || first_joinable_from_eye(*to) == to->count - kept) unpaired += !(back > 0.0);
      ASSERT_TRUE(kept == 1 || kept == from->count - first_joinable_from_eye(*from));
      if (to->hint < 0) continue;
      ++by_hint[size_t(to->hint)];
      by_lens += kept == 1;
      std::vector<double> shares(h.hints.size(), 0.0);
      add_hint_shares(h.scene->lights(), h.hints, *to, 1.0, shares);
      if (there > 0.0) {
        EXPECT_GT(shares[size_t(to->hint)], 0.0);
      }
    }
  }
  EXPECT_GT(proposed, 500u);
  EXPECT_GT(by_lens, 20u);
  for (size_t i = 0; i < h.hints.size(); ++i) EXPECT_GT(by_hint[i], 20u) << h.hints[i].name;
  // Rounding may move a direction out of a cone. Paths that are connected to the lens may need a light walk that this
  // mutation does not propose.
  EXPECT_LE(unknown, 1 + proposed / 300);
  EXPECT_LE(unpaired, proposed / 3);
}
INSTANTIATE_TEST_SUITE_P(Scenes, HintMutationsIn, ::testing::Values("glass_ball", "point_light"),
                         [](const auto& info) { return std::string(info.param); });

/// The expectation of 1 / pdf over proposals whose new vertices lie in a region is the measure of the region.
TEST(HintMutationDensity, one_over_the_density_integrates_to_the_measure_of_a_region) {
  // The area of the lamp is 0.25. The area of the patch on the left wall, or of the visible one on the back wall, is
  // 0.04.
  const auto on_left = [](Vec3 p) {
    return std::abs(p.x + 1.0f) < 1e-3f && std::abs(p.y) < 0.1f && std::abs(p.z) < 0.1f;
  };
  const auto on_back = [](Vec3 p) {
    return std::abs(p.y - 1.0f) < 1e-3f && std::abs(p.x + 0.2f) < 0.1f && std::abs(p.z - 0.3f) < 0.1f;
  };
  struct Case {
    const char* what;
    float hint_probability;
    bool lens;
  };
  for (const Case c : {Case{"hint connected to a visible vertex", 1.0f, false},
                       Case{"hint connected to the lens", 1.0f, true}, Case{"regrowth", 0.0f, false}}) {
    const Vec3 target = c.lens ? Vec3(-0.2f, 1.0f, 0.3f) : Vec3(-1.0f, 0.0f, 0.0f);
    const Hinted h(scene_named("area_lamp"), {hint("Patch", {{0.1f, 0.1f, 0.95f}, target}, 0.5f)}, !c.lens);
    const HintMutation mutation(h.space, h.hints, c.hint_probability, 1.0f - c.hint_probability);
    const auto from = h.find([](const Path& p) {
      return p.count == 4 && p.vertices[2].position().y > 0.99f && p.vertices[2].position().z > 0.0f;
    });
    ASSERT_TRUE(from);
    auto to = std::make_unique<Path>();
    Sampler sampler(Sampler::Kind::Independent, 5);
    sampler.start(0, 0);
    uint64_t rays = 0;
    RunningMoments moments;
    for (int i = 0; i < (c.hint_probability > 0.0f ? 100000 : 600000); ++i) {
      double value = 0.0;
      if (mutation.sample(*from, sampler, *to, rays) && to->count == (c.lens ? 3 : 4) &&
          (c.lens ? on_back(to->vertices[1].position()) : on_left(to->vertices[1].position())))
        value = 1.0 / mutation.pdf(*from, *to);
      moments.add(value);
    }
    EXPECT_TRUE(statistical::mean_agrees(moments, 0.25 * 0.04, {0.01, 3})) << c.what;
    EXPECT_LT(std::sqrt(moments.variance_of_mean()), 0.0006) << c.what;
  }
}

class HintMutationChains : public ::testing::TestWithParam<const char*> {};

TEST_P(HintMutationChains, have_the_distribution_of_their_target) {
  const Hinted h(scene_named(GetParam()), hints_for(GetParam()));
  const auto visits = [&](bool hinted, uint32_t seed) {
    std::vector<MutationShare> shares;
    if (hinted)
      shares.push_back({std::make_unique<HintMutation>(h.space, h.hints, 0.5f, 0.2f), 1.0f});
    else
      shares.push_back({std::make_unique<BidirectionalMutation>(h.space), 1.0f});
    std::array<double, 5> sums{};
    for (uint32_t c = 0; c < 4; ++c) {
      Chain chain(shares);
      chain.start(*h.find([](const Path&) { return true; }, seed * 16 + c));
      Sampler sampler(Sampler::Kind::Independent, seed);
      sampler.start(c, 0);
      constexpr int kBurnIn = 2000, kSteps = 10000;
      for (int i = 0; i < kBurnIn + kSteps; ++i)
        chain.step(sampler, [&](const Path& p, double weight) {
          if (i < kBurnIn) return;
          weight /= 4.0 * kSteps;
          sums[0] += weight * (p.film.x < 6.0f);
          sums[1] += weight * (p.film.y < 6.0f);
          sums[2] += weight * (p.count <= 4);
          sums[3] += weight * (first_joinable_from_eye(p) < p.count - 2);
          std::vector<double> able(h.hints.size(), 0.0);
          add_hint_shares(h.scene->lights(), h.hints, p, weight, able);
          for (double a : able) sums[4] += a;
        });
    }
    return sums;
  };
  std::array<RunningMoments, 5> plain, hinted;
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    const auto a = visits(false, seed), b = visits(true, 100 + seed);
    for (size_t i = 0; i < 5; ++i) plain[i].add(a[i]), hinted[i].add(b[i]);
  }
  EXPECT_GT(plain[4].mean(), 0.02);  // hints can propose a relevant part of the paths
  for (size_t i = 0; i < 5; ++i)
    EXPECT_TRUE(statistical::means_agree(plain[i], hinted[i], {0.01, 10})) << "statistic " << i;
}
INSTANTIATE_TEST_SUITE_P(Scenes, HintMutationChains, ::testing::Values("glass_ball", "point_light"),
                         [](const auto& info) { return std::string(info.param); });

TEST(StandardMutations, are_those_that_the_scene_needs) {
  const auto names = [](SceneDescription d, std::vector<HintDescription> described) {
    const Hinted h(std::move(d), std::move(described));
    std::string all;
    for (const MutationShare& m : standard_mutations(h.space, h.hints)) all += std::string(m.mutation->name()) + " ";
    return all;
  };
  EXPECT_EQ(names(scene_named("glass_ball"), {}), "bidirectional lens caustic ");
  EXPECT_EQ(names(scene_named("glass_ball"), kGlassHints), "user_path lens caustic ");
}

TEST(HintMutations, keep_the_mean_with_good_useless_and_wrong_hints) {
  const Rendered none = render_hinted(keyhole(), {}, 24, 1);
  const std::pair<const char*, std::vector<HintDescription>> sets[] = {
      {"good", kGood}, {"useless", kUseless}, {"wrong", kWrong}};
  uint32_t first_seed = 1000;
  for (const auto& [name, hints] : sets) {
    const Rendered with = render_hinted(keyhole(), hints, 24, first_seed += 1000);
    for (size_t i = 0; i < 27; ++i)
      EXPECT_TRUE(statistical::means_agree(none.blocks[i], with.blocks[i], {0.01, 3 * 27})) << name << ", value " << i;
    EXPECT_GT(with.proposed, 1000u) << name;  // hints that find less light are proposed less often
    if (std::string(name) == "good") {
      EXPECT_GT(with.accepted, 100u);
    }
  }
}

TEST(HintMutations, work_with_populations) {
  const Rendered none = render_hinted(keyhole(), {}, 16, 1, 24, "pmc_pt");
  const Rendered good = render_hinted(keyhole(), kGood, 16, 1000, 24, "pmc_pt"),
                 wrong = render_hinted(keyhole(), kWrong, 16, 2000, 24, "pmc_pt");
  for (const Rendered& with : {good, wrong}) {
    for (size_t i = 0; i < 27; ++i)
      EXPECT_TRUE(statistical::means_agree(none.blocks[i], with.blocks[i], {0.01, 2 * 27})) << "value " << i;
    EXPECT_GT(with.proposed, 1000u);
  }
  EXPECT_GT(good.accepted, 50u);
  // The energy shares of the hints are equal to those of chains.
  const SceneDescription easy = scene_named("glass_ball");
  constexpr int kSeeds = 8;  // with one seed, the error of a share is about a sixth
  std::vector<double> of_chains(kGlassHints.size(), 0.0), of_members = of_chains;
  const auto add_shares = [&](const char* integrator, uint32_t seed, std::vector<double>& sums) {
    const Rendered one = render_hinted(easy, kGlassHints, 1, seed, 400, integrator);
    for (size_t i = 0; i < sums.size(); ++i)
      sums[i] += one.statistics["hints"][i]["energy_share"].get<double>() / kSeeds;
  };
  for (uint32_t seed = 5; seed < 5 + kSeeds; ++seed) {
    add_shares("metropolis", seed, of_chains);
    add_shares("pmc_pt", seed, of_members);
  }
  for (size_t i = 0; i < kGlassHints.size(); ++i) {
    EXPECT_GT(of_chains[i], 0.002) << kGlassHints[i].name;
    EXPECT_NEAR(of_members[i], of_chains[i], 0.2 * of_chains[i]) << kGlassHints[i].name;
  }
}

TEST(HintMutations, with_malformed_hints_are_reported_by_name_and_do_not_stop_the_render) {
  std::vector<HintDescription> hints = {hint("One point", {kLamp}),
                                        hint("Off in space", {kLamp, {50, 50, 50}}),
                                        hint("Through a wall", {kLamp, {-0.9f, 0.0f, -0.9f}}),
                                        hint("Not a number", {kLamp, {kNan, 0, 0}}),
                                        hint("Ten thousand points", std::vector<Vec3>(10000, kLamp)),
                                        kGood[0]};
  hints[1].points[0] = Vec3(40, 40, 40);
  const Rendered r = render_hinted(keyhole(), hints, 1, 7, 2);
  const auto& reported = r.statistics["hints"];
  ASSERT_EQ(reported.size(), hints.size());
  for (size_t i = 0; i < hints.size(); ++i) {
    EXPECT_EQ(reported[i]["name"], hints[i].name);
    const bool good = i + 1 == hints.size();
    EXPECT_EQ(reported[i]["attached"], good) << reported[i]["reason"];
    EXPECT_EQ(reported[i]["reason"].get<std::string>().empty(), good);
    EXPECT_EQ(reported[i]["proposed"].get<uint64_t>() > 0, good);
  }
  EXPECT_GT(reported.back()["energy_share"].get<double>(), 0.0);
  EXPECT_EQ(reported.back()["positions"].size(), 2u);
  EXPECT_EQ(reported.back()["segments"][0], "attached");
  // The list of warnings contains them as well.
  size_t warnings = 0;
  for (const auto& diagnostic : r.statistics["diagnostics"])
    for (const HintDescription& h : hints)
      warnings += diagnostic["severity"] == "warning" && diagnostic["object"] == h.name;
  EXPECT_EQ(warnings, hints.size() - 1);
}

}  // namespace ajar::test_hint_mutation
