// Unconnectable paths count once: the walks omit them, and photons find them with the same mean.
#include "agreement.h"
#include "integrators/render_plan.h"
#include "transport/bidirectional/bidirectional.h"
#include "transport/bidirectional/vertex_merging.h"
#include "transport/paths/path.h"

namespace ajar::test_vertex_merging {

using namespace fixtures;

namespace {

const std::atomic<bool> kGoOn{false};

/// In a grey room, a mirror fills most of the image, and a pane of glass is below a wide lamp. Most of the light in the
/// mirror comes by unconnectable paths, and walks from the eye often hit the lamp.
SceneDescription pane_and_mirror(float photon_radius = 0.04f) {
  SceneDescription d = grey_room();
  MeshDescription pane = cube();
  for (Vec3& p : pane.positions) p.z *= 0.03f;
  add_object(d, pane, add_glass(d, 0.0f), moved(Vec3(0.0f, 0.0f, 0.7f), 0.9f));
  add_object(d, plane(0.8f), add_glossy(d, 0.0f), shining(Vec3(0.1f, 0.6f, -0.1f), Vec3(0.1f, 1.0f, 0.2f)));
  d.lights.push_back(area_lamp(Vec3(0.0f, 0.0f, 0.95f), Vec3(0, 0, -1), 1.2f, 8.0f));
  d.settings.vertex_merging = Merging::On;
  d.settings.photon_radius = photon_radius;
  d.settings.photons = 2000;
  return d;
}
/// The same scene with surfaces that are half mirrors and half diffuse, so that both types of events occur at one
/// surface.
SceneDescription mixed_surfaces() {
  SceneDescription d = pane_and_mirror();
  d.objects.back().materials = {add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.0f)};
  d.objects.front().materials = d.objects.back().materials;
  return d;
}
/// The same scene in a black room, with a large disc in which photons are looked up.
SceneDescription in_black_room() {
  SceneDescription d = pane_and_mirror(0.15f);
  d.objects.front().materials = {add_diffuse(d, Color(0.0f))};
  return d;
}
/// Narrow slats are lit, much narrower than the disc.
SceneDescription slats_and_mirror() {
  SceneDescription d = in_black_room();
  const int slat = add_diffuse(d, Color(0.8f));
  for (int k = 0; k < 8; ++k) {
    Mat4 place = moved(Vec3(0.2f * float(k) - 0.7f, 0.0f, -0.3f), 0.7f);
    place[0] *= 0.05f;  // 7 cm
    add_object(d, plane(1.0f), slat, place);
  }
  return d;
}
/// Pebbles are lit: flat ellipsoids about as large as the disc.
SceneDescription pebbles_and_mirror() {
  SceneDescription d = in_black_room();
  const int pebble = add_diffuse(d, Color(0.8f));
  for (int k = 0; k < 25; ++k) {
    Mat4 place = moved(Vec3(0.3f * float(k % 5) - 0.6f, 0.3f * float(k / 5) - 0.6f, -0.3f), 0.1f);
    place[2] *= 0.3f;
    add_object(d, sphere(), pebble, place);
  }
  return d;
}

/// The mirror shows a floor below a pane of glass, under an open sky without light.
SceneDescription open_pane_and_mirror() {
  SceneDescription d = pane_and_mirror();
  d.meshes.front() = plane(1.0f);
  d.instances.front().world_from_object = rows(moved(Vec3(0.0f, 0.0f, -0.8f)));
  d.lights.clear();
  return d;
}
SceneDescription lit_by_sun(float angle) {
  SceneDescription d = open_pane_and_mirror();
  LightDescription sun;
  sun.name = "Sun";
  sun.kind = LightKind::Sun;
  sun.energy = 3.0f;
  sun.sun_angle = angle;
  sun.world_from_light = rows(shining(Vec3(0.0f), Vec3(0.1f, 0.2f, -1.0f)));
  d.lights.push_back(sun);
  return d;
}
/// A disc of the sky has the radiance 3; `least_cosine` is the cosine of its radius.
SceneDescription lit_by_sky(float least_cosine) {
  SceneDescription d = open_pane_and_mirror();
  GraphBuilder b;
  const int direction = b.node("ShaderNodeTexCoord");
  const int cosine = b.node("ShaderNodeVectorMath",
                            {linked_input("Vector", direction, "Generated"),
                             value_input("Vector_001", Vec4(glm::normalize(Vec3(-0.1f, -0.2f, 1.0f)), 0.0f))},
                            {text_property("operation", "DOT_PRODUCT")});
  const int inside = b.node("ShaderNodeMath",
                            {linked_input("Value", cosine, "Value"), value_input("Value_001", least_cosine)},
                            {text_property("operation", "GREATER_THAN")});
  const int strength = b.node("ShaderNodeMath",
                              {linked_input("Value", inside, "Value"), value_input("Value_001", 3.0f)},
                              {text_property("operation", "MULTIPLY")});
  const int background = b.node("ShaderNodeBackground", {value_input("Color", Vec4(1.0f, 0.8f, 0.6f, 1.0f)),
                                                         linked_input("Strength", strength, "Value")});
  b.graph.surface = {background, "Background"};
  d.world.graph = b.graph;
  return d;
}

/// Moments over independent replicates of the film's mean of the light by unconnectable paths: by walks that hit the
/// lamp or connect to it, and by merging.
struct BothWays {
  RunningMoments hit, merged;
};
BothWays unconnectable_light(const SceneDescription& d, int replicates, uint32_t passes, uint32_t samples) {
  const auto scene = build(d);
  BothWays result;
  VertexMerging merging;
  BidirectionalWalks all(*scene, 1.0), left(*scene, 1.0);
  left.leaves_unconnectable = true;
  left.merging = &merging;
  for (int k = 0; k < replicates; ++k) {
    const uint32_t seed = 1 + uint32_t(k);
    merging.prepare(*scene, nullptr, true, seed);
    EXPECT_TRUE(merging.active());
    Sampler sampler(Sampler::Kind::Sobol, seed);
    double hit = 0.0, merged = 0.0;
    for (uint32_t pass = 0; pass < passes; ++pass) {
      // Each pass is pass 0 with another seed, so that the radius is constant.
      if (pass > 0) merging.prepare(*scene, nullptr, true, hash_combine(seed, pass));
      EXPECT_TRUE(merging.begin_pass(0, kGoOn));
      for (uint32_t i = 0; i < samples; ++i) {
        sampler.start(0, pass * samples + i);
        const Vec2 film = sampler.get_2d() * float(d.settings.width);
        const auto sum = [&](BidirectionalWalks& walks) {
          Sampler copy = sampler;
          double light = 0.0;
          for (const FoundPath& path : walks.sample(film, copy)) light += double(luminance(path.contribution));
          return light;
        };
        for (int strategy : {0, 1}) {
          all.only_strategy = left.only_strategy = strategy;
          hit += sum(all) - sum(left);
        }
        merged += double(luminance(left.merged()));
      }
    }
    result.hit.add(hit / double(passes * samples));
    result.merged.add(merged / double(passes * samples));
  }
  return result;
}

bool is_unconnectable(const std::string& events) {
  return ajar::is_unconnectable(int(events.size()) + 2, [&](int i) { return events[size_t(i - 1)] == 'S'; });
}

void expect_same(const BothWays& light, int tests) {
  EXPECT_GT(light.hit.mean(), 0.0);
  EXPECT_TRUE(statistical::means_agree(light.hit, light.merged, {0.01, tests}))
      << "hit " << light.hit.mean() << ", merged " << light.merged.mean();
  // The test detects a bias of a tenth.
  EXPECT_LT(std::sqrt(light.hit.variance_of_mean() + light.merged.variance_of_mean()), 0.05 * light.hit.mean());
}

}  // namespace

