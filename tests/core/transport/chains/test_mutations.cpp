#include <gtest/gtest.h>

#include <map>
#include <string>

#include "math/statistics.h"
#include "transport/bidirectional/bidirectional.h"
#include "transport/chains/chain.h"
#include "transport/chains/mutations/bidirectional_mutation.h"
#include "transport/chains/mutations/caustic_perturbation.h"
#include "transport/chains/mutations/lens_perturbation.h"
#include "transport_scenes.h"

namespace ajar::test_mutations {

using namespace fixtures;

namespace {

std::shared_ptr<const Scene> scene_named(const std::string& name, int size) {
  for (TransportScene& s : transport_scenes()) {
    if (s.name != name) continue;
    s.description.settings.width = s.description.settings.height = size;
    return build(s.description);
  }
  return nullptr;
}

/// A path space with one mutation of each type.
struct Kernels {
  std::shared_ptr<const Scene> scene;
  PathSpace space;
  std::vector<std::unique_ptr<Mutation>> all;

  explicit Kernels(const std::string& name, bool without_direct = true, int size = 12)
      : scene(scene_named(name, size)), space(*scene, 0, 0, size, size, without_direct) {
    all.push_back(std::make_unique<BidirectionalMutation>(space));
    all.push_back(std::make_unique<LensPerturbation>(space));
    all.push_back(std::make_unique<CausticPerturbation>(space));
  }

