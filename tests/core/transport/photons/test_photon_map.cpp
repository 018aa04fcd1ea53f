#include "transport/photons/photon_map.h"

#include <gtest/gtest.h>

#include "integrators/integrator.h"
#include "scene_fixtures.h"
#include "statistical.h"
#include "transport/photons/photon_tracer.h"

namespace ajar::test_photon_map {

using namespace fixtures;

namespace {

const std::atomic<bool> kGo{false};

PhotonBatch trace(const Scene& scene, uint32_t seed, uint32_t count, bool caustic = true) {
  PhotonEmission emission;
  emission.plan.global = true;
  emission.plan.caustic = caustic;
  emission.seed = seed;
  emission.count = count;
  return trace_photons(scene, nullptr, emission, kGo);
}

SceneDescription closed_room(float albedo, Color emission = Color(0.0f)) {
  SceneDescription d;
  add_object(d, cube(true), add_diffuse(d, Color(albedo), emission));
  set_camera(d, Vec3(0.1f, -0.5f, 0.2f), Vec3(0.3f, 0.5f, -0.1f), 8);
  d.settings.bounces = {1000, 1000, 1000, 1000, 1000, 0};
  return d;
}

LightDescription lamp_of(LightKind kind, float energy) {
  LightDescription light = point_light(Vec3(0.1f, 0.2f, 0.7f), energy);
  light.kind = kind;
  light.color = Color(1.0f, 0.5f, 0.25f);
  return light;
}

}  // namespace

TEST(Photons, emitted_flux_sums_to_the_power_of_the_lights) {
  std::vector<SceneDescription> scenes;
  const auto add = [&](LightDescription light) {
    scenes.push_back(closed_room(0.5f));
    scenes.back().lights.push_back(light);
  };
  add(lamp_of(LightKind::Point, 10.0f));
  LightDescription light = lamp_of(LightKind::Point, 10.0f);
  light.radius = 0.1f;
  add(light);
  add(lamp_of(LightKind::Spot, 10.0f));
  light = lamp_of(LightKind::Area, 10.0f);
  light.area_size = Vec2(0.2f, 0.1f);
  add(light);
  light.spread = 1.0f;
  light.area_shape = AreaShape::Ellipse;
  add(light);
  add(lamp_of(LightKind::Sun, 2.0f));
  light = lamp_of(LightKind::Sun, 2.0f);
  light.sun_angle = 0.05f;
  add(light);
  scenes.push_back(closed_room(0.5f, Color(0.2f, 0.5f, 0.1f)));
  scenes.push_back(closed_room(0.5f));
  set_world(scenes.back(), Color(0.3f, 0.4f, 0.5f));
  // Several lights of different power.
  scenes.push_back(scenes.front());
  scenes.back().lights.insert(scenes.back().lights.end(),
                              {lamp_of(LightKind::Spot, 3.0f), lamp_of(LightKind::Area, 0.1f)});
  for (size_t i = 0; i < scenes.size(); ++i) {
    const auto scene = build(scenes[i]);
    RunningMoments watts;
    for (uint32_t seed = 0; seed < 16; ++seed) {
      const PhotonBatch batch = trace(*scene, seed, 2048);
      watts.add(double(luminance(Color(batch.emitted[0], batch.emitted[1], batch.emitted[2]))));
    }
    EXPECT_TRUE(statistical::mean_agrees(watts, scene->lights().total_power(), {0.01, int(scenes.size())}, 1e-4))
        << "scene " << i;
  }
}

TEST(Photons, with_one_bounce_have_the_power_of_the_lights) {
  SceneDescription d = closed_room(0.5f);
  d.lights.push_back(point_light(Vec3(0.1f, 0.2f, 0.3f), 10.0f));
  d.settings.bounces = {1, 1, 1, 1, 1, 0};  // stored photons have not been scattered
  const auto scene = build(d);
  const PhotonBatch batch = trace(*scene, 1, 10000);
  double sum = 0.0;
  for (const Photon& photon : batch.global)
    sum += double(photon.flux_over_cosine.y) * double(glm::dot(unpack_direction_short(photon.packed_direction),
                                                               unpack_direction(photon.point.packed_normal)));
  EXPECT_EQ(batch.global.size(), 10000u);
  EXPECT_NEAR(sum / scene->lights().total_power(), 1.0, 1e-3);
}

TEST(Photons, closed_furnace_away_from_edges_has_irradiance_pi) {
  // With emission 1 - a and albedo a, the radiance is 1 everywhere, so that the irradiance is pi. The estimate is
  // unbiased where the disc lies in a plane.
  const auto scene = build(closed_room(0.6f, Color(0.4f)));
  RunningMoments fixed_radius, nearest;
  for (uint32_t seed = 0; seed < 24; ++seed) {
    PhotonMap map;
    map.build(trace(*scene, seed, 4000, false).global);
    const auto irradiance = [&](Vec3 p, Vec3 n, PhotonMap::Lookup lookup) {
      return double(map.irradiance(p, n, n, lookup).y) / M_PI;
    };
    for (const float x : {-0.4f, 0.0f, 0.4f}) {
      fixed_radius.add(irradiance(Vec3(x, 0.1f, -1.0f), Vec3(0, 0, 1), {PointTree::kMaxNeighbours, 0.1f}));
      nearest.add(irradiance(Vec3(-1.0f, x, 0.1f), Vec3(1, 0, 0), {20, 0.5f}));
    }
  }
  EXPECT_TRUE(statistical::mean_agrees(fixed_radius, 1.0, {0.01, 2}, 1e-3));
  EXPECT_TRUE(statistical::mean_agrees(nearest, 1.0, {0.01, 2}, 1e-3));
}

TEST(Photons, kernels_spread_the_light_of_photons_over_the_distance_that_they_have_come) {
  const PhotonKernels kernels(1.0f);
  EXPECT_EQ(kernels.radius2(kernels.packed(10.0f)), kInfinity) << "none";
  for (const float distance : {0.1f, 0.03f, 0.003f}) {
    const float radius = std::sqrt(kernels.radius2(kernels.packed(distance)));
    EXPECT_GE(radius, 4.0f * distance);
    EXPECT_LE(radius, 4.0f * std::sqrt(2.0f) * distance);
  }
  EXPECT_NEAR(kernels.radius2(kernels.packed(0.0f)), std::exp2(-15.0f), 1e-9f);

  // Photons on a plane: half of them have come from a distance of 5 mm. The mean irradiance is the same with kernels.
  Pcg32 rng(1);
  std::vector<Photon> photons;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 at(2.0f * rng.next_float() - 1.0f, 2.0f * rng.next_float() - 1.0f, 0.0f);
    const uint32_t kernel = kernels.packed(i % 2 == 0 ? 0.005f : 1.0f);
    photons.push_back(
        {{at, pack_direction(Vec3(0, 0, 1))}, Color(1e-4f), pack_direction_short(Vec3(0, 0, 1)) | kernel});
  }
  PhotonMap map;
  map.build(photons);
  RunningMoments without, with;
  for (RunningMoments* mean : {&without, &with}) {
    if (mean == &with) map.use(kernels);
    for (int i = 0; i < 4000; ++i) {
      const Vec3 at(1.6f * rng.next_float() - 0.8f, 1.6f * rng.next_float() - 0.8f, 0.0f);
      mean->add(double(map.irradiance(at, Vec3(0, 0, 1), Vec3(0, 0, 1), {PointTree::kMaxNeighbours, 0.06f}).y));
    }
  }
  EXPECT_NEAR(without.mean(), 0.5, 0.01);
  EXPECT_NEAR(with.mean(), 0.5, 0.01);
  EXPECT_GT(with.variance(), 2.0 * without.variance());

