// Irradiance caching. Records and their gradients are tested against closed forms, images against path tracing within
// the stated bias.
#include "agreement.h"
#include "transport/photons/irradiance_records.h"

namespace ajar::test_irradiance_cache {

using namespace fixtures;

namespace {

/// The record at p for `radiance(direction, distance)`, evaluated at the centres of the strata.
template <class Radiance>
IrradianceRecord record_of(Vec3 p, const Frame& frame, int strata, Radiance&& radiance) {
  const HemisphereGrid grid(strata);
  std::vector<Color> colors(size_t(grid.strata()));
  std::vector<float> inverse_distance(colors.size());
  for (int i = 0; i < grid.strata(); ++i) {
    float distance = kInfinity;
    colors[size_t(i)] = Color(1.0f, 0.5f, 0.0f) * radiance(frame.to_world(grid.direction(i, Vec2(0.5f))), distance);
    inverse_distance[size_t(i)] = 1.0f / distance;
  }
  return grid.record(p, frame, colors, inverse_distance);
}

IrradianceRecord made(Vec3 position, Vec3 normal, float radius, float irradiance) {
  IrradianceRecord r;
  r.position = position;
  r.normal = normal;
  r.radius = radius;
  r.irradiance = Color(irradiance);
  return r;
}

SceneDescription lit_room(int size) {
  SceneDescription d = grey_room(size);
  add_object(d, sphere(), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f));
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f));
  return d;
}

RunningMoments mean_by(SceneDescription d, DirectMethod method, int direct_samples) {
  d.settings.direct = method;
  d.settings.direct_samples = direct_samples;
  return whole(d, "irradiance_cache", 4, 24, 500);
}

}  // namespace

TEST(IrradianceRecord, has_the_irradiance_and_rotation_gradient_of_a_distant_sky) {
  // L = 2 + a.w gives E(n) = 2 pi + 2 pi / 3 a.n, independent of the position.
  const Vec3 a(0.7f, -0.4f, 0.3f);
  const Frame frame(glm::normalize(Vec3(0.3f, 0.5f, 0.8f)));
  const IrradianceRecord r = record_of(Vec3(1, 2, 3), frame, 4000,
                                       [&](Vec3 w, float&) { return 2.0f + glm::dot(a, w); });
  EXPECT_NEAR(r.irradiance.x, 2.0f * kPi + 2.0f * kPi / 3.0f * glm::dot(a, frame.n), 0.01f);
  EXPECT_NEAR(r.irradiance.y, 0.5f * r.irradiance.x, 1e-4f);
  const Vec3 turning = 2.0f * kPi / 3.0f * glm::cross(frame.n, a);
  EXPECT_LT(glm::length(r.by_rotation[0] - turning), 0.02f * glm::length(turning));
  EXPECT_EQ(glm::length(r.by_translation[0]), 0.0f);
  EXPECT_EQ(r.radius, kInfinity);
  const Vec3 tilted = glm::normalize(frame.n + 0.1f * frame.s);
  EXPECT_NEAR(r.at(r.position, tilted).x, 2.0f * kPi + 2.0f * kPi / 3.0f * glm::dot(a, tilted), 0.03f);
}

TEST(IrradianceRecord, has_the_translation_gradient_below_a_ceiling) {
  const Frame frame(Vec3(0, 0, 1));
  const auto at = [&](Vec3 p) {
    return record_of(p, frame, 40000, [&](Vec3 w, float& distance) {
      distance = 1.0f / w.z;  // a ceiling one metre above, which emits in a stripe
      const float x = p.x + distance * w.x;
      return std::exp(-sqr(x - 0.8f));
    });
  };
  const float step = 0.05f;
  const IrradianceRecord r = at(Vec3(0.0f));
  const float slope = (at(Vec3(step, 0, 0)).irradiance.x - at(Vec3(-step, 0, 0)).irradiance.x) / (2.0f * step);
  EXPECT_NEAR(r.by_translation[0].x, slope, 0.03f * std::abs(slope));
  EXPECT_NEAR(r.by_translation[0].y, 0.0f, 0.01f * std::abs(slope));
  // The harmonic mean of the distance 1 / cos(theta): the mean of cos(theta) is 2 / 3 with a cosine-weighted density.
  EXPECT_NEAR(r.radius, 1.5f, 0.01f);
}