  /// Returns the first path that `wanted` accepts.
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

const char* const kSceneNames[] = {"area_lamp",   "glass_ball",  "rough_glass_and_mirror",
                                   "polished",    "point_light", "sun",
                                   "environment", "thin_lens",   "see_through"};

}  // namespace

class MutationsOf : public ::testing::TestWithParam<const char*> {};

TEST_P(MutationsOf, proposals_have_a_density_in_both_directions_and_keep_the_shared_vertices) {
  const Kernels k(GetParam());
  auto to = std::make_unique<Path>();
  Sampler sampler(Sampler::Kind::Independent, 3);
  sampler.start(0, 0);
  uint64_t rays = 0, proposed[3] = {}, unpaired[3] = {}, unknown[3] = {};
  for (uint32_t start = 0; start < 40; ++start) {
    const auto from = k.find([](const Path&) { return true; }, start);
    ASSERT_TRUE(from);
    for (size_t m = 0; m < k.all.size(); ++m) {
      if (!k.all[m]->suits(*from)) continue;
      for (int i = 0; i < 200; ++i) {
        if (!k.all[m]->sample(*from, sampler, *to, rays)) continue;
        ++proposed[m];
        ASSERT_GT(to->target, 0.0);
        const double there = k.all[m]->pdf(*from, *to), back = k.all[m]->pdf(*to, *from);
        ASSERT_TRUE(std::isfinite(there) && std::isfinite(back));
        if (!(there > 0.0)) ++unknown[m];
        if (!(back > 0.0)) ++unpaired[m];
        const SharedEnds shared = shared_ends(*from, *to);
        EXPECT_GE(shared.light + shared.eye, int(m));
        // The contribution and the densities depend on the path alone.
        auto copy = std::make_unique<Path>(*to);
        ASSERT_TRUE(k.space.complete(*copy, 1, copy->count - 2));
        EXPECT_NEAR(copy->target, to->target, 1e-3 * to->target);
      }
    }
  }
  // The reverse step can be impossible: an angle that is too large from the other path, or a direction lost by
  // rounding. Such steps are refused, and are rare.
  for (size_t m = 0; m < k.all.size(); ++m) EXPECT_LE(unpaired[m], proposed[m] / 4) << k.all[m]->name();
  // Rounding may move a step out of its range.
  for (size_t m = 0; m < k.all.size(); ++m) EXPECT_LE(unknown[m], 1 + proposed[m] / 500) << k.all[m]->name();
  EXPECT_GT(proposed[0], 100u);
}
INSTANTIATE_TEST_SUITE_P(Scenes, MutationsOf, ::testing::ValuesIn(kSceneNames),
                         [](const auto& info) { return std::string(info.param); });

/// The expectation of 1 / pdf over proposals that move one vertex into a region is the area of the region. This tests
/// that the density is correct in its measure.
class DensityOf : public ::testing::TestWithParam<int> {};

TEST_P(DensityOf, one_over_the_density_integrates_to_the_area_of_a_region) {
  const Kernels k("area_lamp", false, 48);  // larger than the minimum edge length in pixels
  const Mutation& mutation = *k.all[size_t(GetParam())];
  // The path is light, another wall, visible back wall, lens. Vertex 2 moves within a patch.
  const auto in_region = [](Vec3 p) {
    return std::abs(p.y - 1.0f) < 1e-3f && std::abs(p.x + 0.2f) < 0.1f && std::abs(p.z - 0.3f) < 0.1f;
  };
  const auto from = k.find([&](const Path& p) {
    const Vec3 wall = p.vertices[1].position();
    return p.count == 4 && in_region(p.vertices[2].position()) && wall.z > 0.2f && wall.y < 0.5f;
  });
  ASSERT_TRUE(from);
  auto to = std::make_unique<Path>();
  Sampler sampler(Sampler::Kind::Independent, 5);
  sampler.start(0, 0);
  uint64_t rays = 0;
  RunningMoments moments;
  for (int i = 0; i < (GetParam() == 0 ? 800000 : 300000); ++i) {
    double value = 0.0;
    if (mutation.sample(*from, sampler, *to, rays) && to->count == 4 && in_region(to->vertices[2].position())) {
      const SharedEnds shared = shared_ends(*from, *to);
      const double pdf = mutation.pdf(*from, *to);
      if (shared.light == 2 && shared.eye == 1 && pdf > 0.0)
        value = 1.0 / pdf;  // pdf is 0 where rounding leaves the range
    }
    moments.add(value);
  }
  // Perturbations have a minimum step, so that a hole around the vertex is never reached.
  const double smallest = double(LogarithmicStep::on_film(k.space).smallest);
  const double hole = GetParam() == 0 ? 0.0 : M_PI * smallest * smallest / (from->film_density * from->eye_step(2));
  EXPECT_NEAR(moments.mean(), 0.04 - hole, 4.0 * std::sqrt(moments.variance_of_mean()) + 0.25 * hole);
  EXPECT_LT(std::sqrt(moments.variance_of_mean()), GetParam() == 0 ? 0.004 : 0.0005);
}
INSTANTIATE_TEST_SUITE_P(Kernels, DensityOf, ::testing::Range(0, 3));

/// Chains that mostly use one perturbation have the same distribution as chains without it.
class StationaryFor : public ::testing::TestWithParam<std::tuple<int, const char*>> {};

TEST_P(StationaryFor, the_distribution_of_a_chain_is_that_of_its_target) {
  const auto [favoured, name] = GetParam();
  const Kernels k(name);
  const auto visits = [&](float share, uint32_t seed) {
    std::vector<MutationShare> shares;
    shares.push_back({std::make_unique<BidirectionalMutation>(k.space), 1.0f - share});
    if (favoured == 1)
      shares.push_back({std::make_unique<LensPerturbation>(k.space), share});
    else
      shares.push_back({std::make_unique<CausticPerturbation>(k.space), share});
    // Several chains from arbitrary paths. The burn-in removes the influence of the start.
    std::array<double, 4> sums{};
    for (uint32_t c = 0; c < 4; ++c) {
      Chain chain(shares);
      chain.start(*k.find([](const Path&) { return true; }, seed * 16 + c));
      Sampler sampler(Sampler::Kind::Independent, seed);
      sampler.start(c, 0);
      constexpr int kBurnIn = 3000, kSteps = 12000;
      for (int i = 0; i < kBurnIn + kSteps; ++i)
        chain.step(sampler, [&](const Path& p, double weight) {
          if (i < kBurnIn) return;
          weight /= 4.0 * kSteps;
          sums[0] += weight * (p.film.x < 6.0f);
          sums[1] += weight * (p.film.y < 6.0f);
          sums[2] += weight * (p.count <= 4);
          sums[3] += weight * (first_joinable_from_eye(p) < p.count - 2);
        });
    }
    return sums;
  };
  using Moments = std::array<RunningMoments, 4>;
  const auto moments = [&](float share, uint32_t first_seed) {
    Moments found;
    for (uint32_t seed = first_seed; seed < first_seed + 12; ++seed) {
      const auto sums = visits(share, seed);
      for (size_t i = 0; i < 4; ++i) found[i].add(sums[i]);
    }
    return found;
  };
  // The chains of bidirectional mutations alone are those of both favoured perturbations.
  static std::map<std::string, Moments> known;
  if (!known.contains(name)) known[name] = moments(0.0f, 1);
  const Moments &plain = known[name], mixed = moments(0.8f, 101);
  for (size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(plain[i].mean(), mixed[i].mean(),
                4.5 * std::sqrt(plain[i].variance_of_mean() + mixed[i].variance_of_mean()) + 1e-4)
        << "statistic " << i;
}
INSTANTIATE_TEST_SUITE_P(Kernels, StationaryFor,
                         ::testing::Combine(::testing::Values(1, 2),
                                            ::testing::Values("glass_ball", "rough_glass_and_mirror", "polished",
                                                              "sun")));

}  // namespace ajar::test_mutations
