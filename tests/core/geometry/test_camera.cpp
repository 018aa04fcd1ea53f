#include <gtest/gtest.h>

#include "math/random.h"
#include "math/warps.h"
#include "scene_fixtures.h"

namespace ajar::test_camera {

namespace {

Camera looking_down_y(CameraKind kind, float aperture) {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0, -5, 0), Vec3(0), 100);
  d.camera.kind = kind;
  d.camera.aperture_radius = aperture;
  d.camera.focus_distance = 3.0f;
  return Camera(d.camera, 100, 100);
}

}  // namespace

TEST(Camera, centre_and_corner_of_the_film_follow_the_screen_window) {
  const Camera camera = looking_down_y(CameraKind::Perspective, 0.0f);
  const Ray centre = camera.generate_ray({50, 50}, {0.5f, 0.5f}, 0.0f);
  EXPECT_NEAR(centre.direction.y, 1.0f, 1e-6f);
  const Ray corner = camera.generate_ray({100, 100}, {0.5f, 0.5f}, 0.0f);
  EXPECT_NEAR(corner.direction.x / corner.direction.y, 0.5f, 1e-5f);
  EXPECT_NEAR(corner.direction.z / corner.direction.y, 0.5f, 1e-5f);
}

TEST(Camera, all_rays_of_a_pixel_meet_in_the_plane_of_focus) {
  const Camera camera = looking_down_y(CameraKind::Perspective, 0.4f);
  const Ray reference = looking_down_y(CameraKind::Perspective, 0.0f).generate_ray({80, 30}, {0.5f, 0.5f}, 0.0f);
  const Vec3 focus = reference.origin + reference.direction * (3.0f / reference.direction.y);
  Pcg32 rng(5);
  for (int i = 0; i < 100; ++i) {
    const Ray ray = camera.generate_ray({80, 30}, {rng.next_float(), rng.next_float()}, 0.0f);
    EXPECT_NEAR(ray.origin.y, -5.0f, 1e-5f);
    const Vec3 met = ray.origin + ray.direction * ((focus.y - ray.origin.y) / ray.direction.y);
    EXPECT_LT(glm::length(met - focus), 1e-4f);
  }
}

TEST(Camera, orthographic_rays_are_parallel) {
  const Camera camera = looking_down_y(CameraKind::Orthographic, 0.0f);
  const Ray ray = camera.generate_ray({100, 0}, {0.5f, 0.5f}, 0.0f);
  EXPECT_NEAR(ray.direction.y, 1.0f, 1e-6f);
  EXPECT_NEAR(ray.origin.x, 0.5f, 1e-5f);
  EXPECT_NEAR(ray.origin.z, -0.5f, 1e-5f);
}

// The camera looks along y, so that the right eye is at +x of the centre for the ray in the middle.
TEST(Camera, an_eye_of_spherical_stereoscopy_is_beside_each_ray) {
  for (const CameraKind kind : {CameraKind::Perspective, CameraKind::Panorama}) {
    SceneDescription d;
    fixtures::set_camera(d, Vec3(0, -5, 0), Vec3(0), 100);
    d.camera.kind = kind;
    if (kind == CameraKind::Panorama) d.camera.screen_window = Vec4(0, 1, 0, 1);
    const Camera centre(d.camera, 100, 100);
    d.camera.stereo.offset = 0.1f;
    const Camera right(d.camera, 100, 100);
    d.camera.stereo.convergence = 2.0f;
    const Camera converging(d.camera, 100, 100);
    for (const Vec2 film : {Vec2(50, 50), Vec2(20, 60), Vec2(90, 30)}) {
      const Ray from = centre.generate_ray(film, Vec2(0.5f), 0.0f), ray = right.generate_ray(film, Vec2(0.5f), 0.0f),
                meets = converging.generate_ray(film, Vec2(0.5f), 0.0f);
      const Vec3 moved = ray.origin - from.origin;
      EXPECT_NEAR(glm::length(moved), 0.1f, 1e-6f);
      EXPECT_NEAR(moved.z, 0.0f, 1e-6f);
      EXPECT_NEAR(glm::dot(moved, from.direction), 0.0f, 1e-6f);
      EXPECT_GT(glm::dot(moved, glm::cross(from.direction, Vec3(0, 0, 1))), 0.0f);
      EXPECT_LT(glm::length(ray.direction - from.direction), 1e-6f);
      const Vec3 target = from.origin + 2.0f * from.direction, towards = target - meets.origin;
      EXPECT_LT(glm::length(glm::normalize(towards) - meets.direction), 1e-5f);
    }
    EXPECT_FALSE(right.finds_film(0.0f));
  }
}