TEST(IrradianceRecords, are_used_near_them_and_not_behind_them) {
  const IrradianceRecord r = made(Vec3(0.0f), Vec3(0, 0, 1), 1.0f, 1.0f);
  EXPECT_EQ(r.weight(Vec3(0.0f), Vec3(0, 0, 1)), 1.0f);
  EXPECT_NEAR(r.weight(Vec3(0.6f, 0, 0), Vec3(0, 0, 1)), 0.4f, 1e-6f);
  EXPECT_EQ(r.weight(Vec3(1.01f, 0, 0), Vec3(0, 0, 1)), 0.0f);
  EXPECT_EQ(r.weight(Vec3(0.1f, 0, -0.2f), Vec3(0, 0, 1)), 0.0f);
  EXPECT_EQ(r.weight(Vec3(0.1f, 0, 0), Vec3(0, 0, -1)), 0.0f);
  EXPECT_EQ(r.weight(Vec3(0.1f, 0, 0), glm::normalize(Vec3(1, 0, 2))), 0.0f);
}

TEST(IrradianceRecords, are_found_within_their_radii_and_limit_the_radii_of_neighbours) {
  Pcg32 rng(3);
  std::vector<IrradianceRecord> list;
  for (int i = 0; i < 500; ++i)
    list.push_back(made(Vec3(rng.next_float(), rng.next_float(), 0) * 100.0f - 50.0f, Vec3(0, 0, 1),
                        std::exp2(6.0f * rng.next_float() - 2.0f), 1.0f + rng.next_float()));
  list.push_back(made(Vec3(0.0f), Vec3(0, 0, 1), 0.0f, 1.0f));
  IrradianceRecords records;
  records.add(std::span(list).first(200));
  records.add(std::span(list).subspan(200));
  EXPECT_EQ(records.size(), 500u);
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = Vec3(rng.next_float(), rng.next_float(), 0) * 100.0f - 50.0f, n(0, 0, 1);
      float sum = 0.0f, weighted = 0.0f;
      for (size_t k = 0; k < records.size(); ++k) {
        sum += records[k].weight(p, n);
        weighted += records[k].weight(p, n) * records[k].irradiance.x;
      }
      EXPECT_NEAR(records.coverage(p, n), sum, 1e-4f * sum);
      Color irradiance;
      if (records.find(p, n, irradiance))
        EXPECT_NEAR(irradiance.x, weighted / sum, 1e-4f * irradiance.x);
      else
        EXPECT_LT(sum, 0.11f);
    }
    records.limit_by_neighbours();
  }
  for (size_t i = 0; i < records.size(); ++i) {
    for (size_t k = 0; k < records.size(); ++k) {
      const float distance = glm::length(records[i].position - records[k].position);
      if (distance < records[i].radius) {
        EXPECT_LE(records[i].radius, list[k].radius + IrradianceRecords::kRadiusShare * distance + 1e-4f);
      }
    }
  }
}

TEST(IrradianceCache, reports_its_bias) {
  const IntegratorInfo& info = find_integrator("irradiance_cache");
  EXPECT_EQ(info.bias, Bias::Biased);
  EXPECT_EQ(info.make()->bias(), Bias::Biased);
}

TEST(IrradianceCache, a_furnace_has_radiance_one) {
  SceneDescription d;
  add_object(d, cube(true), add_diffuse(d, Color(0.6f), Color(0.4f)));
  set_camera(d, Vec3(0.1f, -0.5f, 0.2f), Vec3(0.3f, 0.5f, -0.1f), 8);
  d.settings.bounces = {1000, 1000, 1000, 1000, 1000, 0};
  // The mean of red, green, blue and zero.
  const RunningMoments cached = whole(d, "irradiance_cache", 8, 16, 1), paths = whole(d, "path", 8, 16, 1);
  EXPECT_NEAR(cached.mean(), 0.75, 4.0 * std::sqrt(cached.variance_of_mean()));
  EXPECT_LT(std::sqrt(cached.variance_of_mean()), 1.5e-3);
  EXPECT_LT(cached.variance(), 0.5 * paths.variance());
}

TEST(IrradianceCache, agrees_with_path_tracing_in_a_diffuse_room_within_its_bias) {
  const SceneDescription d = lit_room(36);
  const auto expected = blocks(d, "path", 64, 8, 100), actual = blocks(d, "irradiance_cache", 8, 8, 200);
  double sum_expected = 0.0, sum_actual = 0.0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const double error = std::sqrt(expected[i].variance_of_mean() + actual[i].variance_of_mean());
    EXPECT_LT(error, 0.01 * expected[i].mean()) << "too noisy for the test";
    EXPECT_NEAR(actual[i].mean(), expected[i].mean(), 0.02 * expected[i].mean() + 4.0 * error) << "block " << i / 4;
    if (i % 4 == 3) continue;
    sum_expected += expected[i].mean();
    sum_actual += actual[i].mean();
  }
  EXPECT_NEAR(sum_actual / sum_expected, 1.0, 0.012);
}

