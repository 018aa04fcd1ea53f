// Instances of meshes with few triangles are triangles of the top-level structure (scene/instance_crowds.h).
#include <gtest/gtest.h>

#include "math/warps.h"
#include "renders.h"
#include "transport_scenes.h"

namespace ajar::test_instance_crowds {
namespace {

using namespace fixtures;

constexpr uint32_t kCount = 300;

/// A leaf of two triangles that are not in one plane.
MeshDescription leaf() {
  MeshDescription mesh;
  mesh.name = "Leaf";
  mesh.positions = {Vec3(-0.1f, 0, 0), Vec3(0.1f, 0, 0.02f), Vec3(0.1f, 0.3f, 0), Vec3(-0.1f, 0.3f, 0.05f)};
  mesh.triangles = {UVec3(0, 1, 2), UVec3(0, 2, 3)};
  return mesh;
}

/// Any linear map, also mirrored and sheared.
std::array<float, 12> anywhere(Pcg32& rng) {
  Mat4 m(1.0f);
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) m[column][row] = 2.0f * rng.next_float() - 1.0f;
  return rows(m);
}

/// Two kinds of leaves, of which diffuse rays do not see the second, and a ball.
SceneDescription leaves() {
  // Later scenes keep the structures of meshes that are shared.
  static const auto shared_leaf = std::make_shared<const MeshDescription>(leaf()),
                    shared_ball = std::make_shared<const MeshDescription>(sphere());
  SceneDescription d;
  const int material = add_diffuse(d, Color(0.5f));
  Pcg32 rng(7);
  d.meshes.resize(2);
  d.meshes[0].shared = shared_leaf;
  d.meshes[1].shared = shared_ball;
  const auto add = [&](int mesh, const std::string& name) {
    ObjectDescription object;
    object.name = name;
    object.mesh = mesh;
    object.materials = {material};
    d.objects.push_back(object);
  };
  const auto place = [&](const std::array<float, 12>& at) {
    InstanceDescription instance;
    instance.object = int(d.objects.size()) - 1;
    instance.world_from_object = at;
    d.instances.push_back(instance);
  };
  add(0, "Leaves");
  for (uint32_t i = 0; i < kCount; ++i) place(anywhere(rng));
  add(0, "Hidden Leaves");
  d.objects.back().visibility = kVisibleAll & ~kVisibleDiffuse;
  for (uint32_t i = 0; i < kCount; ++i) place(anywhere(rng));
  add(1, "Balls");  // two, because a single one would be in world space
  for (const float x : {0.3f, -0.6f}) place(rows(moved(Vec3(x), 0.3f)));
  set_camera(d, Vec3(0.0f, -3.0f, 0.0f), Vec3(0.0f), 24);
  return d;
}

Ray random_ray(Pcg32& rng) {
  Ray ray;
  ray.origin = 2.0f * warp::square_to_sphere({rng.next_float(), rng.next_float()});
  const Vec3 to = warp::square_to_sphere({rng.next_float(), rng.next_float()}) * rng.next_float();
  ray.direction = glm::normalize(to - ray.origin);
  return ray;
}

TEST(InstanceCrowds, rays_meet_the_same_triangles_as_in_the_spaces_of_the_instances) {
  const auto scene = build(leaves());
  ASSERT_TRUE(scene->meshes()[0].crowded);
  EXPECT_FALSE(scene->meshes()[1].crowded);
  EXPECT_EQ(scene->statistics().placed_instances, 2u * kCount + 2u);
  Pcg32 rng(11);
  int found = 0, different = 0;
  for (int i = 0; i < 3000; ++i) {
    const Ray ray = random_ray(rng);
    for (const uint32_t kind : {uint32_t(kRayCamera), uint32_t(kRayDiffuse)}) {
      Hit nearest;
      nearest.instance = ~0u;
      nearest.t = kInfinity;
      const auto& instances = scene->instances();
      for (uint32_t k = 0; k < 2 * kCount; ++k) {
        if (!(instances[k].visibility & visibility_mask(kind))) continue;
        Hit own = scene->intersect_own(instances[k], ray);
        if (own.found() && own.t < nearest.t) nearest = own, nearest.instance = k;
      }
      const Hit hit = scene->intersect(ray, kind);
      if (hit.found() && hit.instance >= 2 * kCount) continue;  // a ball
      const bool is_leaf = hit.found();
      found += is_leaf;
      if (is_leaf && hit.instance == nearest.instance && hit.primitive == nearest.primitive) {
        EXPECT_NEAR(hit.t, nearest.t, 1e-4f * nearest.t);
        EXPECT_NEAR(hit.barycentric.x, nearest.barycentric.x, 0.02f);
        EXPECT_NEAR(hit.barycentric.y, nearest.barycentric.y, 0.02f);
      } else {
        different += is_leaf != (nearest.instance != ~0u) || is_leaf;
      }
    }
  }
  EXPECT_GT(found, 1000);
  EXPECT_LE(different, 6) << "only at edges and where leaves cross";
}

TEST(InstanceCrowds, a_ray_that_leaves_a_leaf_does_not_meet_it_again) {
  const auto scene = build(leaves());
  Pcg32 rng(13);
  int left = 0, met = 0;
  for (int i = 0; i < 20000; ++i) {
    const Ray ray = random_ray(rng);
    const Hit hit = scene->intersect(ray, kRayCamera);
    if (!hit.found() || hit.instance >= 2 * kCount) continue;
    ShadingPoint point;
    scene->shading_point(ray, hit, point);
    const Vec3 out = warp::square_to_sphere({rng.next_float(), rng.next_float()});
    const Hit next = scene->intersect(scene->spawn_ray(point, out), kRayCamera);
    ++left;
    met += next.found() && next.instance == hit.instance && next.primitive == hit.primitive;
  }
  EXPECT_GT(left, 5000);
  EXPECT_EQ(met, 0);
}

TEST(InstanceCrowds, leaves_far_from_the_origin_keep_their_spaces) {
  SceneDescription d = leaves();
  for (InstanceDescription& instance : d.instances) instance.world_from_object[3] += 1e5f;
  EXPECT_FALSE(build(std::move(d))->meshes()[0].crowded);
}

/// Each scene is built from the one before, and alone.
TEST(InstanceCrowds, follow_changes_of_the_scene) {
  SceneDescription d = leaves();
  const auto hits = [](const Scene& scene) {
    Pcg32 rng(17);
    std::vector<std::pair<uint32_t, float>> found;
    for (int i = 0; i < 2000; ++i) {
      const Hit hit = scene.intersect(random_ray(rng), kRayCamera);
      found.emplace_back(hit.instance, hit.found() ? hit.t : 0.0f);
    }
    return found;
  };
  Diagnostics ignored;
  auto scene = Scene::build(leaves(), {}, ignored);
  const auto expect_same_as_alone = [&](const char* change, size_t placed) {
    scene = Scene::build(SceneDescription(d), {}, ignored, std::move(scene));
    EXPECT_EQ(hits(*scene), hits(*Scene::build(SceneDescription(d), {}, ignored))) << change;
    EXPECT_EQ(scene->statistics().placed_instances, placed) << change;
  };
  Pcg32 rng(19);
  d.instances[3].world_from_object = anywhere(rng);
  expect_same_as_alone("a leaf moves", 2 * kCount + 2);
  d.instances[2 * kCount].world_from_object = rows(moved(Vec3(-0.3f), 0.4f));
  expect_same_as_alone("a ball moves", 1);
  expect_same_as_alone("nothing changes", 0);
  d.instances.erase(d.instances.begin() + 5);
  expect_same_as_alone("a leaf is removed", 2 * kCount + 1);
  d.objects[0].visibility = kVisibleAll & ~kVisibleCamera;
  expect_same_as_alone("leaves are hidden", 2 * kCount + 1);
}

}  // namespace
}  // namespace ajar::test_instance_crowds