TEST(VertexMerging, paths_without_a_connection_other_than_to_the_light_are_unconnectable) {
  // The events are in the order from the light to the eye.
  for (const char* yes : {"SDS", "SSDS", "SDSS", "SDSDS", "SSDSSDSS", "SDSDSDS", "DSDS", "DSSDSS", "DSDSDS"})
    EXPECT_TRUE(is_unconnectable(yes)) << yes;
  // Paths of light that is seen directly or is direct light, or with a connection at the lens or in between.
  for (const char* no :
       {"", "S", "D", "SS", "SSS", "DS", "DSS", "SD", "SDD", "DD", "SDSD", "DSDSD", "SDDS", "DDS", "DDSDS", "SDSDDS"})
    EXPECT_FALSE(is_unconnectable(no)) << no;
}

TEST(VertexMerging, agrees_with_paths_that_hit_the_lamp) {
  expect_same(unconnectable_light(pane_and_mirror(), 16, 4, 500), 4);
}
TEST(VertexMerging, agrees_on_surfaces_with_specular_and_diffuse_lobes) {
  expect_same(unconnectable_light(mixed_surfaces(), 16, 4, 500), 4);
}
TEST(VertexMerging, narrow_objects_keep_their_light) {
  expect_same(unconnectable_light(slats_and_mirror(), 16, 8, 2000), 4);
}
TEST(VertexMerging, small_round_objects_keep_their_light) {
  expect_same(unconnectable_light(pebbles_and_mirror(), 16, 8, 1000), 4);
}
TEST(VertexMerging, agrees_with_paths_that_hit_the_sun) {
  expect_same(unconnectable_light(lit_by_sun(0.3f), 16, 8, 2000), 4);
}
TEST(VertexMerging, agrees_with_paths_that_hit_a_bright_disc_of_the_sky) {
  expect_same(unconnectable_light(lit_by_sky(0.99f), 16, 8, 4000), 4);
}
TEST(VertexMerging, bounce_limits_apply_to_the_whole_path) {
  const BounceLimits limits[] = {{3, 16, 16, 16, 16, 0}, {16, 1, 1, 3, 16, 0}};
  for (const BounceLimits& bounces : limits) {
    SceneDescription d = pane_and_mirror();
    d.settings.bounces = bounces;
    SCOPED_TRACE("total " + std::to_string(bounces.total) + ", glossy " + std::to_string(bounces.glossy) +
                 ", diffuse " + std::to_string(bounces.diffuse));
    expect_same(unconnectable_light(d, 16, 6, 500), 4);
  }
}

