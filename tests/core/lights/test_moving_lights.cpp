// Emissive triangles of objects that move or change their shape: light sampling finds them where they are at the time.
#include <gtest/gtest.h>

#include "agreement.h"
#include "feature_scenes.h"

namespace ajar::test_moving_lights {

using namespace fixtures;

namespace {

const Mat4 kFrom = moved(Vec3(-0.6f, 0.1f, -0.2f), 0.15f), kTo = moved(Vec3(0.6f, 0.3f, 0.4f), 0.15f);

MeshDescription deforming_sphere(Vec3 first, Vec3 last) {
  MeshDescription mesh = sphere(8);
  for (const Vec3 factor : {first, last})
    for (const Vec3 p : mesh.positions) mesh.motion_positions.push_back(factor * p);
  return mesh;
}

/// A room with a small glowing sphere. If `deforms`, its shape changes too.
SceneDescription moving(bool deforms) {
  SceneDescription d = grey_room();
  MeshDescription mesh = deforms ? deforming_sphere(Vec3(0.5f, 1.0f, 1.5f), Vec3(2.0f, 1.0f, 0.3f)) : sphere(8);
  add_object(d, std::move(mesh), add_diffuse(d, Color(0.3f), Color(20.0f, 15.0f, 10.0f)), kFrom);
  move_instance(d, 1, kFrom, kTo);
  return d;
}

/// The same room as it is at one time.
SceneDescription frozen(bool deforms, float time) {
  SceneDescription d = grey_room();
  MeshDescription mesh = sphere(8);
  if (deforms)
    for (Vec3& p : mesh.positions) p *= (1.0f - time) * Vec3(0.5f, 1.0f, 1.5f) + time * Vec3(2.0f, 1.0f, 0.3f);
  add_object(d, std::move(mesh), add_diffuse(d, Color(0.3f), Color(20.0f, 15.0f, 10.0f)),
             (1.0f - time) * kFrom + time * kTo);
  return d;
}

}  // namespace

class MovingLights : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Shape, MovingLights, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "changes" : "stays"; });

TEST_P(MovingLights, are_sampled_where_they_are_at_the_time) {
  const auto scene = build(moving(GetParam()));
  const LightSet& lights = scene->lights();
  ASSERT_GT(lights.size(), 100u);
  EXPECT_TRUE(lights.any_moves());
  EXPECT_FALSE(scene->emission_without_lights());
  const Vec3 p(0.1f, -0.4f, -0.9f);
  Pcg32 rng(3);
  int seen = 0;
  for (int i = 0; i < 2000; ++i) {
    const float time = rng.next_float(), u = rng.next_float(), ux = rng.next_float(), uy = rng.next_float();
    const LightSet::Choice choice = lights.choose(p, Vec3(0, 0, 1), u);
    ASSERT_GT(choice.pmf, 0.0f);
    EXPECT_TRUE(lights.moves(choice.light));
    const auto s = lights.sample_li(choice.light, p, {ux, uy}, time);
    if (!s) continue;
    EXPECT_NEAR(lights.pdf_li(choice.light, p, s->wi, s->distance, s->normal, time), s->pdf_solid_angle,
                1e-3f * s->pdf_solid_angle);
    // Half of the triangles are behind the others.
    if (!(glm::dot(s->normal, s->wi) < -0.05f)) continue;
    Ray ray;
    ray.origin = p;
    ray.direction = s->wi;
    ray.time = time;
    const Hit hit = scene->intersect(ray, kRayDiffuse);
    ASSERT_TRUE(hit.found()) << time;
    EXPECT_NEAR(hit.t, s->distance, 1e-3f) << time;
    EXPECT_GE(scene->light_of(hit), 0);
    ++seen;
    // A shadow ray to the sample is not blocked by the light itself.
    EXPECT_GT(max_component(scene->transmittance(end_before(ray, *s), 8)), 0.0f) << time;
  }
  EXPECT_GT(seen, 500);
}

TEST_P(MovingLights, have_the_mean_of_the_scenes_at_all_times) {
  constexpr int kTimes = 32;
  double expected = 0.0, variance = 0.0;
  for (int i = 0; i < kTimes; ++i) {
    const RunningMoments still = whole(frozen(GetParam(), (float(i) + 0.5f) / kTimes), "path", 32, 4, uint32_t(10 * i));
    expected += still.mean() / kTimes;
    variance += still.variance_of_mean() / (kTimes * kTimes);
  }
  const RunningMoments found = whole(moving(GetParam()), "path", 64, 32, 1000);
  const double error = std::sqrt(found.variance_of_mean() + variance);
  EXPECT_LT(error, 0.0045 * expected) << "inconclusive";
  EXPECT_NEAR(found.mean(), expected, 4.0 * error);
}

/// A light of three centimetres that the camera does not see, and that random rays hardly ever meet.
TEST_P(MovingLights, have_about_the_noise_of_resting_ones) {
  SceneDescription d = moving(GetParam()), rests = frozen(GetParam(), 0.5f);
  for (SceneDescription* scene : {&d, &rests}) {
    scene->settings.bounces = {1, 1, 1, 1, 1, 0};
    scene->objects[1].visibility &= ~uint32_t(kVisibleCamera);
    for (MeshDescription& mesh : scene->meshes) {
      if (&mesh == &scene->meshes[0]) continue;  // the room
      for (Vec3& p : mesh.positions) p *= 0.1f;
      for (Vec3& p : mesh.motion_positions) p *= 0.1f;
    }
  }
  const RunningMoments found = whole(d, "path", 16, 32, 100), still = whole(rests, "path", 16, 32, 100);
  EXPECT_GT(found.mean(), 0.0);
  EXPECT_LT(found.variance() / sqr(found.mean()), 10.0 * still.variance() / sqr(still.mean()));
}

}  // namespace ajar::test_moving_lights