  // Nothing arrives beyond the kernel.
  PhotonMap one;
  one.build({{{Vec3(0.0f), pack_direction(Vec3(0, 0, 1))},
              Color(1.0f),
              pack_direction_short(Vec3(0, 0, 1)) | kernels.packed(0.005f)}});
  one.use(kernels);
  const auto at = [&](float x) { return one.irradiance(Vec3(x, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, 1), {10, 0.1f}).y; };
  EXPECT_GT(at(0.01f), 100.0f);
  EXPECT_EQ(at(0.04f), 0.0f);
}

TEST(Photons, only_photons_that_have_come_from_nearby_have_kernels) {
  SceneDescription d = closed_room(0.5f);
  d.lights.push_back(point_light(Vec3(0.1f, 0.2f, 0.999f), 10.0f));
  d.settings.bounces = {1, 1, 1, 1, 1, 0};  // stored photons have not been scattered
  const auto scene = build(d);
  const PhotonKernels kernels = photon_kernels(*scene);
  int near = 0, far = 0;
  for (const Photon& photon : trace(*scene, 1, 10000).global) {
    const float distance = glm::length(photon.point.position - Vec3(0.1f, 0.2f, 0.999f)),
                radius = std::sqrt(kernels.radius2(photon.packed_direction));
    if (distance < 0.003f) {
      ++near;
      EXPECT_GE(radius, 3.99f * distance);
      EXPECT_LE(radius, 5.7f * distance);
    } else if (distance > 0.1f) {
      ++far;
      EXPECT_EQ(radius, kInfinity);
    }
  }
  EXPECT_GT(near, 1000);
  EXPECT_GT(far, 1000);
}