class MergingWith : public ::testing::TestWithParam<const char*> {};
TEST_P(MergingWith, keeps_the_mean_of_path_tracing) {
  const SceneDescription d = pane_and_mirror();
  static const auto expected = blocks(d, "path", 64, 24, 100);
  const auto actual = blocks(d, GetParam(), std::string(GetParam()) == "bdpt" ? 16 : 96, 16, 200);
  for (size_t i = 0; i < kValues; ++i) {
    if (i % 4 == 3) continue;
    EXPECT_TRUE(statistical::means_agree(expected[i], actual[i], {0.01, 4 * kValues * 3 / 4}))
        << "block " << i / 4 << " channel " << i % 4 << ": path " << expected[i].mean() << ", " << GetParam() << " "
        << actual[i].mean();
  }
}
TEST_P(MergingWith, keeps_the_light_of_a_sun) {
  const SceneDescription d = lit_by_sun(0.3f);
  static const auto expected = whole(d, "path", 600, 24, 100);
  const auto actual = whole(d, GetParam(), 160, 16, 200);
  EXPECT_TRUE(statistical::means_agree(expected, actual, {0.01, 4}))
      << "path " << expected.mean() << ", " << GetParam() << " " << actual.mean();
  // The test detects a bias of 4 %.
  EXPECT_LT(std::sqrt(expected.variance_of_mean() + actual.variance_of_mean()), 0.012 * expected.mean());
}
TEST_P(MergingWith, gives_an_image_independent_of_threads_and_of_the_division_into_iterations) {
  SceneDescription d = pane_and_mirror(0.0f);
  d.settings.width = 40;
  d.settings.height = 33;
  const auto one = render(d, GetParam(), 8, 5, 1);
  EXPECT_EQ(one, render(d, GetParam(), 8, 5, 3));
  EXPECT_NE(one, render(d, GetParam(), 8, 6, 3));
  const auto scene = build(d);
  const auto film_of = [&](std::initializer_list<int> iterations) {
    const auto integrator = make_integrator(GetParam());
    Film film(0, 0, d.settings.width, d.settings.height, {"Combined"});
    integrator->prepare(scene, 7);
    for (int samples : iterations) integrator->run_iteration(film, samples, kGoOn);
    EXPECT_EQ(integrator->bias(), Bias::Consistent);
    return film.resolve("Combined", 1.0f);
  };
  if (std::string(GetParam()) == "bdpt") {
    EXPECT_EQ(film_of({1, 2, 5}), film_of({8}));
  }
}
TEST_P(MergingWith, changes_nothing_without_specular_materials) {
  SceneDescription d = grey_room();
  add_object(d, sphere(), add_glossy(d, 0.3f), moved(Vec3(0.3f, 0.2f, -0.5f), 0.4f));
  d.lights.push_back(area_lamp(Vec3(0.0f, 0.2f, 0.95f), Vec3(0, 0, -1), 0.9f, 8.0f));
  const auto off = render(d, GetParam(), 4, 5);
  d.settings.vertex_merging = Merging::On;
  EXPECT_EQ(off, render(d, GetParam(), 4, 5));
}
INSTANTIATE_TEST_SUITE_P(Integrators, MergingWith, ::testing::Values("bdpt", "erpt", "pmc_pt", "metropolis"),
                         [](const auto& info) { return std::string(info.param); });

