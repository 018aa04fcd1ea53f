#include <gtest/gtest.h>

#include "math/random.h"
#include "math/warps.h"
#include "scene_fixtures.h"
#include "shading/functions/point_functions.h"

namespace ajar::test_scene {

using namespace fixtures;

namespace {

SceneDescription one_object(MeshDescription mesh, const Mat4& transform) {
  SceneDescription d;
  add_object(d, std::move(mesh), add_diffuse(d, Color(0.5f)), transform);
  set_camera(d, Vec3(0, -5, 0), Vec3(0), 8);
  return d;
}

Mat4 scaled_and_moved(float scale, Vec3 position) {
  Mat4 m(scale);
  m[3] = Vec4(position, 1.0f);
  return m;
}

}  // namespace

class SelfIntersection : public ::testing::TestWithParam<std::tuple<float, float, bool>> {};

TEST_P(SelfIntersection, rays_that_leave_a_convex_body_never_hit_it_and_rays_inside_always_do) {
  const auto [scale, distance, baked] = GetParam();
  const Vec3 centre = Vec3(0.3f, -0.7f, 0.2f) * distance;
  const auto scene = build(one_object(cube(), scaled_and_moved(scale, centre)), nullptr, baked);
  Pcg32 rng(7);
  ShadingPoint point;
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 from = centre + 4.0f * scale * warp::square_to_sphere({rng.next_float(), rng.next_float()});
    const Vec3 to = centre + 0.9f * scale * warp::square_to_sphere({rng.next_float(), rng.next_float()});
    Ray ray;
    ray.origin = from;
    ray.direction = glm::normalize(to - from);
    const Hit hit = scene->intersect(ray, kRayCamera);
    if (!hit.found()) continue;
    ++hits;
    scene->shading_point(ray, hit, point);
    EXPECT_GT(glm::dot(point.ng, point.wo), 0.0f);
    const Vec3 local = warp::square_to_hemisphere({rng.next_float(), rng.next_float()});
    const Vec3 out = Frame(point.ng).to_world(local);
    EXPECT_FALSE(scene->intersect(scene->spawn_ray(point, out), kRayDiffuse).found())
        << "hit the surface that it left, ray " << i;
    EXPECT_TRUE(scene->intersect(scene->spawn_ray(point, -out), kRayTransmission).found())
        << "passed the body, ray " << i;
  }
  EXPECT_GT(hits, 15000);
}

INSTANTIATE_TEST_SUITE_P(Scales, SelfIntersection,
                         ::testing::Values(std::tuple(1.0f, 0.0f, true), std::tuple(1.0f, 0.0f, false),
                                           std::tuple(1e-5f, 0.0f, true), std::tuple(1e-5f, 0.0f, false),
                                           std::tuple(1e6f, 0.0f, true), std::tuple(1e6f, 0.0f, false),
                                           std::tuple(1.0f, 1e3f, true), std::tuple(1.0f, 1e3f, false)));

TEST(Scene, rays_that_leave_a_floor_at_zero_height_never_hit_it) {
  for (const bool bake : {true, false}) {
    const auto scene = build(one_object(plane(3.0f), Mat4(1.0f)), nullptr, bake);
    Pcg32 rng(4);
    for (int i = 0; i < 2000; ++i) {
      Ray ray;
      ray.origin = Vec3(6.0f * rng.next_float() - 3.0f, 6.0f * rng.next_float() - 3.0f, 2.0f);
      ray.direction = Vec3(0, 0, -1);
      const Hit hit = scene->intersect(ray, kRayCamera);
      if (!hit.found()) continue;
      ShadingPoint point;
      scene->shading_point(ray, hit, point);
      const Vec3 out = warp::square_to_hemisphere({rng.next_float(), rng.next_float()});
      ASSERT_FALSE(scene->intersect(scene->spawn_ray(point, out), kRayDiffuse).found())
          << "baked " << bake << ", ray " << i;
      ASSERT_GT(
          max_component(scene->transmittance(scene->spawn_segment(point, {out, 1.0f, point.position + out, -out}), 0)),
          0.0f)
          << "baked " << bake << ", ray " << i;
    }
  }
}