TEST(Photons, estimates_as_wide_as_a_pixel_or_with_enough_photons_have_no_bias) {
  // As above. A square metre has about 400 photons: a pixel has one, three or thirteen of them.
  const auto scene = build(closed_room(0.6f, Color(0.4f)));
  RunningMoments irradiance[3];
  const float pixels[3] = {0.03f, 0.05f, 0.1f};
  for (uint32_t seed = 0; seed < 256; ++seed) {
    PhotonMap map;
    map.build(trace(*scene, seed, 4000, false).global);
    for (size_t k = 0; k < 3; ++k) {
      const PhotonMap::Lookup lookup{60, 0.3f, 3, {Vec3(0.0f, 0.0f, 0.0f), pixels[k], true}};
      double sum = 0.0;
      for (int i = 0; i < 100; ++i) {
        const Vec3 p(-0.6f + 0.13f * float(i % 10), -0.6f + 0.13f * float(i / 10), -1.0f);
        sum += double(map.irradiance(p, Vec3(0, 0, 1), Vec3(0, 0, 1), lookup).y) / (100.0 * M_PI);
      }
      irradiance[k].add(sum);
    }
  }
  for (const RunningMoments& moments : irradiance) {
    EXPECT_LT(std::sqrt(moments.variance_of_mean()), 0.006) << "too few photons for the test";
    EXPECT_TRUE(statistical::mean_agrees(moments, 1.0, {0.01, 3}, 1e-3));
  }
}

TEST(Photons, bounces_that_are_left_are_compared_kind_by_kind) {
  const PackedBounces left({3, 2, 0, 31, 1});
  EXPECT_TRUE(PackedBounces({3, 2, 0, 900, 1}).within(left)) << "31 is any number";
  EXPECT_TRUE(PackedBounces(BounceCounts{}).within(left));
  EXPECT_FALSE(PackedBounces({4, 0, 0, 0, 0}).within(left));
  EXPECT_FALSE(PackedBounces({0, 3, 0, 0, 0}).within(left));
  EXPECT_FALSE(PackedBounces({0, 0, 1, 0, 0}).within(left));
  EXPECT_FALSE(PackedBounces({0, 0, 0, 0, 2}).within(left));
  EXPECT_FALSE(PackedBounces({0, 0, 0, 40, 0}).within(PackedBounces({3, 2, 0, 30, 1})));
  EXPECT_EQ(min(left, PackedBounces({1, 5, 0, 7, 40})).bits(), PackedBounces({1, 2, 0, 7, 1}).bits());
  EXPECT_EQ(min(left, PackedBounces()).bits(), left.bits());
  for (const PackedBounces& bounces : {PackedBounces({3, 2, 0, 900, 1}), PackedBounces({4, 0, 0, 0, 0})})
    EXPECT_EQ(bounces.within(left.marked()), bounces.within(left)) << "a mark is no bounce";
  const PackedBounces least = min(PackedBounces(), left.marked());
  for (const PackedBounces& bounces : {PackedBounces({3, 2, 0, 900, 1}), PackedBounces({4, 0, 0, 0, 0})})
    EXPECT_EQ(bounces.within(least), bounces.within(left));
  EXPECT_TRUE(FluxWithBounces(Color(1.0f), left.marked()).left().is_marked());
  EXPECT_FALSE(FluxWithBounces(Color(1.0f), left).left().is_marked());

  const Color flux(1.2345678f, 3e-20f, 0.0f);
  const FluxWithBounces both(flux, left);
  EXPECT_EQ(both.left().bits(), left.bits());
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(both.flux()[c], flux[c], flux[c] * 0x1p-14f);
}