TEST(VertexMerging, each_pass_has_a_smaller_radius_and_new_photons) {
  const auto scene = build(pane_and_mirror(0.1f));
  VertexMerging merging;
  merging.prepare(*scene, nullptr, true, 3);
  ASSERT_TRUE(merging.begin_pass(0, kGoOn));
  EXPECT_FLOAT_EQ(merging.radius(), 0.1f);
  const size_t first = merging.photons();
  EXPECT_GT(first, 0u);
  ASSERT_TRUE(merging.begin_pass(9, kGoOn));
  EXPECT_FLOAT_EQ(merging.radius(), 0.1f * float(std::sqrt(radius2_factor(9))));
  EXPECT_NE(merging.photons(), first);
}

TEST(VertexMerging, finds_light_of_lamps_that_cannot_be_hit) {
  // The mirror fills half of the image, and it shows a room that is lit only through the pane.
  SceneDescription d = pane_and_mirror(0.05f);
  d.lights = {point_light(Vec3(0.0f, 0.2f, 0.9f), 8.0f)};
  const double with = whole(d, "bdpt", 4, 4, 1).mean();
  d.settings.vertex_merging = Merging::Off;
  EXPECT_GT(with, 1.1 * whole(d, "bdpt", 4, 4, 1).mean());
}

TEST(VertexMerging, finds_light_of_a_sun_without_extent) {
  SceneDescription d = lit_by_sun(0.0f);
  const double with = whole(d, "bdpt", 4, 4, 1).mean();
  d.settings.vertex_merging = Merging::Off;
  EXPECT_GT(with, 1.1 * whole(d, "bdpt", 4, 4, 1).mean());
}
TEST(VertexMerging, lamps_without_shadows_keep_their_light) {
  // No walk starts at such a lamp, so that photons would not bring its light.
  SceneDescription d = pane_and_mirror();
  d.lights.front().cast_shadow = false;
  d.lights.push_back(point_light(Vec3(0.0f, 0.2f, 0.9f), 0.01f));
  const auto with = whole(d, "bdpt", 64, 16, 1);
  d.settings.vertex_merging = Merging::Off;
  const auto without = whole(d, "bdpt", 64, 16, 1);
  EXPECT_TRUE(statistical::means_agree(with, without, {0.01, 1})) << with.mean() << " " << without.mean();
  EXPECT_LT(std::sqrt(with.variance_of_mean() + without.variance_of_mean()), 0.01 * without.mean());
}

TEST(VertexMerging, the_plan_gives_the_reason_where_it_is_not_used) {
  SceneDescription d = grey_room();
  d.lights.push_back(area_lamp(Vec3(0.0f, 0.2f, 0.95f), Vec3(0, 0, -1), 0.9f, 8.0f));
  EXPECT_STREQ(plan_merging(*build(d)).reason, "no specular material");
  d = pane_and_mirror();
  EXPECT_TRUE(plan_merging(*build(d)).used);
  d.settings.bounces.total = 1;
  EXPECT_STREQ(plan_merging(*build(d)).reason, "the bounce limits leave nothing to merge");
  d = pane_and_mirror();
  d.lights.clear();
  set_world(d, Color(1.0f));
  for (const SceneDescription& wide : {d, lit_by_sun(1.0f), lit_by_sky(0.5f)})
    EXPECT_STREQ(plan_merging(*build(wide)).reason,
                 "no light sends photons: an even sky, wide suns and lamps without shadows do not");
  EXPECT_TRUE(plan_merging(*build(lit_by_sun(0.01f))).used);
  EXPECT_TRUE(plan_merging(*build(lit_by_sky(0.999f))).used);
}

}  // namespace ajar::test_vertex_merging
