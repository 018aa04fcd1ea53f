// The compact ray tracing structure finds what the other one finds.
#include <gtest/gtest.h>

#include "math/random.h"
#include "math/warps.h"
#include "scene_fixtures.h"

namespace ajar::test_compact_structure {
namespace {

using namespace fixtures;

SceneDescription ball_in_a_box(bool compact, const std::shared_ptr<const MeshDescription>& shared = nullptr) {
  SceneDescription d;
  const int material = add_diffuse(d, Color(0.5f));
  add_object(d, shared ? MeshDescription() : sphere(40), material);
  if (shared) d.meshes[0].shared = shared;
  add_object(d, cube(true), material, glm::scale(Mat4(1.0f), Vec3(3.0f)));
  d.instances.push_back(d.instances[0]);
  d.instances.back().world_from_object = rows(glm::translate(Mat4(1.0f), Vec3(1.7f, 0.4f, 0.9f)));
  set_camera(d, Vec3(0, -2, 0), Vec3(0), 8);
  d.settings.compact_bvh = compact;
  return d;
}

TEST(CompactStructure, finds_the_same_hits_and_has_few_gaps) {
  for (const bool bake : {true, false}) {
    const auto full = build(ball_in_a_box(false), nullptr, bake), compact = build(ball_in_a_box(true), nullptr, bake);
    EXPECT_LT(compact->statistics().accel_bytes, 0.65 * double(full->statistics().accel_bytes));
    Pcg32 rng(3);
    int different = 0;
    constexpr int kRays = 30000;
    for (int i = 0; i < kRays; ++i) {
      Ray ray;
      ray.origin = 2.5f * warp::square_to_sphere({rng.next_float(), rng.next_float()});
      ray.direction = warp::square_to_sphere({rng.next_float(), rng.next_float()});
      const Hit a = full->intersect(ray, kRayCamera), b = compact->intersect(ray, kRayCamera);
      ASSERT_TRUE(a.found());
      ASSERT_TRUE(b.found()) << "ray " << i << " leaves the box";
      different += a.instance != b.instance || a.primitive != b.primitive || std::abs(a.t - b.t) > 1e-5f * a.t;
    }
    EXPECT_LT(different, kRays / 3000) << "only at edges";
    // Through a vertex that faces the origin: of such rays, Embree lets a few pass in either structure.
    // Their number depends on the instructions of the processor: with AVX-512, 84 in the full
    // structure and 113 in the compact one.
    int passed[2] = {0, 0};
    for (int i = 0; i < kRays; ++i) {
      Ray ray;
      ray.origin = 2.5f * warp::square_to_sphere({rng.next_float(), rng.next_float()});
      const Vec3 vertex = compact->meshes()[0].positions[size_t(i) % 3200];  // of the unit sphere
      ray.direction = glm::normalize(vertex - ray.origin);
      if (glm::dot(ray.direction, vertex) > -0.1f) continue;
      const float distance = glm::length(vertex - ray.origin);
      passed[0] += full->intersect(ray, kRayCamera).t > distance + 1e-4f;
      passed[1] += compact->intersect(ray, kRayCamera).t > distance + 1e-4f;
    }
    for (const int number : passed) EXPECT_LT(number, kRays / 200);
  }
}

TEST(CompactStructure, shares_nothing_with_another_structure) {
  const auto shared = std::make_shared<const MeshDescription>(sphere(40));
  const auto next = [&](bool compact, std::shared_ptr<Scene> previous) {
    Diagnostics ignored;
    Scene::Options options;
    options.bake_single_instances = false;
    return Scene::build(ball_in_a_box(compact, shared), options, ignored, std::move(previous));
  };
  auto scene = next(false, nullptr);
  const uint64_t full = scene->statistics().accel_bytes;
  scene = next(true, scene);
  EXPECT_EQ(scene->statistics().kept_meshes, 1u);
  EXPECT_LT(double(scene->statistics().accel_bytes), 0.65 * double(full));
  Ray ray;
  ray.origin = Vec3(0, -2, 0);
  ray.direction = Vec3(0, 1, 0);
  EXPECT_NEAR(scene->intersect(ray, kRayCamera).t, 1.0f, 1e-3f);
  scene = next(true, scene);
  EXPECT_EQ(scene->statistics().placed_instances, 1u) << "only the box, which is not shared, is placed again";
  scene = next(false, scene);
  EXPECT_NEAR(double(scene->statistics().accel_bytes), double(full), 0.2 * double(full));
}

}  // namespace
}  // namespace ajar::test_compact_structure