TEST(Photons, lookups_leave_out_photons_that_exceed_a_bounce_limit) {
  constexpr int kPhotons = 20000;
  const uint32_t up = pack_direction(Vec3(0, 0, 1));
  Pcg32 rng(2);
  std::vector<Photon> photons;
  for (int i = 0; i < kPhotons; ++i) {
    const Vec3 at(2.0f * rng.next_float() - 1.0f, 2.0f * rng.next_float() - 1.0f, 0.0f);
    photons.push_back({{at, up},
                       Color(float(M_PI) * 4.0f / kPhotons),
                       pack_direction_short(Vec3(0, 0, 1)),
                       i % 4 == 0 ? PackedBounces({9, 2, 9, 9, 0}) : PackedBounces()});
  }
  PhotonMap map;
  map.build(photons);
  std::vector<IrradianceSite> places;
  for (int i = 0; i < 400; ++i)
    places.push_back({{Vec3(0.09f * float(i % 20) - 0.85f, 0.09f * float(i / 20) - 0.85f, 0.0f), up}, Vec3(0, 0, 1)});
  IrradianceMap sites;
  sites.build(places, map, {10, 0.2f});
  const auto mean = [&](BounceCounts bounces, int& from_sites) {
    double sum = 0.0;
    from_sites = 0;
    for (const IrradianceSite& place : places) {
      PhotonMap::Lookup lookup{10, 0.2f};
      lookup.bounces = bounces;
      sum += double(map.irradiance(place.point.position, Vec3(0, 0, 1), Vec3(0, 0, 1), lookup).y) / M_PI;
      Color irradiance;
      from_sites += sites.find(place.point.position, Vec3(0, 0, 1), 0.05f, bounces, irradiance);
    }
    return sum / double(places.size());
  };
  int found;
  EXPECT_NEAR(mean({.total = 1, .diffuse = 1}, found), 1.0, 0.05);
  EXPECT_EQ(found, 400);
  EXPECT_NEAR(mean({.total = 2, .diffuse = 2}, found), 0.75, 0.05);
  EXPECT_LT(found, 100) << "most sites have such photons";
}

TEST(Photons, precomputed_irradiance_keeps_the_mean) {
  // At the position of a photon, the estimate would be too large by 1/k. Sites of another pass are independent of the
  // photons.
  const auto scene = build(closed_room(0.6f, Color(0.4f)));
  RunningMoments moments;
  for (uint32_t seed = 0; seed < 24; ++seed) {
    PhotonMap map;
    map.build(trace(*scene, seed, 4000, false).global);
    IrradianceMap sites;
    sites.build(trace(*scene, seed + 1000, 1000, false).sites, map, {20, 0.3f});
    for (const float x : {-0.5f, -0.2f, 0.0f, 0.3f, 0.5f}) {
      Color irradiance;
      if (sites.find(Vec3(x, 0.1f, -1.0f), Vec3(0, 0, 1), 0.3f, {1, 1}, irradiance))
        moments.add(double(irradiance.y) / M_PI);
    }
  }
  EXPECT_GT(moments.count(), 100u);
  EXPECT_TRUE(statistical::mean_agrees(moments, 1.0, {0.01, 1}, 2e-3));
}

