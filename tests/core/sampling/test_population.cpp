#include "agreement.h"
#include "gate.h"
#include "integrators/integrator.h"
#include "sampling/population.h"
#include "transport/bidirectional/path_seeds.h"
#include "transport/paths/compact_path.h"
#include "transport/paths/film_luminance.h"

namespace ajar::test_population {

using namespace fixtures;

namespace {

const std::vector<TransportScene> kScenes = transport_scenes();

/// A target on the integers 0 .. 9 with known sums, and a Metropolis step to a neighbour that keeps the target
/// stationary.
constexpr int kStates = 10;
double target(int x) { return double((x * 7) % kStates) + (x == 3 ? 20.0 : 0.5); }
double importance(int x) { return x < 5 ? 1.0 : 4.0; }
int metropolis_step(int x, bool important, Pcg32& rng) {
  const int y = (x + (rng.next_float() < 0.5f ? 1 : kStates - 1)) % kStates;
  const double ratio = target(y) / target(x) * (important ? importance(y) / importance(x) : 1.0);
  return double(rng.next_float()) < ratio ? y : x;
}
struct ToyMember {
  int x;
  double weight;
};
/// Tests over many replicates that the sum of weights at each state has the expectation `target`. `run` creates the
/// population.
template <class Run>
void expect_properly_weighted(Run&& run) {
  std::array<RunningMoments, kStates> sums;
  for (uint64_t replicate = 0; replicate < 40000; ++replicate) {
    Pcg32 rng(replicate, 11);
    std::array<double, kStates> sum{};
    for (const ToyMember& m : run(rng)) sum[size_t(m.x)] += m.weight;
    for (int x = 0; x < kStates; ++x) sums[size_t(x)].add(sum[size_t(x)]);
  }
  for (int x = 0; x < kStates; ++x) {
    RunningMoments exact;
    const double error = std::sqrt(sums[size_t(x)].variance_of_mean());
    EXPECT_LT(error, 0.05 * target(x)) << "the test is too weak at " << x;
    EXPECT_NEAR(sums[size_t(x)].mean(), target(x), 4.0 * error) << "state " << x;
  }
}
/// Uniform draws with the weights f / p.
std::vector<ToyMember> fresh(int n, Pcg32& rng) {
  std::vector<ToyMember> members;
  for (int i = 0; i < n; ++i) {
    const int x = std::min(int(rng.next_float() * float(kStates)), kStates - 1);
    members.push_back({x, target(x) * kStates / n});
  }
  return members;
}
std::vector<ToyMember> resampled(const std::vector<ToyMember>& members, size_t n, Pcg32& rng) {
  std::vector<double> weights;
  for (const ToyMember& m : members) weights.push_back(m.weight);
  std::vector<uint32_t> parents(n);
  const double total = systematic_resample(weights, double(rng.next_float()), parents);
  std::vector<ToyMember> drawn;
  for (uint32_t parent : parents) drawn.push_back({members[parent].x, total / double(n)});
  return drawn;
}

}  // namespace

TEST(Population, resampling_keeps_every_expectation) {
  expect_properly_weighted([](Pcg32& rng) { return resampled(resampled(fresh(6, rng), 9, rng), 4, rng); });
}
TEST(Population, mutation_keeps_every_expectation) {
  expect_properly_weighted([](Pcg32& rng) {
    auto members = fresh(6, rng);
    for (ToyMember& m : members)
      for (int step = 0; step < 3; ++step) m.x = metropolis_step(m.x, false, rng);
    return members;
  });
}
TEST(Population, new_members_mixed_in_keep_every_expectation) {
  expect_properly_weighted([](Pcg32& rng) {
    double known = 0.0;
    std::vector<ToyMember> members;
    for (int generation = 0; generation < 4; ++generation) {
      const double share = new_share(3.0, known, 0.4);
      for (ToyMember& m : members) m.weight *= 1.0 - share;
      for (ToyMember m : fresh(3, rng)) members.push_back({m.x, m.weight * share});
      known += 3.0;
      members = resampled(members, 5, rng);
      for (ToyMember& m : members) m.x = metropolis_step(m.x, false, rng);
    }
    return members;
  });
}
TEST(Population, another_target_for_the_mutations_keeps_every_expectation) {
  expect_properly_weighted([](Pcg32& rng) {
    auto members = fresh(6, rng);
    for (ToyMember& m : members) m.weight *= importance(m.x);
    members = resampled(members, 6, rng);
    for (ToyMember& m : members)
      for (int step = 0; step < 3; ++step) m.x = metropolis_step(m.x, true, rng);
    for (ToyMember& m : members) m.weight /= importance(m.x);
    return members;
  });
}

TEST(Population, systematic_resampling_differs_from_the_expected_count_by_less_than_one) {
  Pcg32 rng(3);
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<double> weights(20);
    for (double& w : weights) w = rng.next_float() < 0.3f ? 0.0 : std::pow(double(rng.next_float()), 4.0);
    std::vector<uint32_t> parents(33);
    const double total = systematic_resample(weights, double(rng.next_float()), parents);
    std::vector<int> counts(weights.size(), 0);
    for (uint32_t parent : parents) ++counts[parent];
    for (size_t i = 0; i < weights.size(); ++i) {
      EXPECT_LT(std::abs(counts[i] - 33.0 * weights[i] / total), 1.0 + 1e-9);
      if (weights[i] == 0.0) {
        EXPECT_EQ(counts[i], 0);
      }
    }
    EXPECT_TRUE(std::is_sorted(parents.begin(), parents.end()));
  }
  std::vector<uint32_t> parents(4);
  EXPECT_EQ(systematic_resample(std::vector<double>{0.0, 0.0}, 0.5, parents), 0.0);
  EXPECT_EQ(systematic_resample(std::vector<double>{}, 0.5, parents), 0.0);
}

