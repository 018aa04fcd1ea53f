#include "transport/photons/photon_discs.h"

#include <gtest/gtest.h>

#include "math/statistics.h"
#include "sampling/sampler.h"
#include "scene_fixtures.h"
#include "transport/photons/photon_map.h"

namespace ajar::test_photon_discs {

using namespace fixtures;

namespace {

constexpr float kRadius = 0.2f;
const Vec3 kUp(0, 0, 1);

/// A scene with a board of these half widths at height 0.
SceneDescription board(float half_x, float half_y) {
  SceneDescription d;
  Mat4 scale(1.0f);
  scale[0][0] = half_x;
  scale[1][1] = half_y;
  add_object(d, plane(1.0f), add_diffuse(d, Color(0.5f)), scale);
  d.lights.push_back(point_light(Vec3(0, 0, 2), 10.0f));
  set_camera(d, Vec3(0, -3, 1), Vec3(0), 4);
  return d;
}

/// A wide board with a wall at x = 0.
SceneDescription board_with_wall() {
  SceneDescription d = board(1.0f, 1.0f);
  Mat4 upright(1.0f);  // turns a plane to x = 0
  upright[0] = Vec4(0, 0, 1, 0);
  upright[2] = Vec4(-1, 0, 0, 0);
  add_object(d, plane(1.0f), 0, upright);
  return d;
}

/// Photons from vertically above, uniform over [x0, x1] x [-y, y], with irradiance 1.
PhotonMap even_photons(float x0, float x1, float y, uint32_t seed, int count = 4000) {
  Sampler sampler(Sampler::Kind::Independent, seed);
  sampler.start(0, 0);
  std::vector<Photon> photons;
  const float flux = (x1 - x0) * 2.0f * y / float(count);
  for (int i = 0; i < count; ++i) {
    const Vec2 u = sampler.get_2d();
    photons.push_back({{Vec3(x0 + (x1 - x0) * u.x, y * (2.0f * u.y - 1.0f), 0.0f), pack_direction(kUp)},
                       Color(flux),
                       pack_direction_short(kUp)});
  }
  PhotonMap map;
  map.build(std::move(photons));
  return map;
}

/// The mean irradiance at x over several positions along y and several maps.
double mean_irradiance(const Scene* scene, float x, float x0, float x1, float y, int count = 1200,
                       int neighbours = PointTree::kMaxNeighbours) {
  RunningMoments moments;
  for (uint32_t seed = 1; seed <= 8; ++seed) {
    PhotonMap map = even_photons(x0, x1, y, seed, count);
    const PhotonMap::Lookup lookup{neighbours, kRadius};
    if (scene) map.look_around(*scene, lookup, 0.0f, seed);
    for (const float at : {-0.4f, -0.1f, 0.2f, 0.5f})
      moments.add(double(map.irradiance(Vec3(x, at, 0.0f), kUp, kUp, lookup).y));
  }
  return moments.mean();
}

}  // namespace

TEST(PhotonDiscs, are_complete_away_from_edges) {
  const auto scene = build(board(1.0f, 1.0f));
  PhotonMap map = even_photons(-0.7f, 0.7f, 0.7f, 1);
  const double before = double(map.irradiance(Vec3(0.0f), kUp, kUp, {60, kRadius}).y);
  map.look_around(*scene, {60, kRadius}, 0.0f, 1);
  EXPECT_FLOAT_EQ(float(map.irradiance(Vec3(0.0f), kUp, kUp, {60, kRadius}).y), float(before));
}

TEST(PhotonDiscs, irradiance_on_a_narrow_board_is_that_on_a_wide_one) {
  for (const float half : {0.02f, 0.04f, 0.08f}) {
    const auto scene = build(board(half, 1.0f));
    EXPECT_LT(mean_irradiance(nullptr, 0.0f, -half, half, 0.9f, 400), 0.6) << half;
    // The mean over the board. Single points see more or fewer of the photons near an edge.
    double mean = 0.0;
    for (const float x : {-0.8f, -0.4f, 0.0f, 0.4f, 0.8f})
      mean += mean_irradiance(scene.get(), half * x, -half, half, 0.9f, 400) / 5.0;
    EXPECT_NEAR(mean, 1.0, 0.1) << half;
  }
}

TEST(PhotonDiscs, irradiance_on_a_small_ball_is_complete) {
  for (const float radius : {0.06f, 0.1f, 0.12f, 0.2f, 0.5f}) {
    SceneDescription d = board(1.0f, 1.0f);
    d.objects.clear();
    add_object(d, sphere(96), 0, moved(Vec3(0.0f), radius));
    const auto scene = build(d);
    RunningMoments mean, without;
    for (uint32_t seed = 1; seed <= 8; ++seed) {
      constexpr int kPhotons = 400, kLookups = 400;
      Sampler sampler(Sampler::Kind::Independent, seed);
      sampler.start(0, 0);
      std::vector<Photon> photons;
      for (int i = 0; i < kPhotons; ++i) {
        const Vec3 out = warp::square_to_sphere(sampler.get_2d());
        photons.push_back({{radius * out, pack_direction(out)},
                           Color(4.0f * kPi * radius * radius / float(kPhotons)),
                           pack_direction_short(kUp)});
      }
      PhotonMap map, plain;
      plain.build(photons);
      map.build(std::move(photons));
      const PhotonMap::Lookup lookup{PointTree::kMaxNeighbours, kRadius};
      map.look_around(*scene, lookup, 0.0f, seed);
      for (int i = 0; i < kLookups; ++i) {
        const Vec3 out = warp::square_to_sphere(sampler.get_2d());
        mean.add(double(map.irradiance(radius * out, out, kUp, lookup).y));
        without.add(double(plain.irradiance(radius * out, out, kUp, lookup).y));
      }
    }
    EXPECT_LT(without.mean(), 0.9) << radius;
    EXPECT_NEAR(mean.mean(), 1.0, 0.15) << radius;  // 0.88 if always exactly one of the eight rays finds surface
  }
}

// With so many photons, ten of them are found within a thirtieth of the radius.
TEST(PhotonDiscs, edges_are_found_where_photons_are_dense) {
  constexpr float kHalf = 0.08f;
  const auto scene = build(board(kHalf, 1.0f));
  double mean = 0.0, before = 0.0;
  for (int i = 0; i < 7; ++i) {
    const float x = kHalf - 0.001f * (float(i) + 0.5f);
    mean += mean_irradiance(scene.get(), x, -kHalf, kHalf, 0.9f, 20000, 10) / 7.0;
    before += mean_irradiance(nullptr, x, -kHalf, kHalf, 0.9f, 20000, 10) / 7.0;
  }
  EXPECT_LT(before, 0.85);
  EXPECT_NEAR(mean, 1.0, 0.08);
}

TEST(PhotonDiscs, light_in_the_corner_of_a_floor_and_a_wall_is_complete) {
  const auto scene = build(board_with_wall());
  double mean = 0.0, before = 0.0;
  for (int i = 0; i < 10; ++i) {
    const float x = 0.04f * (float(i) + 0.5f);
    mean += mean_irradiance(scene.get(), x, 0.0f, 0.8f, 0.9f) / 10.0;
    before += mean_irradiance(nullptr, x, 0.0f, 0.8f, 0.9f) / 10.0;
  }
  EXPECT_LT(before, 0.92);
  EXPECT_NEAR(mean, 1.0, 0.03);
}

// A test point of the sector that lies before the wall does not detect the wall, so that a few photons pass.
TEST(PhotonDiscs, little_light_passes_below_a_wall) {
  const auto scene = build(board_with_wall());
  EXPECT_LT(mean_irradiance(scene.get(), -0.04f, 0.0f, 0.8f, 0.9f),
            0.5 * mean_irradiance(nullptr, -0.04f, 0.0f, 0.8f, 0.9f));
  // The photons that do not pass increase the irradiance on this side.
  EXPECT_GT(mean_irradiance(scene.get(), 0.04f, 0.0f, 0.8f, 0.9f),
            mean_irradiance(nullptr, 0.04f, 0.0f, 0.8f, 0.9f) + 0.05);
}

TEST(PhotonDiscs, surfaces_that_only_the_camera_sees_count) {
  SceneDescription d = board(1.0f, 1.0f);
  d.objects[0].visibility = kVisibleCamera;
  const auto scene = build(d);
  EXPECT_NEAR(mean_irradiance(scene.get(), 0.0f, -0.7f, 0.7f, 0.9f), mean_irradiance(nullptr, 0.0f, -0.7f, 0.7f, 0.9f),
              1e-4);
}

TEST(PhotonDiscs, do_not_depend_on_the_order_of_lookups) {
  const auto scene = build(board(0.1f, 1.0f));
  PhotonMap forwards = even_photons(-0.1f, 0.1f, 0.9f, 3), backwards = even_photons(-0.1f, 0.1f, 0.9f, 3);
  forwards.look_around(*scene, {30, kRadius}, 0.0f, 7);
  backwards.look_around(*scene, {30, kRadius}, 0.0f, 7);
  std::vector<float> a, b;
  for (int i = 0; i < 20; ++i)
    a.push_back(forwards.irradiance(Vec3(0, -0.8f + 0.08f * float(i), 0), kUp, kUp, {30, kRadius}).y);
  for (int i = 19; i >= 0; --i)
    b.push_back(backwards.irradiance(Vec3(0, -0.8f + 0.08f * float(i), 0), kUp, kUp, {30, kRadius}).y);
  EXPECT_EQ(a, std::vector<float>(b.rbegin(), b.rend()));
}

}  // namespace ajar::test_photon_discs