namespace {

/// The point of the floor below `from`, seen from above.
ShadingPoint floor_below(const Scene& scene, Vec3 from) {
  Ray ray;
  ray.origin = from;
  ray.direction = Vec3(0, 0, -1);
  const Hit hit = scene.intersect(ray, kRayCamera);
  EXPECT_TRUE(hit.found());
  ShadingPoint point;
  scene.shading_point(ray, hit, point);
  return point;
}
bool lit(const Scene& scene, const ShadingPoint& point, const LightSample& sample) {
  return max_component(scene.transmittance(scene.spawn_segment(point, sample), 0)) > 0.0f;
}

}  // namespace

/// A lampshade can be very close to its lamp. Here the gap is a hundred-thousandth of the distance to the receiver, in
/// scenes from a millimetre to a kilometre.
TEST(ShadowRays, an_object_just_before_a_light_blocks_it) {
  for (const float scale : {1e-3f, 1.0f, 1e3f}) {
    for (const std::string kind : {"point", "sphere", "rectangle", "ellipse", "triangles"}) {
      SceneDescription d;
      const float height = 10.0f * scale, gap = 1e-4f * scale, radius = kind == "sphere" ? 0.05f * scale : 0.0f;
      add_object(d, plane(10.0f * scale), add_diffuse(d, Color(0.5f)));
      add_object(d, plane(0.5f * scale), 0,
                 scaled_and_moved(1.0f, Vec3(0.3f * scale, 0.2f * scale, height - radius - gap)));
      LightDescription light = point_light(Vec3(0.3f * scale, 0.2f * scale, height), 10.0f, radius);
      light.kind = kind == "rectangle" || kind == "ellipse" ? LightKind::Area : LightKind::Point;
      light.area_shape = kind == "ellipse" ? AreaShape::Ellipse : AreaShape::Rectangle;
      light.area_size = Vec2(0.1f * scale);
      if (kind != "triangles")
        d.lights.push_back(light);
      else
        add_object(d, plane(0.05f * scale), add_diffuse(d, Color(0.0f), Color(5.0f)),
                   scaled_and_moved(1.0f, Vec3(0.3f * scale, 0.2f * scale, height)));
      set_camera(d, Vec3(0, -scale, scale), Vec3(0), 8);
      const auto scene = build(std::move(d));
      Pcg32 rng(5);
      int asked = 0, arrived = 0;
      for (int i = 0; i < 1000; ++i) {
        // Points further to the side would get light between the shade and the lamp.
        const ShadingPoint point = floor_below(
            *scene, scale * Vec3(10.0f * rng.next_float() - 5.0f, 10.0f * rng.next_float() - 5.0f, 1.0f));
        const auto sample = scene->lights().sample_li(uint32_t(i) % uint32_t(scene->lights().size()), point.position,
                                                      {rng.next_float(), rng.next_float()}, 0.0f);
        if (!sample || is_black(sample->radiance)) continue;
        ++asked;
        arrived += lit(*scene, point, *sample);
      }
      EXPECT_GT(asked, 400) << kind;
      EXPECT_EQ(arrived, 0) << kind << " at scale " << scale << " of " << asked;
    }
  }
}