TEST(Camera, eyes_of_spherical_stereoscopy_merge_towards_the_poles) {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0, -5, 0), Vec3(0), 100);
  d.camera.kind = CameraKind::Panorama;
  d.camera.screen_window = Vec4(0, 1, 0, 1);
  d.camera.stereo = {0.1f, 0.0f, 0.25f * kPi, 0.375f * kPi};
  const Camera camera(d.camera, 100, 100);
  const auto moved = [&](float altitude) {
    const Ray ray = camera.generate_ray(Vec2(50, 50.0f + 100.0f * altitude / kPi), Vec2(0.5f), 0.0f);
    return glm::length(ray.origin - Vec3(0, -5, 0));
  };
  EXPECT_NEAR(moved(0.2f * kPi), 0.1f, 1e-5f);
  EXPECT_NEAR(moved(0.3125f * kPi), 0.1f * std::sqrt(0.5f), 1e-5f);
  EXPECT_NEAR(moved(0.4f * kPi), 0.0f, 1e-6f);
}

TEST(Camera, scale_of_the_camera_object_changes_nothing) {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0, -5, 0), Vec3(0), 100);
  const Ray plain = Camera(d.camera, 100, 100).generate_ray({10, 20}, {0.5f, 0.5f}, 0.0f);
  for (int i = 0; i < 12; ++i) {
    if (i % 4 != 3) d.camera.world_from_camera[size_t(i)] *= 7.0f;
  }
  const Ray scaled = Camera(d.camera, 100, 100).generate_ray({10, 20}, {0.5f, 0.5f}, 0.0f);
  EXPECT_LT(glm::length(plain.direction - scaled.direction), 1e-6f);
}

class CameraImportance : public ::testing::TestWithParam<std::pair<CameraKind, float>> {};

TEST_P(CameraImportance, film_of_returns_the_film_point_of_a_ray) {
  const Camera camera = looking_down_y(GetParam().first, GetParam().second);
  Pcg32 rng(7);
  for (int i = 0; i < 200; ++i) {
    const Vec2 film(100.0f * rng.next_float(), 100.0f * rng.next_float()), u_lens(rng.next_float(), rng.next_float());
    const Ray ray = camera.generate_ray(film, u_lens, 0.0f);
    const auto found = camera.film_of(camera.sample_lens(u_lens),
                                      ray.origin + (0.5f + 7.0f * rng.next_float()) * ray.direction, 0.0f);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->x, film.x, 2e-3f);
    EXPECT_NEAR(found->y, film.y, 2e-3f);
  }
  EXPECT_FALSE(camera.film_of(Vec2(0.0f), Vec3(0, -6, 0), 0.0f));
}

TEST_P(CameraImportance, film_density_is_the_jacobian_of_the_ray) {
  const Camera camera = looking_down_y(GetParam().first, GetParam().second);
  const bool parallel = camera.is_orthographic();
  Pcg32 rng(8);
  for (int i = 0; i < 50; ++i) {
    const Vec2 film(5.0f + 90.0f * rng.next_float(), 5.0f + 90.0f * rng.next_float()),
        u_lens(rng.next_float(), rng.next_float());
    // The direction of a ray, or the point at which a parallel ray crosses a plane perpendicular to it.
    const auto at = [&](float dx, float dy) {
      const Ray ray = camera.generate_ray(film + Vec2(dx, dy), u_lens, 0.0f);
      return parallel ? ray.origin - glm::dot(ray.origin, ray.direction) * ray.direction : ray.direction;
    };
    const Vec3 du = at(2, 0) - at(-2, 0), dv = at(0, 2) - at(0, -2);
    const float area = glm::length(glm::cross(du, dv)) / 16.0f;
    EXPECT_NEAR(camera.film_density(camera.generate_ray(film, u_lens, 0.0f).direction, 0.0f) * area, 1.0f, 2e-3f);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, CameraImportance,
                         ::testing::Values(std::pair(CameraKind::Perspective, 0.0f),
                                           std::pair(CameraKind::Perspective, 0.3f),
                                           std::pair(CameraKind::Orthographic, 0.0f),
                                           std::pair(CameraKind::Orthographic, 0.3f)));

TEST(Camera, density_on_the_lens_is_one_over_its_area) {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0), Vec3(0, 0, -1), 10);
  d.camera.aperture_radius = 0.5f;
  d.camera.aperture_ratio = 2.0f;
  EXPECT_NEAR(Camera(d.camera, 10, 10).pdf_lens_area(), 2.0f / (kPi * 0.25f), 1e-4f);
  d.camera.blades = 4;
  d.camera.aperture_ratio = 1.0f;
  EXPECT_NEAR(Camera(d.camera, 10, 10).pdf_lens_area(), 1.0f / 0.5f, 1e-4f);
}

