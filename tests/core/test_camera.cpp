#include <gtest/gtest.h>

#include "math/random.h"
#include "scene_fixtures.h"

using namespace ajar;

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

TEST(Camera, centre_and_corner_of_the_film_look_where_the_screen_window_says) {
  const Camera camera = looking_down_y(CameraKind::Perspective, 0.0f);
  const Ray centre = camera.generate_ray({50, 50}, {0.5f, 0.5f}, 0.0f);
  EXPECT_NEAR(centre.direction.y, 1.0f, 1e-6f);
  const Ray corner = camera.generate_ray({100, 100}, {0.5f, 0.5f}, 0.0f);
  EXPECT_NEAR(corner.direction.x / corner.direction.y, 0.5f, 1e-5f);
  EXPECT_NEAR(corner.direction.z / corner.direction.y, 0.5f, 1e-5f);
}

TEST(Camera, every_ray_of_a_pixel_meets_in_the_plane_of_focus) {
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

TEST_P(CameraImportance, film_of_finds_where_a_ray_came_from) {
  const Camera camera = looking_down_y(GetParam().first, GetParam().second);
  Pcg32 rng(7);
  for (int i = 0; i < 200; ++i) {
    const Vec2 film(100.0f * rng.next_float(), 100.0f * rng.next_float()), u_lens(rng.next_float(), rng.next_float());
    const Ray ray = camera.generate_ray(film, u_lens, 0.0f);
    const auto found = camera.film_of(camera.sample_lens_point(u_lens), ray.origin + (0.5f + 7.0f * rng.next_float()) * ray.direction);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->x, film.x, 2e-3f);
    EXPECT_NEAR(found->y, film.y, 2e-3f);
  }
  EXPECT_FALSE(camera.film_of(camera.position(), Vec3(0, -6, 0)));
}

TEST_P(CameraImportance, film_density_is_the_jacobian_of_the_ray) {
  const Camera camera = looking_down_y(GetParam().first, GetParam().second);
  const bool parallel = camera.is_orthographic();
  Pcg32 rng(8);
  for (int i = 0; i < 50; ++i) {
    const Vec2 film(5.0f + 90.0f * rng.next_float(), 5.0f + 90.0f * rng.next_float()), u_lens(rng.next_float(), rng.next_float());
    // Directions of rays, or where parallel ones cross a plane perpendicular to them.
    const auto at = [&](float dx, float dy) {
      const Ray ray = camera.generate_ray(film + Vec2(dx, dy), u_lens, 0.0f);
      return parallel ? ray.origin - glm::dot(ray.origin, ray.direction) * ray.direction : ray.direction;
    };
    const Vec3 du = at(2, 0) - at(-2, 0), dv = at(0, 2) - at(0, -2);
    const float area = glm::length(glm::cross(du, dv)) / 16.0f;
    EXPECT_NEAR(camera.film_density(camera.generate_ray(film, u_lens, 0.0f).direction) * area, 1.0f, 2e-3f);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, CameraImportance,
                         ::testing::Values(std::pair(CameraKind::Perspective, 0.0f), std::pair(CameraKind::Perspective, 0.3f),
                                           std::pair(CameraKind::Orthographic, 0.0f), std::pair(CameraKind::Orthographic, 0.3f)));

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