/// From all directions, also nearly in its plane: an emissive triangle does not block its own light, and a ceiling does
/// not block a lamp in its plane.
TEST(ShadowRays, lights_do_not_block_themselves) {
  Pcg32 rng(6);
  for (const bool lamp : {false, true}) {
    for (const float away : {0.0f, 1.0f, 300.0f}) {
      int asked = 0, lost = 0;
      for (int turn = 0; turn < 60; ++turn) {
        const Frame frame(warp::square_to_sphere({rng.next_float(), rng.next_float()}));
        const Vec3 centre = away * Vec3(0.7f, -0.4f, 0.6f), place = centre + Vec3(0.1f, 0.2f, 2.0f);
        const Mat4 turned(Vec4(frame.s, 0), Vec4(frame.t, 0), Vec4(frame.n, 0), Vec4(place, 1));
        SceneDescription d;
        add_object(d, plane(4.0f), add_diffuse(d, Color(0.5f)), scaled_and_moved(1.0f, centre));
        add_object(d, plane(0.9f), add_diffuse(d, Color(0.0f), Color(lamp ? 0.0f : 5.0f)), turned);
        LightDescription light = point_light(Vec3(0.0f), 10.0f);
        light.kind = LightKind::Area;
        light.area_size = Vec2(0.8f);
        light.world_from_light = rows(turned);
        if (lamp) d.lights.push_back(light);
        set_camera(d, centre + Vec3(0, -1, 1), centre, 8);
        const auto scene = build(std::move(d), nullptr, turn % 2 == 0);
        for (int i = 0; i < 400; ++i) {
          // Every second point is close to the plane of the lamp.
          const float x = 6.0f * rng.next_float() - 3.0f, y = 6.0f * rng.next_float() - 3.0f;
          Vec3 from = centre + Vec3(x, y, 0.5f);
          if (i % 2 && std::abs(frame.n.x) > 0.2f)
            from.x = place.x +
                     (-frame.n.y * (from.y - place.y) + frame.n.z * 2.0f + 0.02f * (rng.next_float() - 0.5f)) /
                         frame.n.x;
          if (std::abs(from.x - centre.x) > 3.9f || glm::length(Vec2(from - place)) < 1.0f) continue;
          const ShadingPoint point = floor_below(*scene, from);
          const auto sample = scene->lights().sample_li(uint32_t(i) % uint32_t(scene->lights().size()), point.position,
                                                        {rng.next_float(), rng.next_float()}, 0.0f);
          if (!sample || is_black(sample->radiance)) continue;
          ++asked;
          lost += !lit(*scene, point, *sample);
        }
      }
      EXPECT_GT(asked, 3000);
      EXPECT_EQ(lost, 0) << (lamp ? "lamp" : "triangles") << " at " << away << " of " << asked;
    }
  }
}