class PanoramicCamera : public ::testing::TestWithParam<PanoramaKind> {
 protected:
  /// A camera of this kind, whose limits and frame show no direction twice.
  static SceneDescription scene() {
    SceneDescription d;
    fixtures::set_camera(d, Vec3(0.3f, -5, 1), Vec3(0.1f, 0.4f, -0.2f), 100);
    d.camera.kind = CameraKind::Panorama;
    d.camera.screen_window = Vec4(0, 1, 0, 1);
    d.camera.clip_start = 0.01f;
    d.camera.panorama.kind = GetParam();
    d.camera.panorama.limits = Vec4(-2.5f, 3.0f, -1.2f, 1.3f);
    d.camera.panorama.fisheye_fov = 4.0f;
    d.camera.panorama.sensor = Vec2(30.0f, 27.0f);
    return d;
  }
};

TEST_P(PanoramicCamera, film_of_returns_the_film_point_of_a_ray) {
  const Camera camera(scene().camera, 100, 80);
  EXPECT_TRUE(camera.finds_film(2.0f));
  Pcg32 rng(7);
  int seen = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec2 film(100.0f * rng.next_float(), 80.0f * rng.next_float());
    const Ray ray = camera.generate_ray(film, Vec2(0.5f), 0.0f);
    EXPECT_EQ(camera.sees(film), !sees_nothing(ray));
    if (sees_nothing(ray)) continue;
    ++seen;
    EXPECT_NEAR(glm::length(ray.direction), 1.0f, 1e-5f);
    const auto found = camera.film_of(Vec2(0.0f), ray.origin + (0.5f + 7.0f * rng.next_float()) * ray.direction, 0.0f);
    ASSERT_TRUE(found);
    EXPECT_LT(glm::length(*found - film), 5e-3f);
  }
  EXPECT_GT(seen, 150);
}

TEST_P(PanoramicCamera, film_density_is_the_jacobian_of_the_ray) {
  const Camera camera(scene().camera, 100, 80);
  Pcg32 rng(8);
  for (int i = 0; i < 100; ++i) {
    const Vec2 film(5.0f + 90.0f * rng.next_float(), 5.0f + 70.0f * rng.next_float());
    if (!camera.sees(film + Vec2(3, 3)) || !camera.sees(film + Vec2(3, -3)) || !camera.sees(film + Vec2(-3, 3)) ||
        !camera.sees(film - Vec2(3, 3)))
      continue;
    const auto at = [&](float dx, float dy) {
      return camera.generate_ray(film + Vec2(dx, dy), Vec2(0.5f), 0.0f).direction;
    };
    const float area = glm::length(glm::cross(at(0.5f, 0) - at(-0.5f, 0), at(0, 0.5f) - at(0, -0.5f)));
    EXPECT_NEAR(camera.film_density(at(0, 0), 0.0f) * area, 1.0f, 5e-3f);
  }
}