TEST(IrradianceCache, has_a_fraction_of_the_noise_of_path_tracing) {
  SceneDescription d = lit_room(32);
  d.lights[0].world_from_light = rows(
      shining(Vec3(0.1f, 0.1f, 0.5f), Vec3(0, 0, 1)));  // all light comes from the ceiling
  // The variance of pixels between seeds also contains the errors that neighbouring pixels share.
  const auto variance_of = [&](const char* integrator, int samples) {
    std::vector<RunningMoments> pixels(32 * 32);
    for (uint32_t seed = 1; seed <= 6; ++seed) {
      const auto image = render(d, integrator, samples, seed);
      for (size_t i = 0; i < pixels.size(); ++i)
        pixels[i].add(double(luminance(Color(image[4 * i], image[4 * i + 1], image[4 * i + 2]))));
    }
    double sum = 0.0;
    for (const RunningMoments& pixel : pixels) sum += pixel.variance();
    return sum;
  };
  const double once = variance_of("irradiance_cache", 1), later = variance_of("irradiance_cache", 8),
               paths = variance_of("path", 8);
  EXPECT_LT(later, 0.1 * paths);
  EXPECT_LT(later, 0.25 * once);  // each pass has new records, so that the variance falls as 1 / n
}

TEST(IrradianceCache, control_variates_and_multiple_importance_sampling_have_the_same_mean) {
  SceneDescription d = lit_room(8);
  d.settings.gather_rays = 1;
  const RunningMoments mis = mean_by(d, DirectMethod::Mis, 1);
  for (auto [method, samples] : {std::pair{DirectMethod::Mis, 8},
                                 {DirectMethod::Ocv, 16},
                                 {DirectMethod::OcvProgressive, 8},
                                 {DirectMethod::PmcHi, 1}})
    EXPECT_TRUE(statistical::means_agree(mean_by(d, method, samples), mis, {0.01, 4})) << name_of(method);
}

TEST(IrradianceCache, glossy_and_transparent_surfaces_agree_with_path_tracing) {
  // The mean over the image is compared, since caustics of the glass are blurred.
  for (const TransportScene& scene : transport_scenes()) {
    if (scene.name != "glossy" && scene.name != "see_through" && scene.name != "environment") continue;
    const RunningMoments paths = whole(scene.description, "path", 64, 12, 100),
                         cache = whole(scene.description, "irradiance_cache", 16, 12, 200);
    const double error = std::sqrt(paths.variance_of_mean() + cache.variance_of_mean());
    EXPECT_LT(error, 0.012 * paths.mean()) << scene.name;
    EXPECT_NEAR(cache.mean(), paths.mean(), 0.015 * paths.mean() + 4.0 * error) << scene.name;
  }
}

TEST(IrradianceCache, the_image_does_not_depend_on_threads_or_the_division_into_iterations) {
  for (DirectMethod method : {DirectMethod::Mis, DirectMethod::OcvProgressive, DirectMethod::PmcHi}) {
    SceneDescription d = lit_room(33);
    add_object(d, sphere(12), add_glossy(d, 0.2f), moved(Vec3(-0.4f, 0.4f, -0.6f), 0.3f));
    d.settings.gather_rays = 1;
    d.settings.direct = method;
    d.settings.region = {3, 5, 32, 30};
    const auto one = render(d, "irradiance_cache", 3, 5, 1);
    EXPECT_EQ(one, render(d, "irradiance_cache", 3, 5, 2)) << name_of(method);
    EXPECT_EQ(one, render(d, "irradiance_cache", 3, 5, 8)) << name_of(method);
    EXPECT_NE(one, render(d, "irradiance_cache", 3, 6, 2)) << name_of(method);
  }
  const auto scene = build(lit_room(8));
  const std::atomic<bool> go{false};
  Film together(0, 0, 8, 8, {"Combined"}), apart(0, 0, 8, 8, {"Combined"});
  const auto a = make_integrator("irradiance_cache"), b = make_integrator("irradiance_cache");
  a->prepare(scene, 1);
  a->run_iteration(together, 5, go);
  b->prepare(scene, 1);
  for (int samples : {1, 1, 3}) b->run_iteration(apart, samples, go);
  EXPECT_EQ(together.resolve("Combined", 1.0f), apart.resolve("Combined", 1.0f));
}

TEST(IrradianceCache, no_records_are_stored_without_indirect_light) {
  SceneDescription dark = lit_room(8), unbounced = lit_room(8);
  dark.lights.clear();
  unbounced.settings.bounces.total = 0;
  const std::atomic<bool> go{false};
  for (const SceneDescription& d : {dark, unbounced}) {
    const auto integrator = make_integrator("irradiance_cache");
    integrator->prepare(build(d), 1);
    Film film(0, 0, 8, 8, {"Combined"});
    integrator->run_iteration(film, 2, go);
    EXPECT_EQ(integrator->statistics().extra.at("records"), 0.0);
  }
}

}  // namespace ajar::test_irradiance_cache