TEST(Scene, instances_and_baked_meshes_give_the_same_shading_points) {
  Mat4 transform(Vec4(0.5f, 0.2f, 0, 0), Vec4(-0.3f, 1.5f, 0.1f, 0), Vec4(0, 0.4f, -0.8f, 0), Vec4(1, 2, 3, 1));
  const auto baked = build(one_object(sphere(), transform)),
             instanced = build(one_object(sphere(), transform), nullptr, false);
  Pcg32 rng(3);
  ShadingPoint a, b;
  int compared = 0;
  for (int i = 0; i < 2000; ++i) {
    Ray ray;
    ray.origin = Vec3(1, 2, 3) + 6.0f * warp::square_to_sphere({rng.next_float(), rng.next_float()});
    ray.direction = glm::normalize(Vec3(1, 2, 3) - ray.origin + Vec3(0.3f * rng.next_float()));
    const Hit ha = baked->intersect(ray, kRayCamera), hb = instanced->intersect(ray, kRayCamera);
    if (!ha.found() || !hb.found() || ha.primitive != hb.primitive) continue;
    baked->shading_point(ray, ha, a);
    instanced->shading_point(ray, hb, b);
    EXPECT_LT(glm::length(a.position - b.position), 1e-4f);
    EXPECT_GT(glm::dot(a.ng, b.ng), 0.9999f);
    EXPECT_GT(glm::dot(a.ns, b.ns), 0.9999f);
    EXPECT_EQ(a.backfacing, b.backfacing);
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

TEST(Scene, mirrored_objects_keep_the_direction_of_their_normals) {
  const auto scene = build(
      one_object(cube(), Mat4(Vec4(-1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, 0, 0, 1))));
  Ray ray;
  ray.origin = Vec3(0.1f, -5, 0.2f);
  ray.direction = Vec3(0, 1, 0);
  ShadingPoint point;
  scene->shading_point(ray, scene->intersect(ray, kRayCamera), point);
  EXPECT_FALSE(point.backfacing);
  EXPECT_NEAR(point.ng.y, -1.0f, 1e-6f);
}

TEST(Scene, flattened_objects_are_rendered_flat) {
  Mat4 flat(1.0f);
  flat[1][1] = 0.0f;
  for (bool shared : {false, true}) {
    SceneDescription d = one_object(cube(), flat);
    if (shared) d.instances.push_back({0, rows(scaled_and_moved(1.0f, Vec3(10, 0, 0))), 0.0f});
    const auto scene = build(std::move(d));
    Ray ray;
    ray.origin = Vec3(0.1f, -5, 0.2f);
    ray.direction = Vec3(0, 1, 0);
    const Hit hit = scene->intersect(ray, kRayCamera);
    ASSERT_TRUE(hit.found());
    EXPECT_NEAR(hit.t, 5.0f, 1e-5f);
  }
}

TEST(Scene, visibility_hides_objects_from_the_chosen_kind_of_ray_only) {
  SceneDescription d = one_object(cube(), Mat4(1.0f));
  d.objects[0].visibility = kVisibleAll & ~kVisibleCamera;
  const auto scene = build(std::move(d));
  Ray ray;
  ray.origin = Vec3(0, -5, 0);
  ray.direction = Vec3(0, 1, 0);
  EXPECT_FALSE(scene->intersect(ray, kRayCamera).found());
  EXPECT_TRUE(scene->intersect(ray, kRayDiffuse | kRayReflection).found());
  EXPECT_EQ(scene->transmittance(ray, 8), Color(0.0f));
}

TEST(Scene, bad_meshes_are_repaired_and_reported_by_name) {
  SceneDescription d = one_object(cube(), Mat4(1.0f));
  d.meshes[0].name = "Kaputt";
  d.meshes[0].positions[3].y = std::nanf("");
  d.meshes[0].triangles[0].x = 4000000;
  d.meshes[0].attributes.push_back({"short", Domain::Corner, 2, {1.0f}});
  Diagnostics diagnostics;
  const auto scene = build(std::move(d), &diagnostics);
  EXPECT_GT(scene->statistics().skipped_triangles, 0u);
  int named = 0;
  for (const Diagnostic& diagnostic : diagnostics) named += diagnostic.object == "Kaputt";
  EXPECT_EQ(named, 2);
}

/// Shading supports normals of vertices and of corners. It would read other normals beyond their end.
TEST(Scene, normals_of_faces_are_refused_and_reported_by_name) {
  SceneDescription d = one_object(cube(), Mat4(1.0f));
  d.meshes[0].name = "Faces";
  d.meshes[0].normal_domain = Domain::Face;
  d.meshes[0].normals.assign(d.meshes[0].triangles.size(), Vec3(0, 0, 1));
  Diagnostics diagnostics;
  const auto scene = build(std::move(d), &diagnostics);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_EQ(diagnostics[0].object, "Faces");
  EXPECT_TRUE(scene->meshes()[0].normals.empty());
}

TEST(Scene, lamps_with_a_non_finite_shape_are_omitted_and_reported_by_name) {
  for (float LightDescription::*field : {&LightDescription::spot_angle, &LightDescription::spot_blend,
                                         &LightDescription::sun_angle, &LightDescription::spread}) {
    SceneDescription d = one_object(cube(), Mat4(1.0f));
    d.lights.push_back(point_light(Vec3(0, 0, 3), 10.0f));
    d.lights.push_back(point_light(Vec3(0, 0, 4), 10.0f));
    d.lights[1].name = "Kaputt";
    d.lights[1].*field = std::nanf("");
    Diagnostics diagnostics;
    EXPECT_EQ(build(std::move(d), &diagnostics)->lights().lamp_count(), 1u);
    ASSERT_EQ(diagnostics.size(), 1u);
    EXPECT_EQ(diagnostics[0].object, "Kaputt");
  }
}

/// An instance whose transform has no inverse gets a mesh of its own in world space. Particles that have shrunk to
/// points or lines must not get one.
TEST(Scene, objects_shrunk_to_a_point_or_a_line_use_no_memory) {
  SceneDescription d = one_object(sphere(), Mat4(1.0f));
  Mat4 point(0.0f), line(0.0f), flat(1.0f);
  line[1][2] = 1e-3f;
  line[2][2] = 2e-3f;
  flat[0] = Vec4(0.0f);
  for (const Mat4& m : {point, line}) d.instances.insert(d.instances.end(), 500, {0, rows(m)});
  d.instances.push_back({0, rows(flat)});
  const auto scene = build(std::move(d));
  EXPECT_EQ(scene->instances().size(), 2u);
  EXPECT_EQ(scene->meshes().size(), 2u);
}

TEST(Scene, a_scene_without_camera_is_refused_with_a_message) {
  SceneDescription d = one_object(cube(), Mat4(1.0f));
  d.camera.present = false;
  try {
    build(std::move(d));
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("camera"), std::string::npos);
  }
}

/// An Embree with assertions, as that of Debian, terminates the program for any of these rays.
TEST(Scene, invalid_rays_hit_nothing_and_have_no_transmittance) {
  SceneDescription d;
  add_object(d, cube(), add_diffuse(d, Color(0.5f)));
  for (int i = 0; i < 30; ++i)
    d.lights.push_back(point_light(Vec3(float(i), 3, 0), 10.0f, 0.1f));  // enough lamps for a search structure
  set_camera(d, Vec3(0, -5, 0), Vec3(0), 8);
  const auto scene = build(d, nullptr, false);  // the cube has a structure of its own
  Ray good;
  good.origin = Vec3(0.1f, -5, 0.2f);
  good.direction = Vec3(0, 1, 0);
  ASSERT_TRUE(scene->intersect(good, kRayCamera).found());
  std::vector<Ray> bad(7, good);
  bad[0].origin.x = NAN;
  bad[1].origin.y = -1e30f;
  bad[2].direction = Vec3(NAN);
  bad[3].direction.z = kInfinity;
  bad[4].t_max = NAN;
  bad[5].t_min = -1.0f;
  bad[6].time = 2.0f;
  for (const Ray& ray : bad) {
    EXPECT_FALSE(scene->intersect(ray, kRayCamera).found());
    EXPECT_EQ(scene->intersect_lamp(ray, kRayCamera).light, ~0u);
    EXPECT_EQ(scene->transmittance(ray, 8), Color(0.0f));
    EXPECT_TRUE(scene->is_blocked_by(scene->instances()[0], ray));
  }
}

/// A valid ray can become invalid in the space of an instance.
TEST(Scene, instances_that_make_rays_infinite_do_not_terminate_the_program) {
  const auto shoot = [](const Scene& scene, Vec3 from, float time) {
    Ray ray;
    ray.origin = from;
    ray.direction = glm::normalize(-from);
    ray.time = time;
    scene.transmittance(ray, 0);
    return scene.intersect(ray, kRayCamera);
  };
  SceneDescription small = one_object(cube(), scaled_and_moved(1e-10f, Vec3(0.0f)));
  small.instances.push_back({0, rows(Mat4(1.0f))});  // a second instance, so that the mesh is not baked
  const auto tiny = build(std::move(small));
  EXPECT_NEAR(shoot(*tiny, Vec3(0, -5, 0), 0.0f).t, 4.0f, 1e-5f);
  EXPECT_FALSE(shoot(*tiny, Vec3(0, -1e10f, 0), 0.0f).found());
  // An unbounded shear between two keys. The object must stay at rest.
  SceneDescription sheared = one_object(cube(), Mat4(1.0f));
  Mat4 key(1.0f);
  key[0][1] = -3.5e16f;
  sheared.motion_keys = {rows(key), rows(Mat4(1.0f))};
  sheared.instances[0].motion_key_count = 2;
  const auto still = build(std::move(sheared));
  EXPECT_FALSE(still->moves());
  for (int i = 0; i <= 100; ++i) EXPECT_NEAR(shoot(*still, Vec3(0.1f, -5, 0), float(i) / 100.0f).t, 4.0f, 0.01f);
}

TEST(Scene, invalid_values_from_instancers_become_zero) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  SceneDescription d = one_object(cube(), Mat4(1.0f));
  d.instances.push_back(d.instances[0]);
  d.instance_origins.push_back({{1, nan, 3}, {nan, 5}, nan, 7, nan, 9, {nan, 11, 12}, {13, nan, 15}, {16, 17, nan}});
  d.instances[0].origin = 0;
  d.instances[1].origin = 1;  // there is none
  const auto scene = build(std::move(d));
  const InstanceOrigin& mended = *scene->instances()[0].origin;
  EXPECT_EQ(mended.generated, Vec3(1, 0, 3));
  EXPECT_EQ(mended.uv, Vec2(0, 5));
  EXPECT_EQ(Vec4(mended.index, mended.age, mended.lifetime, mended.size), Vec4(0, 7, 0, 9));
  EXPECT_EQ(mended.location, Vec3(0, 11, 12));
  EXPECT_EQ(mended.velocity, Vec3(13, 0, 15));
  EXPECT_EQ(mended.angular_velocity, Vec3(16, 17, 0));
  EXPECT_EQ(scene->instances()[1].origin, nullptr);
}