TEST(Photons, are_the_same_for_any_number_of_threads) {
  SceneDescription d = closed_room(0.7f);
  d.lights.push_back(point_light(Vec3(0.1f, 0.2f, 0.3f), 10.0f, 0.1f));
  const auto scene = build(d);
  const PhotonBatch one = trace(*scene, 3, 5000), two = trace(*scene, 3, 5000);
  ASSERT_EQ(one.global.size(), two.global.size());
  EXPECT_EQ(std::memcmp(one.global.data(), two.global.data(), one.global.size() * sizeof(Photon)), 0);
  EXPECT_NE(one.global.size(), trace(*scene, 4, 5000).global.size());
}

TEST(Photons, are_stored_only_where_maps_are_needed) {
  SceneDescription dark = closed_room(0.5f);
  EXPECT_FALSE(plan_photons(*build(dark)).global);
  SceneDescription lit = dark;
  lit.lights.push_back(point_light(Vec3(0.0f), 10.0f));
  const PhotonPlan plan = plan_photons(*build(lit));
  EXPECT_TRUE(plan.global);
  EXPECT_FALSE(plan.caustic);
  SceneDescription direct_only = lit;
  direct_only.settings.bounces.diffuse = 0;
  EXPECT_FALSE(plan_photons(*build(direct_only)).global);
  SceneDescription with_mirror = lit;
  MaterialDescription mirror;
  mirror.name = "Mirror";
  mirror.graph.nodes.push_back(closure_node("ShaderNodeBsdfGlossy", Color(0.9f)));
  mirror.graph.nodes[0].inputs.push_back({"Roughness", {}, Vec4(0.0f)});
  mirror.graph.surface = {0, "BSDF"};
  with_mirror.materials.push_back(mirror);
  EXPECT_FALSE(plan_photons(*build(with_mirror)).caustic) << "no object has this material";
  add_object(with_mirror, plane(0.3f), 1);
  EXPECT_TRUE(plan_photons(*build(with_mirror)).caustic);
  SceneDescription only_mirror;
  only_mirror.materials = with_mirror.materials;
  only_mirror.lights = with_mirror.lights;
  only_mirror.camera = with_mirror.camera;
  add_object(only_mirror, plane(0.3f), 1);
  only_mirror.settings.reflective_caustics = false;
  EXPECT_FALSE(plan_photons(*build(only_mirror)).caustic);
  const PhotonPlan none;
  PhotonEmission emission;
  emission.plan = none;
  emission.count = 1000;
  EXPECT_TRUE(trace_photons(*build(lit), nullptr, emission, kGo).global.empty());
}

TEST(Photons, radius_shrinks_by_the_published_law) {
  for (uint32_t i = 1; i < 100; ++i)
    EXPECT_NEAR(radius2_factor(i) / radius2_factor(i - 1), (i + 2.0 / 3.0) / (i + 1.0), 1e-12);
  EXPECT_EQ(radius2_factor(0), 1.0);
  // The bias is proportional to the mean of r^2 over the passes, which falls with the power -1/3 of their number.
  double factor = 1.0, sum = 1.0, at_1000 = 0.0;
  for (int i = 1; i < 16000; ++i) {
    if (i == 1000) at_1000 = sum / i;
    sum += factor *= (i + 2.0 / 3.0) / (i + 1.0);
  }
  EXPECT_NEAR(std::log(sum / 16000 / at_1000) / std::log(16.0), -1.0 / 3.0, 0.01);
}

TEST(Photons, leave_emissive_squares_at_zero_height) {
  SceneDescription d;
  add_object(d, plane(9.0f), add_diffuse(d, Color(0.5f), Color(1.0f)));
  add_object(d, plane(9.0f), add_diffuse(d, Color(0.5f)),
             Mat4(Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, 0, -1, 1)));
  set_camera(d, Vec3(0, 0, -0.5f), Vec3(0, 0, -1), 8);
  const PhotonBatch batch = trace(*build(d), 1, 2048, false);
  const auto on_floor = std::count_if(batch.global.begin(), batch.global.end(),
                                      [](const Photon& photon) { return photon.point.position.z < -0.99f; });
  EXPECT_GT(on_floor,
            800);  // half of the photons go down, and few of them pass the edge
}

}  // namespace ajar::test_photon_map