TEST(Population, neighbours_along_the_hilbert_curve_are_neighbours_in_the_plane) {
  constexpr int kSide = 32;
  std::vector<std::pair<uint32_t, Vec2>> cells;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const Vec2 p((float(x) + 0.5f) / kSide, (float(y) + 0.5f) / kSide);
      cells.push_back({hilbert_index(p.x, p.y), p});
    }
  std::sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (size_t i = 1; i < cells.size(); ++i)
    EXPECT_NEAR(glm::length(cells[i].second - cells[i - 1].second), 1.0f / kSide, 1e-5f);
}

TEST(CompactPath, unpacks_to_the_path_that_was_packed) {
  for (const char* name : {"polished", "see_through", "environment", "textured_emission"}) {
    const auto named = std::find_if(kScenes.begin(), kScenes.end(),
                                    [&](const TransportScene& s) { return s.name == name; });
    const auto scene = build(named->description);
    const PathSpace space(*scene, 0, 0, 12, 12, true);
    PathSeeds seeds(space);
    Sampler sampler(Sampler::Kind::Independent, 3);
    auto path = std::make_unique<Path>(), back = std::make_unique<Path>();
    int found = 0;
    for (uint32_t i = 0; found < 300; ++i) {
      sampler.start(i, 0);
      if (!(seeds.sample(sampler) > 0.0) || !seeds.take(0.5, *path)) continue;
      ++found;
      CompactPath compact;
      compact.pack(*path);
      EXPECT_LT(compact.bytes(), size_t(path->count) * 400 + 200);
      compact.unpack(*back);
      EXPECT_EQ(back->target, path->target);
      EXPECT_EQ(shared_ends(*path, *back).light, path->count);
      // All quantities that are computed from the vertices, above all their surfaces, are bitwise equal.
      ASSERT_TRUE(space.complete(*path, 1, path->count - 2));
      ASSERT_TRUE(space.complete(*back, 1, back->count - 2)) << name;
      EXPECT_EQ(back->target, path->target) << name;
      EXPECT_TRUE(back->f == path->f) << name;
    }
  }
}

TEST(FilmLuminance, importance_falls_with_the_total_luminance) {
  FilmLuminance film(Vec2(0.0f), Vec2(64.0f, 32.0f), 2.0f);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) {
      const Vec2 at(float(x) + 0.5f, float(y) + 0.5f);
      film.add_flux(at, 3.0 * (x < 32 ? 0.1 : 1.0));
      film.add_sample(at, x < 32 ? 0.0 : 0.5);
    }
  const FilmImportance importance = film.importance(3.0);
  EXPECT_NEAR(importance.at(Vec2(8.0f, 16.0f)), 1.0f / std::sqrt(0.04f + 0.01f), 1e-4f);
  EXPECT_NEAR(importance.at(Vec2(56.0f, 16.0f)), 1.0f / std::sqrt(9.0f + 0.01f), 1e-4f);
  EXPECT_GT(importance.at(Vec2(30.0f, 16.0f)), importance.at(Vec2(34.0f, 16.0f)));
  EXPECT_NEAR(film.flux(FilmImportance()), 3.0 * 32.0 * 32.0 * 1.1, 1e-2);
  EXPECT_NEAR(film.flux(FilmImportance(Vec2(0.0f), Vec2(64.0f, 32.0f), 2, 1, {2.0f, 2.0f})),
              2.0 * film.flux(FilmImportance()), 1e-2);
  const FilmImportance left(Vec2(0.0f), Vec2(64.0f, 32.0f), 8, 1, {1, 1, 1, 1, 0, 0, 0, 0});
  EXPECT_NEAR(film.flux(left), 3.0 * 32.0 * 32.0 * 0.1, 1e-2);
  EXPECT_EQ(FilmImportance().at(Vec2(3.0f)), 1.0f);
}

