#include "view/surface_guides.h"

#include <gtest/gtest.h>

#include "render/session.h"
#include "transport_scenes.h"

namespace ajar::test_surface_guides {

using namespace fixtures;

namespace {

/// A red floor, and a mirror that stands on it and fills the upper part of the image.
SceneDescription stage(bool with_mirror) {
  SceneDescription d;
  const int red = add_diffuse(d, Color(0.7f, 0.2f, 0.1f));
  add_object(d, plane(30.0f), red);
  if (with_mirror) {
    const int mirror = add_glossy(d, 0.0f);
    const Mat4 upright(Vec4(1, 0, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, -1, 0, 0), Vec4(0, 4, 0, 1));
    add_object(d, plane(10.0f), mirror, upright);
  }
  set_camera(d, Vec3(0, -6, 4), Vec3(0, 0, 1), 96);
  d.settings.region = {0, 0, 96, 96};
  d.settings.threads = 2;
  d.settings.samples = 16;
  d.settings.passes = {"Combined", "Denoising Albedo", "Denoising Normal"};
  return d;
}

void expect_guides_of_the_film(const SceneDescription& d) {
  Session session;
  session.update(d);
  ASSERT_TRUE(session.wait(kHang));
  ASSERT_EQ(session.take_error(), "");
  const std::vector<float> albedo = session.snapshot("Denoising Albedo"), normal = session.snapshot("Denoising Normal");
  const std::atomic<bool> stop = false;
  const SurfaceGuides guides = trace_surface_guides(*build(d), d.camera, d.settings, stop);
  ASSERT_EQ(guides.albedo.size(), albedo.size());
  ASSERT_EQ(guides.normal.size(), normal.size());
  // At borders the film has the mean of two surfaces.
  size_t unlike = 0;
  for (size_t i = 0; i < albedo.size(); ++i)
    unlike += std::abs(albedo[i] - guides.albedo[i]) > 1e-3f || std::abs(normal[i] - guides.normal[i]) > 1e-3f;
  EXPECT_LT(unlike, albedo.size() / 10);
  EXPECT_GT(*std::max_element(albedo.begin(), albedo.end()), 0.69f);
}

}  // namespace

TEST(SurfaceGuides, those_of_the_film_without_light) { expect_guides_of_the_film(stage(false)); }

TEST(SurfaceGuides, a_mirror_has_those_of_what_it_shows) { expect_guides_of_the_film(stage(true)); }

TEST(SurfaceGuides, a_region_has_those_of_its_pixels) {
  SceneDescription d = stage(true);
  const std::atomic<bool> stop = false;
  const auto scene = build(d);
  const SurfaceGuides whole = trace_surface_guides(*scene, d.camera, d.settings, stop);
  d.settings.region = {3, 5, 20, 11};
  const SurfaceGuides part = trace_surface_guides(*scene, d.camera, d.settings, stop);
  ASSERT_EQ(part.albedo.size(), size_t(17 * 6 * 3));
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 17 * 3; ++x)
      EXPECT_EQ(part.albedo[size_t(y * 17 * 3 + x)], whole.albedo[size_t((y + 5) * 96 * 3 + 9 + x)]);
}

}  // namespace ajar::test_surface_guides