TEST(Scene, invalid_values_of_instances_are_left_out) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  SceneDescription d = one_object(cube(), Mat4(1.0f));
  d.objects[0].properties = {{"shade", true, Vec4(5.0f), 1}, {"beyond", true, Vec4(6.0f), 2}};
  d.instance_values = {2, {Vec4(1), Vec4(2), Vec4(3), {nan, 4, nan, 1}, Vec4(7)}};  // the last row is not complete
  for (int row = 0; row < 3; ++row) {
    d.instances.push_back(d.instances[0]);
    d.instances.back().values = row;
  }
  const auto scene = build(std::move(d));
  const auto shade = [&](size_t instance, const char* name) {
    ShadingPoint point;
    point.instance = &scene->instances()[instance];
    point.object = &scene->object(point.instance->object);
    return nodes::object_property(point, name, true);
  };
  EXPECT_EQ(shade(0, "shade"), Vec4(5.0f));
  EXPECT_EQ(shade(1, "shade"), Vec4(2.0f));
  EXPECT_EQ(shade(2, "shade"), Vec4(0, 4, 0, 1));
  EXPECT_EQ(shade(3, "shade"), Vec4(5.0f));
  EXPECT_EQ(shade(1, "beyond"), Vec4(6.0f));
}

TEST(Scene, empty_scenes_build) {
  SceneDescription d;
  set_camera(d, Vec3(0, -5, 0), Vec3(0), 1);
  const auto scene = build(std::move(d));
  EXPECT_TRUE(scene->lights().empty());
  EXPECT_FALSE(scene->intersect({}, kRayCamera).found());
}

TEST(Scene, objects_with_nan_transforms_are_omitted_and_reported) {
  SceneDescription d = one_object(cube(), Mat4(1.0f));
  d.objects[0].name = "Verirrt";
  d.instances[0].world_from_object[5] = std::nanf("");
  Diagnostics diagnostics;
  const auto scene = build(std::move(d), &diagnostics);
  EXPECT_TRUE(scene->instances().empty());
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_EQ(diagnostics[0].object, "Verirrt");
}

}  // namespace ajar::test_scene