/// Lamps of negative power give negative samples. This includes values beyond the range of the sums.
TEST(FilmLuminance, negative_samples_give_the_same_importance_as_positive_ones) {
  float seen[2];
  for (int side = 0; side < 2; ++side) {
    FilmLuminance film(Vec2(0.0f), Vec2(8.0f, 8.0f), 1.0f);
    film.add_sample(Vec2(1.0f, 1.0f), side ? -1e30 : 1e30);
    film.add_sample(Vec2(1.0f, 1.0f), side ? -2.0 : 2.0);
    film.add_sample(Vec2(1.0f, 1.0f), std::nan(""));
    seen[side] = film.importance(1.0).at(Vec2(1.0f, 1.0f));
  }
  EXPECT_GT(seen[0], 0.0f);
  EXPECT_EQ(seen[0], seen[1]);
}

class PopulationPathsOf : public ::testing::TestWithParam<size_t> {};
TEST_P(PopulationPathsOf, have_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 0)) GTEST_SKIP() << kLeftOut;
  expect_agreement(kScenes[GetParam()], "pmc_pt", 32, int(kScenes.size()));
}
INSTANTIATE_TEST_SUITE_P(Scenes, PopulationPathsOf, ::testing::Range<size_t>(0, kScenes.size()),
                         [](const auto& info) { return kScenes[info.param].name; });

TEST(PopulationPaths, learning_in_tiny_populations_does_not_move_the_mean) {
  // 64 members and 12 generations; the shares and the importance are used after four. The test would detect a bias of 6
  // %.
  const SceneDescription& d = kScenes[0].description;
  const RunningMoments expected = whole(d, "path", 64, 16, 1000), actual = whole(d, "pmc_pt", 10, 200, 2000);
  EXPECT_LT(std::sqrt(expected.variance_of_mean() + actual.variance_of_mean()), 0.018 * expected.mean());
  EXPECT_TRUE(statistical::means_agree(expected, actual, {0.01, 1}))
      << "path " << expected.mean() << ", pmc_pt " << actual.mean();
}

TEST(PopulationPaths, the_image_does_not_depend_on_threads_or_the_division_into_iterations) {
  SceneDescription d = kScenes[1].description;
  d.settings.width = 40;
  d.settings.height = 33;
  const auto one = render(d, "pmc_pt", 12, 5, 1);
  EXPECT_EQ(one, render(d, "pmc_pt", 12, 5, 2));
  EXPECT_EQ(one, render(d, "pmc_pt", 12, 5, 8));
  EXPECT_NE(one, render(d, "pmc_pt", 12, 6, 2));
  // A session starts with single samples. One iteration with all samples gives the same image.
  const std::atomic<bool> stop{false};
  const auto integrator = make_integrator("pmc_pt");
  d.settings.seed = 5;
  const auto scene = build(d);
  Film film(0, 0, 40, 33, {"Combined"});
  integrator->prepare(scene, 5);
  integrator->run_iteration(film, 12, stop);
  EXPECT_EQ(one, film.resolve("Combined", 1.0f));
  const auto extra = integrator->statistics().extra;
  EXPECT_GT(extra.at("bytes_per_member"), 1000.0);
  EXPECT_LT(extra.at("bytes_per_member"), 20000.0);
}

TEST(PopulationPaths, a_scene_without_light_is_black) {
  for (float value : render(grey_room(), "pmc_pt", 2, 1)) EXPECT_TRUE(value == 0.0f || value == 1.0f);
  SceneDescription nothing;
  set_camera(nothing, Vec3(0, -1, 0), Vec3(0), 8, 0.7f);
  for (float value : render(nothing, "pmc_pt", 2, 1)) EXPECT_TRUE(value == 0.0f || value == 1.0f);
}

}  // namespace ajar::test_population