/// The integral of the density over the sphere is the visible area of the film, so that splats reach all that rays see.
TEST_P(PanoramicCamera, density_integrates_to_the_visible_area_of_the_film) {
  const Camera camera(scene().camera, 100, 80);
  Pcg32 rng(9);
  double by_direction = 0.0, by_film = 0.0;
  constexpr int kDraws = 40000;
  for (int i = 0; i < kDraws; ++i) {
    const Vec3 direction = warp::square_to_sphere({rng.next_float(), rng.next_float()});
    const auto film = camera.film_of(Vec2(0.0f), camera.position() + direction, 0.0f);
    if (film && film->x >= 0.0f && film->x < 100.0f && film->y >= 0.0f && film->y < 80.0f)
      by_direction += double(camera.film_density(direction, 0.0f)) * 4.0 * double(kPi) / kDraws;
    by_film += camera.sees({100.0f * rng.next_float(), 80.0f * rng.next_float()}) ? 8000.0 / kDraws : 0.0;
  }
  EXPECT_NEAR(by_direction / by_film, 1.0, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Kinds, PanoramicCamera,
                         ::testing::Values(PanoramaKind::Equirectangular, PanoramaKind::FisheyeEquidistant,
                                           PanoramaKind::FisheyeEquisolid, PanoramaKind::MirrorBall,
                                           PanoramaKind::CubemapFace));

TEST(Camera, paths_are_not_connected_to_panoramas_that_see_a_direction_twice) {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0), Vec3(0, 1, 0), 100);
  d.camera.kind = CameraKind::Panorama;
  d.camera.screen_window = Vec4(0, 1, 0, 1);
  const auto finds = [&] { return Camera(d.camera, 100, 50).finds_film(1.5f); };
  EXPECT_FALSE(finds());  // the image shows the whole sphere and a little more at the seam
  d.camera.panorama.limits = Vec4(-3, 3, -1.4f, 1.4f);
  EXPECT_TRUE(finds());
  d.camera.aperture_radius = 0.1f;  // the lens turns with the direction of view
  EXPECT_FALSE(finds());
  d.camera.aperture_radius = 0.0f;
  d.camera.panorama.kind = PanoramaKind::FisheyeEquidistant;
  d.camera.panorama.fisheye_fov = 7.0f;
  EXPECT_FALSE(finds());
  d.camera.panorama.kind = PanoramaKind::FisheyePolynomial;
  EXPECT_FALSE(finds());
}

TEST(Camera, a_linear_polynomial_lens_equals_an_equidistant_one) {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0), Vec3(0, 1, 0), 100);
  d.camera.kind = CameraKind::Panorama;
  d.camera.screen_window = Vec4(0, 1, 0, 1);
  d.camera.panorama.kind = PanoramaKind::FisheyeEquidistant;
  const Camera equidistant(d.camera, 100, 100);
  d.camera.panorama.kind = PanoramaKind::FisheyePolynomial;
  d.camera.panorama.sensor = Vec2(20.0f, 20.0f);
  d.camera.panorama.polynomial = {0, -0.05f * kPi, 0, 0, 0};
  const Camera polynomial(d.camera, 100, 100);
  for (const Vec2 film : {Vec2(50, 50), Vec2(20, 70), Vec2(80, 33)})
    EXPECT_LT(glm::length(equidistant.generate_ray(film, Vec2(0.5f), 0).direction -
                          polynomial.generate_ray(film, Vec2(0.5f), 0).direction),
              1e-5f);
  EXPECT_TRUE(sees_nothing(polynomial.generate_ray({2, 2}, Vec2(0.5f), 0)));
}

TEST(Camera, all_rays_of_a_panorama_with_a_lens_meet_at_the_distance_of_focus) {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0), Vec3(0, 1, 0), 100);
  d.camera.kind = CameraKind::Panorama;
  d.camera.screen_window = Vec4(0, 1, 0, 1);
  const Ray reference = Camera(d.camera, 100, 50).generate_ray({90, 40}, Vec2(0.5f), 0);
  d.camera.aperture_radius = 0.2f;
  d.camera.focus_distance = 3.0f;
  const Camera camera(d.camera, 100, 50);
  const Vec3 focus = 3.0f * reference.direction;
  Pcg32 rng(6);
  for (int i = 0; i < 50; ++i) {
    const Ray ray = camera.generate_ray({90, 40}, {rng.next_float(), rng.next_float()}, 0.0f);
    EXPECT_NEAR(glm::dot(ray.origin, reference.direction), 0.0f, 1e-5f);
    EXPECT_LT(glm::length(glm::cross(focus - ray.origin, ray.direction)), 1e-4f);
  }
}

TEST(Camera, the_first_blade_is_perpendicular_to_the_rotation) {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0), Vec3(0, 0, -1), 10);
  d.camera.world_from_camera = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  d.camera.aperture_radius = 1.0f;
  d.camera.blades = 4;
  const auto furthest = [&](Vec2 along) {
    const Camera camera(d.camera, 10, 10);
    Pcg32 rng(3);
    float most = 0.0f;
    for (int i = 0; i < 4000; ++i)
      most = std::max(most, glm::dot(camera.sample_lens({rng.next_float(), rng.next_float()}), along));
    return most;
  };
  EXPECT_NEAR(furthest({1, 0}), std::sqrt(0.5f), 0.02f);  // an edge of the aperture, not a corner
  d.camera.blade_rotation = 0.25f * kPi;
  EXPECT_NEAR(furthest({1, 0}), 1.0f, 0.04f);
}

