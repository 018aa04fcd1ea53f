#include <gtest/gtest.h>

#include "gate.h"
#include "hint_fixtures.h"
#include "statistical.h"
#include "transport/bidirectional/bidirectional.h"
#include "transport/hints/followed_hints.h"
#include "transport/paths/path.h"
#include "transport/photons/photon_tracer.h"

namespace ajar::test_hint_guide {

using namespace fixtures;

namespace {

/// A scene after the pilot of its hints.
struct Guided {
  std::shared_ptr<const Scene> scene;
  PathSpace space;
  FollowedHints followed;

  Guided(SceneDescription d, std::vector<HintDescription> described, uint32_t seed = 1)
      : scene([&] {
          d.hints = std::move(described);
          return build(d);
        }()),
        space(*scene, 0, 0, 12, 12, true) {
    std::atomic<bool> stop{false};
    followed.begin(std::make_shared<const AttachedHints>(attach_hints(space.scene)), space, seed, stop);
  }
};

const HintDescription kThrough = hint("Through", {kLamp, {1.0f, 0.0f, -0.167f}}, 0.12f);
const HintDescription kTwice = hint("Twice", {kLamp, {0.7f, 0.3f, 0.5f}, {0.1f, -0.2f, 1.0f}}, 0.3f);

}  // namespace

/// The expectation of 1 / pdf over starts in a region is the measure of the region: the area of the lamp times the
/// solid angle of a cone.
TEST(HintGuide, starts_have_the_density_of_the_mixture) {
  SceneDescription d = keyhole();
  LightDescription other = d.lights[0];
  other.world_from_light = rows(shining(Vec3(0.5f, 0.5f, 0.9f), Vec3(0, 0, -1)));
  d.lights.push_back(other);
  d.hints = {kThrough, kTwice};
  const auto scene = build(d);
  std::vector<HintReport> reports;
  const Hints hints = Hints::attach(*scene, reports);
  ASSERT_EQ(hints.size(), 2u);
  const HintGuide guide(hints);
  const double lamp_area = 0.01;
  struct Region {
    const char* what;
    uint32_t light;
    Vec3 axis;
    float one_minus_cos;
  };
  const Vec3 through = glm::normalize(Vec3(1.0f, 0.0f, -0.167f) - kLamp);
  for (const Region region : {Region{"the hint's own", 0, through, 0.004f},
                              {"around the hint", 0, through, 0.05f},
                              {"elsewhere", 0, glm::normalize(Vec3(0.6f, -0.6f, -0.3f)), 0.1f},
                              {"the other lamp", 1, Vec3(0, 0, -1), 0.3f}}) {
    RunningMoments moments;
    Sampler sampler(Sampler::Kind::Independent, 3);
    PathVertex light, next;
    next.kind = VertexKind::Lens;
    for (uint32_t i = 0; i < 200000; ++i) {
      sampler.start(i, 0);
      const float u = sampler.get_1d();
      const Vec2 a = sampler.get_2d(), b = sampler.get_2d();
      Ray ray;
      double value = 0.0;
      if (start_at_light(*scene, &guide, {u, a, b}, 0.0f, light, ray) && uint32_t(light.light) == region.light &&
          0.5f * length_squared(ray.direction - region.axis) <= region.one_minus_cos) {
        PathEdge edge;
        edge.to_eye = ray.direction;
        const LightEnd end = light_end(*scene, light, next, edge, &guide);
        ASSERT_GT(end.pdf_origin * end.pdf_direction, 0.0f);
        value = 1.0 / (double(end.pdf_origin) * double(end.pdf_direction));
      }
      moments.add(value);
    }
    EXPECT_TRUE(statistical::mean_agrees(moments, lamp_area * 2.0 * M_PI * double(region.one_minus_cos), {0.01, 4}))
        << region.what;
  }
}

/// The density at a bounce includes the probability that a hint is followed; the rest is the share of the BSDF.
TEST(HintGuide, directions_at_a_bounce_have_their_density) {
  const Guided g(keyhole(), {kTwice});
  std::vector<HintReport> reports;
  const Hints hints = Hints::attach(*g.scene, reports);
  const HintGuide guide(hints);
  const Vec3 at = hints[0].vertices[1].position, far = at + Vec3(0.0f, 0.0f, -1.4f);
  EXPECT_EQ(guide.share_at(far), 0.0f);
  EXPECT_EQ(guide.pdf_at(far, Vec3(0, 0, 1)), 0.0f);
  const float share = guide.share_at(at);
  ASSERT_GT(share, 0.0f);
  RunningMoments taken, measure;
  Sampler sampler(Sampler::Kind::Independent, 5);
  for (uint32_t i = 0; i < 100000; ++i) {
    sampler.start(i, 0);
    float u = sampler.get_1d();
    const auto direction = guide.direction_at(at, u, sampler.get_2d());
    taken.add(direction ? 1.0 : 0.0);
    EXPECT_TRUE(u >= 0.0f && u < 1.0f);
    if (direction) {
      EXPECT_GT(guide.pdf_at(at, *direction), 0.0f);
    }
    measure.add(direction && guide.pdf_at(at, *direction) > 0.0f ? 1.0 / double(guide.pdf_at(at, *direction)) : 0.0);
  }
  EXPECT_TRUE(statistical::mean_agrees(taken, double(share), {0.01, 2}));
  // The solid angle of the cone, since the density includes the probability that the hint is followed.
  EXPECT_TRUE(statistical::mean_agrees(measure, 2.0 * M_PI * double(hints[0].one_minus_cos[1]), {0.01, 2}));
}

TEST(HintGuide, learns_which_hints_find_light) {
  const HintDescription above = hint("Stays above", {kLamp, {1.0f, 0.0f, 0.7f}}, 0.1f);
  const Guided good(keyhole(true), {kThrough, above});
  ASSERT_NE(good.followed.guide(), nullptr);
  const auto statistics = good.followed.statistics();
  ASSERT_EQ(statistics.size(), 2u);
  EXPECT_GT(statistics[0].energy_share, 0.3);
  EXPECT_LT(statistics[1].energy_share, 0.05);
  EXPECT_GT(good.followed.mutation_use(), 0.5f);
  const Guided useless(keyhole(true), {above});
  EXPECT_EQ(useless.followed.guide(), nullptr);
  EXPECT_LT(useless.followed.mutation_use(), 0.2f);
  const Guided none(keyhole(), {});
  EXPECT_EQ(none.followed.guide(), nullptr);
  EXPECT_EQ(none.followed.rays(), 0u);
  EXPECT_TRUE(none.followed.statistics().empty());
}

class HintedIntegrator : public ::testing::TestWithParam<const char*> {};

TEST_P(HintedIntegrator, has_the_same_mean_with_good_useless_and_wrong_hints) {
  // Mutations by hints have a test of their own (HintMutations).
  if (std::string(GetParam()) == "metropolis" && gate_only()) GTEST_SKIP() << kLeftOut;
  const std::vector<HintDescription> bounced = {
      kTwice, hint("Off the ceiling", {kLamp, {-0.3f, 0.2f, 0.5f}, {0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, -1.0f}}, 0.15f),
      kThrough};
  const std::pair<const char*, std::vector<HintDescription>> sets[] = {
      {"good", kGood}, {"bounced", bounced}, {"useless", kUseless}, {"wrong", kWrong}};
  SceneDescription d = keyhole();
  d.settings.vertex_merging = Merging::Off;
  constexpr int kSeeds = 24, kSamples = 12;
  const Rendered none = render_hinted(d, {}, 2 * kSeeds, 1, 2 * kSamples, GetParam());
  uint32_t first_seed = 1000;
  for (const auto& [name, hints] : sets) {
    const Rendered with = render_hinted(d, hints, kSeeds, first_seed += 1000, kSamples, GetParam());
    for (size_t i = 0; i < 27; ++i)
      EXPECT_TRUE(statistical::means_agree(none.blocks[i], with.blocks[i], {0.01, 4 * 27})) << name << ", value " << i;
  }
}

/// A sphere lamp. Hints propose the half that faces them; the other half emits in other directions.
TEST_P(HintedIntegrator, follows_hints_from_lamps_with_extent) {
  SceneDescription d = keyhole(true);
  d.settings.vertex_merging = Merging::Off;
  d.lights[0].kind = LightKind::Point;
  d.lights[0].radius = 0.08f;
  constexpr int kSeeds = 24, kSamples = 12;
  const Rendered none = render_hinted(d, {}, 2 * kSeeds, 1, 2 * kSamples, GetParam()),
                 with = render_hinted(d, kGood, kSeeds, 1000, kSamples, GetParam());
  for (size_t i = 0; i < 27; ++i)
    EXPECT_TRUE(statistical::means_agree(none.blocks[i], with.blocks[i], {0.01, 27})) << "value " << i;
}
// Photon maps are not tested, since they are biased with few passes.
INSTANTIATE_TEST_SUITE_P(All, HintedIntegrator, ::testing::Values("bdpt", "erpt", "metropolis", "pmc_pt"),
                         [](const auto& info) { return std::string(info.param); });

namespace {

/// The variance between seeds divided by the squared mean, averaged over the blocks.
double relative_variance(const Rendered& r) {
  double sum = 0.0;
  for (const RunningMoments& m : r.blocks) sum += m.variance() / (m.mean() * m.mean());
  return sum / double(r.blocks.size());
}

}  // namespace

class HintedThreads : public ::testing::TestWithParam<const char*> {};

TEST_P(HintedThreads, do_not_change_the_image) {
  SceneDescription d = keyhole();
  d.hints = {kThrough, kTwice};
  d.settings.integrator = GetParam();
  d.settings.samples = 3;
  std::vector<std::vector<float>> images;
  for (int threads : {1, 2, 5}) {
    d.settings.threads = threads;
    Session session;
    session.start(d);
    ASSERT_TRUE(session.wait(kHang));
    ASSERT_EQ(session.take_error(), "");
    images.push_back(session.snapshot("Combined"));
  }
  EXPECT_EQ(images[0], images[1]);
  EXPECT_EQ(images[0], images[2]);
}
INSTANTIATE_TEST_SUITE_P(Integrators, HintedThreads,
                         ::testing::Values("bdpt", "erpt", "photon_map", "mps", "metropolis", "pmc_pt"),
                         [](const auto& info) { return std::string(info.param); });

class HintsThroughAHole : public ::testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(HintsThroughAHole, reduce_the_variance_by_a_factor) {
  const auto [integrator, gain] = GetParam();
  const Rendered none = render_hinted(keyhole(true), {}, 24, 1, 8, integrator),
                 good = render_hinted(keyhole(true), kGood, 24, 1000, 8, integrator);
  EXPECT_GT(relative_variance(none), gain * relative_variance(good));
}
INSTANTIATE_TEST_SUITE_P(Integrators, HintsThroughAHole,
                         ::testing::Values(std::pair{"bdpt", 2.0}, std::pair{"erpt", 2.0}, std::pair{"pmc_pt", 1.5}),
                         [](const auto& info) { return std::string(info.param.first); });

class HintedPhotons : public ::testing::TestWithParam<bool> {};

TEST_P(HintedPhotons, have_the_power_of_the_lamps_with_and_without_hints) {
  SceneDescription d = keyhole(true);
  if (GetParam()) {
    d.lights[0].kind = LightKind::Point;
    d.lights[0].radius = 0.08f;
  }
  std::array<RunningMoments, 2> watts, below;
  for (int hinted = 0; hinted < 2; ++hinted) {
    const Guided g(d, hinted ? std::vector<HintDescription>{kThrough, kTwice} : std::vector<HintDescription>{});
    if (hinted) {
      ASSERT_NE(g.followed.guide(), nullptr);
    }
    for (uint32_t pass = 0; pass < 24; ++pass) {
      PhotonEmission emission;
      emission.plan = plan_photons(*g.scene);
      emission.seed = 7 + uint32_t(hinted);
      emission.pass = pass;
      emission.count = 4000;
      emission.guide = g.followed.guide();
      std::atomic<bool> stop{false};
      const PhotonBatch batch = trace_photons(*g.scene, nullptr, emission, stop);
      watts[size_t(hinted)].add(batch.emitted[1]);
      double flux = 0.0;
      for (const Photon& photon : batch.global)
        if (photon.point.position.z < 0.45f) flux += double(photon.flux_over_cosine[1]);
      below[size_t(hinted)].add(flux);
    }
  }
  EXPECT_TRUE(statistical::means_agree(watts[0], watts[1], {0.01, 2}));
  EXPECT_TRUE(statistical::means_agree(below[0], below[1], {0.01, 2}));
  if (!GetParam()) {  // for a sphere, most of the light comes from the walls
    EXPECT_GT(below[0].variance(), 2.0 * below[1].variance());
  }
}
INSTANTIATE_TEST_SUITE_P(Lamps, HintedPhotons, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "sphere" : "area"; });

}  // namespace ajar::test_hint_guide