TEST(Camera, an_orthographic_lens_is_at_the_near_clipping_plane) {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0, -5, 0), Vec3(0), 100);
  d.camera.kind = CameraKind::Orthographic;
  d.camera.aperture_radius = 0.3f;
  d.camera.focus_distance = 2.0f;
  d.camera.clip_start = 1.5f;
  const Camera camera(d.camera, 100, 100);
  Pcg32 rng(5);
  for (int i = 0; i < 50; ++i) {
    const Vec2 u_lens(rng.next_float(), rng.next_float());
    const Ray ray = camera.generate_ray({50, 50}, u_lens, 0.0f);
    EXPECT_NEAR(ray.origin.y, -3.5f, 1e-5f);
    EXPECT_NEAR(ray.t_min, 0.0f, 1e-6f);
    const Vec3 met = ray.origin + ray.direction * ((-1.5f - ray.origin.y) / ray.direction.y);  // in focus at distance 2
    EXPECT_LT(glm::length(met - Vec3(0, -1.5f, 0)), 1e-4f);
    const auto found = camera.film_of(camera.sample_lens(u_lens), ray.origin + 4.0f * ray.direction, 0.0f);
    ASSERT_TRUE(found);
    EXPECT_LT(glm::length(*found - Vec2(50, 50)), 2e-3f);
  }
}

constexpr std::array kUp{Vec3(0, 0, 1), Vec3(0, 0, 1), Vec3(0, 0, 1)};

/// A film of two pixels: the first sees a triangle of the plane z = 2 from above, the second nothing.
Camera two_texels() {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0, -5, 0), Vec3(0), 2);
  d.camera.kind = CameraKind::Texels;
  d.camera.texels = {
      {true, {Vec3(1, 0, 2), Vec3(0, 1, 2), Vec3(0, 0, 2)}, kUp, {0.2f, 0.3f}, {0.1f, 0.0f}, {0.0f, 0.4f}}, {}};
  return Camera(d.camera, 2, 1);
}

TEST(Camera, texels_see_their_place_from_just_above) {
  const Camera camera = two_texels();
  for (const Vec2 offset : {Vec2(0.0f), Vec2(0.4f, -0.3f), Vec2(-0.49f, 0.49f)}) {
    const Ray ray = camera.generate_ray(Vec2(0.5f) + offset, Vec2(0.5f), 0.0f);
    EXPECT_EQ(ray.direction, Vec3(0, 0, -1));
    EXPECT_NEAR(ray.origin.x, 0.2f + 0.1f * offset.x, 1e-6f);
    EXPECT_NEAR(ray.origin.y, 0.3f + 0.4f * offset.y, 1e-6f);
    EXPECT_GT(ray.origin.z, 2.0f);
    EXPECT_LT(ray.origin.z, 2.001f);
    EXPECT_LT(ray.origin.z - ray.t_max, 2.0f);
  }
  EXPECT_TRUE(sees_nothing(camera.generate_ray({1.5f, 0.5f}, Vec2(0.5f), 0.0f)));
  EXPECT_TRUE(camera.sees({0.5f, 0.5f}));
  EXPECT_FALSE(camera.sees({1.5f, 0.5f}));
  EXPECT_FALSE(camera.finds_film(0.0f));
}

TEST(Camera, texels_reflect_points_outside_their_triangle) {
  SceneDescription d;
  fixtures::set_camera(d, Vec3(0, -5, 0), Vec3(0), 1);
  d.camera.kind = CameraKind::Texels;
  d.camera.texels = {{true, {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0)}, kUp, {0.1f, 0.8f}, {1.0f, 0.0f}, {0.0f, 1.0f}}};
  const Camera camera(d.camera, 1, 1);
  Pcg32 rng(3);
  for (int i = 0; i < 200; ++i) {
    const Vec3 at = camera.generate_ray({rng.next_float(), rng.next_float()}, Vec2(0.5f), 0.0f).origin;
    EXPECT_TRUE(at.x >= 0.0f && at.y >= 0.0f && at.x + at.y <= 1.0f + 1e-6f) << at.x << " " << at.y;
  }
  const Vec3 at = camera.generate_ray({0.5f - 0.3f, 0.5f + 0.2f}, Vec2(0.5f), 0.0f).origin;
  EXPECT_NEAR(at.x, 0.2f, 1e-6f);                // -0.2, reflected at 0
  EXPECT_NEAR(at.y, 2.0f * 0.8f - 1.0f, 1e-6f);  // 1, reflected at 1 - 0.2
}

}  // namespace ajar::test_camera
