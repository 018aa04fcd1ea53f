#include <gtest/gtest.h>

#include "geometry/motion.h"
#include "integrators/integrator.h"
#include "integrators/render_plan.h"
#include "math/random.h"
#include "math/warps.h"
#include "render/session.h"
#include "transport_scenes.h"

namespace ajar::test_motion {

using namespace fixtures;

namespace {

Mat4 turned(float angle, Vec3 position, float scale = 1.0f) {
  const float c = scale * std::cos(angle), s = scale * std::sin(angle);
  return Mat4(Vec4(c, s, 0, 0), Vec4(-s, c, 0, 0), Vec4(0, 0, scale, 0), Vec4(position, 1));
}

void move(SceneDescription& d, size_t instance, std::initializer_list<Mat4> keys) {
  d.instances[instance].first_motion_key = int(d.motion_keys.size());
  d.instances[instance].motion_key_count = int(keys.size());
  for (const Mat4& key : keys) d.motion_keys.push_back(rows(key));
}

/// An emissive square of side 1 before an orthographic camera that looks along +y and shows 4 metres with 16 pixels.
/// Tests move the square from x = -2 to 2.
SceneDescription sliding_square() {
  SceneDescription d;
  add_object(d, plane(0.5f), add_diffuse(d, Color(0.0f), Color(1.0f)), shining(Vec3(0), Vec3(0, 1, 0)));
  set_camera(d, Vec3(0, -5, 0), Vec3(0), 16);
  d.camera.kind = CameraKind::Orthographic;
  d.camera.screen_window = Vec4(-2, 2, -2, 2);
  d.settings.filter = FilterKind::Box;
  d.settings.threads = 2;
  return d;
}

std::vector<float> rendered(const SceneDescription& d, int samples) {
  Film film(0, 0, d.settings.width, d.settings.height, {"Combined"});
  const std::atomic<bool> stop{false};
  const auto integrator = make_integrator("path");
  integrator->prepare(build(d), 1);
  integrator->run_iteration(film, samples, stop);
  return film.resolve("Combined", 1.0f);
}

/// The green values of the middle row of pixels.
std::vector<float> middle_row(const std::vector<float>& image) {
  std::vector<float> row;
  for (size_t x = 0; x < 16; ++x) row.push_back(image[(8 * 16 + x) * 4 + 1]);
  return row;
}

/// The fraction of the time during which [-0.5, 0.5] + x(t) covers a point, for x(t) from -2 to 2; the mean over a
/// pixel.
float covered(int pixel) {
  double sum = 0.0;
  for (int i = 0; i < 100; ++i) {
    const double place = -2.0 + 0.25 * (pixel + (i + 0.5) / 100.0);
    sum += (std::min(place + 0.5, 2.0) - std::max(place - 0.5, -2.0)) / 4.0;
  }
  return float(sum / 100.0);
}

}  // namespace

TEST(Motion, rotations_follow_the_circle) {
  const std::vector<SplitTransform> keys{split(turned(0.2f, Vec3(1, 2, 3), 2.0f)),
                                         split(turned(1.8f, Vec3(3, 2, 1), 4.0f))};
  const Mat4 middle = interpolate(keys, 0.5f), expected = turned(1.0f, Vec3(2, 2, 2), 3.0f);
  for (int c = 0; c < 4; ++c) EXPECT_LT(glm::length(middle[c] - expected[c]), 1e-5f);
  const std::vector<Mat4> straight = straightened(keys, 129);
  EXPECT_EQ(straight.size(), 20u);  // 1.6 radians in steps of five degrees
  for (float t = 0.0f; t <= 1.0f; t += 0.01f) {
    Mat4 near;
    interpolate_straight(straight.data(), uint32_t(straight.size()), t, near);
    const Mat4 exact = interpolate(keys, t);
    // Maximum error, halfway between keys, by Taylor series: angle^2 / 8 of the radius plus a quarter of angle times
    // growth, for steps of 0.084 radians and a growth of 0.105.
    for (int c = 0; c < 3; ++c) EXPECT_LT(glm::length(near[c] - exact[c]), 0.00089f * 4.0f + 0.0023f);
  }
}

TEST(Motion, mirrored_and_sheared_matrices_are_split_and_joined_without_loss) {
  Pcg32 rng(4);
  for (int i = 0; i < 100; ++i) {
    Mat4 m(1.0f);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) m[c][r] = 4.0f * rng.next_float() - 2.0f;
    const Mat4 again = join(split(m));
    for (int c = 0; c < 4; ++c) EXPECT_LT(glm::length(again[c] - m[c]), 1e-4f);
  }
}

TEST(Motion, a_sliding_square_is_blurred_by_the_time_it_covers_each_pixel) {
  SceneDescription d = sliding_square();
  move(d, 0, {shining(Vec3(-2, 0, 0), Vec3(0, 1, 0)), shining(Vec3(2, 0, 0), Vec3(0, 1, 0))});
  const auto row = middle_row(rendered(d, 1024));
  for (int x = 0; x < 16; ++x)
    EXPECT_NEAR(row[size_t(x)], covered(x), 0.01f) << x;  // the maximum deviation of stratified times is 0.0044
}

TEST(Motion, a_camera_that_moves_in_the_opposite_direction_renders_the_same_image) {
  SceneDescription d = sliding_square();
  const auto at = [&](float x) {
    auto matrix = d.camera.world_from_camera;
    matrix[3] = x;
    return matrix;
  };
  d.camera.motion = {at(2.0f), at(-2.0f)};
  const auto row = middle_row(rendered(d, 1024));
  for (int x = 0; x < 16; ++x) EXPECT_NEAR(row[size_t(x)], covered(x), 0.01f) << x;
}

TEST(Motion, the_shutter_curve_weights_the_time) {
  SceneDescription d = sliding_square();
  move(d, 0, {shining(Vec3(-2, 0, 0), Vec3(0, 1, 0)), shining(Vec3(2, 0, 0), Vec3(0, 1, 0))});
  d.camera.shutter = {0.0f, 1e-4f, 2e-4f, 1.0f};  // two thirds of the light arrive while the square is on the left
  const auto row = middle_row(rendered(d, 1024));
  EXPECT_NEAR(row[0], 2.0f / 3.0f + covered(0) / 3.0f, 0.02f);
  EXPECT_NEAR(row[8], covered(8) / 3.0f, 0.01f);
}

/// Gives a mesh shapes that are its own, moved by these distances.
void deform(MeshDescription& mesh, std::initializer_list<Vec3> offsets) {
  for (const Vec3 offset : offsets)
    for (const Vec3 p : mesh.positions) mesh.motion_positions.push_back(p + offset);
}

TEST(Motion, a_square_that_deforms_is_blurred_as_one_that_slides) {
  for (const bool moves_too : {false, true}) {
    SceneDescription d = sliding_square();
    // In the space of the square, x is that of the world or the opposite; the blur is symmetric.
    deform(d.meshes[0], {Vec3(-1.0f, 0, 0), Vec3(0.0f), Vec3(1.0f, 0, 0)});
    const float rest = moves_too ? 1.0f : 0.0f;
    const Mat4 start = shining(Vec3(0), Vec3(0, 1, 0));
    const float sign = start[0].x > 0.0f ? 1.0f : -1.0f;
    if (moves_too)
      move(d, 0, {shining(Vec3(-sign * rest, 0, 0), Vec3(0, 1, 0)), shining(Vec3(sign * rest, 0, 0), Vec3(0, 1, 0))});
    const auto row = middle_row(rendered(d, 1024));
    const float reach = 1.0f + rest;  // the square moves from -reach to reach
    for (int x = 0; x < 16; ++x) {
      double expected = 0.0;
      for (int i = 0; i < 100; ++i) {
        const double place = -2.0 + 0.25 * (x + (i + 0.5) / 100.0);
        expected += std::max(0.0, std::min<double>(place + 0.5, reach) - std::max<double>(place - 0.5, -reach)) /
                    (2.0 * reach) / 100.0;
      }
      EXPECT_NEAR(row[size_t(x)], expected, 0.015f) << x << (moves_too ? " moves too" : "");
    }
  }
}

TEST(Motion, shading_points_are_on_the_shape_of_their_time) {
  SceneDescription d;
  MeshDescription mesh = sphere(16);
  mesh.normals.clear();
  for (const Vec3 p : mesh.positions) mesh.normals.push_back(p);
  mesh.normal_domain = Domain::Vertex;
  for (const float radius : {1.0f, 2.0f, 1.0f})
    for (const Vec3 p : mesh.positions) {
      mesh.motion_positions.push_back(radius * p);
      mesh.motion_normals.push_back(p);
    }
  for (const bool baked : {true, false}) {
    SceneDescription one = d;
    add_object(one, mesh, add_diffuse(one, Color(0.5f)), turned(0.4f, Vec3(3, 0, 0), 2.0f));
    set_camera(one, Vec3(0, -9, 0), Vec3(0), 8);
    const auto scene = build(one, nullptr, baked);
    EXPECT_TRUE(scene->moves());
    for (const float time : {0.0f, 0.25f, 0.5f, 0.9f, 1.0f}) {
      Ray ray;
      ray.origin = Vec3(3, -20, 0.1f);
      ray.direction = Vec3(0, 1, 0);
      ray.time = time;
      const Hit hit = scene->intersect(ray, kRayCamera);
      ASSERT_TRUE(hit.found());
      ShadingPoint point;
      scene->shading_point(ray, hit, point);
      const float radius = 2.0f * (time < 0.5f ? 1.0f + 2.0f * time : 3.0f - 2.0f * time);
      EXPECT_NEAR(glm::length(point.position - Vec3(3, 0, 0)), radius, 0.02f * radius) << time;
      EXPECT_LT(glm::length(point.position - ray.origin - hit.t * ray.direction), 1e-4f);
      EXPECT_LT(point.ns.y, -0.98f);
      // A ray that leaves the surface does not hit it again.
      EXPECT_FALSE(scene->intersect(scene->spawn_ray(point, point.ng), kRayDiffuse).found());
      Ray inwards = scene->spawn_ray(point, -point.ng);
      EXPECT_TRUE(scene->intersect(inwards, kRayDiffuse).found());
    }
  }
}

TEST(Motion, strands_and_points_deform) {
  SceneDescription d;
  MeshDescription cloud;
  cloud.name = "cloud";
  cloud.positions = {Vec3(0)};
  cloud.radii = {0.5f};
  cloud.motion_positions = {Vec3(-1, 0, 0), Vec3(1, 0, 0)};
  cloud.motion_radii = {0.25f, 0.75f};
  MeshDescription hair;
  hair.name = "hair";
  hair.positions = {Vec3(0, 0, -1), Vec3(0, 0, 1)};
  hair.radii = {0.1f, 0.1f};
  hair.strands = {0};
  hair.strand_shape = StrandShape::Round;
  hair.motion_positions = {Vec3(-1, 0, -1), Vec3(-1, 0, 1), Vec3(1, 0, -1), Vec3(1, 0, 1)};
  const auto hits_at = [&](const MeshDescription& mesh, float x, float time) {
    SceneDescription one = d;
    add_object(one, mesh, add_diffuse(one, Color(0.5f)), turned(0.0f, Vec3(0, 0, 5)));
    set_camera(one, Vec3(0, -9, 0), Vec3(0), 8);
    const auto scene = build(one);
    Ray ray;
    ray.origin = Vec3(x, -9, 5);
    ray.direction = Vec3(0, 1, 0);
    ray.time = time;
    const Hit hit = scene->intersect(ray, kRayCamera);
    if (!hit.found()) return -1.0f;
    ShadingPoint point;
    scene->shading_point(ray, hit, point);
    return -point.position.y;  // the radius, if the ray meets the middle
  };
  EXPECT_NEAR(hits_at(cloud, -1.0f, 0.0f), 0.25f, 1e-4f);
  EXPECT_NEAR(hits_at(cloud, 0.5f, 0.75f), 0.625f, 1e-4f);
  EXPECT_EQ(hits_at(cloud, -1.0f, 0.5f), -1.0f);
  EXPECT_NEAR(hits_at(hair, -1.0f, 0.0f), 0.1f, 1e-3f);
  EXPECT_NEAR(hits_at(hair, 0.5f, 0.75f), 0.1f, 1e-3f);
  EXPECT_EQ(hits_at(hair, 0.5f, 0.25f), -1.0f);
}

TEST(Motion, shapes_that_do_not_match_the_mesh_are_not_used) {
  for (const int fault : {0, 1, 2}) {
    SceneDescription d = sliding_square();
    deform(d.meshes[0], {Vec3(-1, 0, 0), Vec3(1, 0, 0)});
    if (fault == 0) d.meshes[0].motion_positions.pop_back();
    if (fault == 1) d.meshes[0].motion_positions[1].x = std::numeric_limits<float>::quiet_NaN();
    if (fault == 2) d.meshes[0].motion_normals.push_back(Vec3(0, 0, 1));
    Diagnostics diagnostics;
    const auto scene = build(d, &diagnostics);
    EXPECT_FALSE(scene->moves());
    ASSERT_EQ(diagnostics.size(), 1u);
    EXPECT_NE(diagnostics[0].message.find("without deformation"), std::string::npos);
  }
}

TEST(Motion, a_camera_that_zooms_shows_the_same_as_a_square_that_grows) {
  SceneDescription d = sliding_square();
  d.camera.window_motion = {Vec4(-1, 1, -1, 1), Vec4(-3, 3, -3, 3)};
  const auto row = middle_row(rendered(d, 1024));
  for (int x = 0; x < 16; ++x) {
    double expected = 0.0;
    for (int i = 0; i < 100; ++i) {
      // A place on the film at the fraction f of half its width is at f (1 + 2 t) metres.
      const double f = std::abs(-1.0 + 0.125 * (x + (i + 0.5) / 100.0));
      expected += std::clamp((0.5 / f - 1.0) / 2.0, 0.0, 1.0) / 100.0;
    }
    EXPECT_NEAR(row[size_t(x)], expected, 0.015f) << x;
  }
}

TEST(Motion, rows_of_a_rolling_shutter_see_their_own_time) {
  SceneDescription d = sliding_square();
  d.meshes[0] = plane(2.0f);  // covers half of the film at a time
  d.camera.row_exposure = 0.0f;
  move(d, 0, {shining(Vec3(-4, 0, 0), Vec3(0, 1, 0)), shining(Vec3(0, 0, 0), Vec3(0, 1, 0))});
  const auto image = rendered(d, 64);
  for (int y = 0; y < 16; ++y) {  // the top row is the first
    const double time = 1.0 - y / 16.0, edge = -2.0 + 4.0 * time;
    double covered_width = 0.0;
    for (int x = 0; x < 16; ++x) covered_width += 0.25 * image[size_t((y * 16 + x) * 4 + 1)];
    EXPECT_NEAR(covered_width, edge + 2.0, 0.1) << y;
  }
}

TEST(Motion, rays_that_leave_moving_surfaces_do_not_hit_them_again) {
  for (const float scale : {1e-3f, 1.0f, 1e3f}) {
    SceneDescription d;
    add_object(d, sphere(16), add_diffuse(d, Color(0.5f)), turned(0.0f, Vec3(0), scale));
    move(d, 0,
         {turned(0.0f, scale * Vec3(-3, 0, 1), scale), turned(2.0f, scale * Vec3(0, 5, 0), 2.0f * scale),
          turned(4.0f, scale * Vec3(3, -1, 0), scale)});
    set_camera(d, Vec3(0, -50, 0), Vec3(0), 4);
    const auto scene = build(d);
    Pcg32 rng(2);
    int met = 0, again = 0;
    for (int i = 0; i < 20000; ++i) {
      Ray ray;
      ray.origin = scale * Vec3(-20.0f + 40.0f * rng.next_float(), -30.0f, -5.0f + 10.0f * rng.next_float());
      ray.direction = glm::normalize(
          scale * Vec3(-3.0f + 6.0f * rng.next_float(), 3.0f * rng.next_float(), rng.next_float()) - ray.origin);
      ray.time = rng.next_float();
      const Hit hit = scene->intersect(ray, kRayCamera);
      if (!hit.found()) continue;
      ShadingPoint point;
      scene->shading_point(ray, hit, point);
      EXPECT_LT(glm::length(point.position - (ray.origin + hit.t * ray.direction)), 1e-3f * scale);
      const Vec3 local = warp::square_to_cosine_hemisphere({rng.next_float(), rng.next_float()});
      ++met;
      again += scene->intersect(scene->spawn_ray(point, Frame(point.ng).to_world(local)), kRayDiffuse).found();
    }
    EXPECT_GT(met, 1000);
    EXPECT_EQ(again, 0) << scale;
  }
}

TEST(Motion, objects_at_rest_have_no_keys_and_stay_baked) {
  SceneDescription d = sliding_square();
  const auto line = [&](const Scene& scene) {
    for (const PlanStep& step : make_render_plan(scene).steps)
      if (step.step == "motion keys") return step;
    return PlanStep{"missing", false, ""};
  };
  const auto still = build(d);
  EXPECT_EQ(line(*still).reason, "nothing moves while the shutter is open");
  EXPECT_FALSE(line(*still).used);
  EXPECT_TRUE(still->meshes()[0].baked);
  EXPECT_EQ(still->instances()[0].motion, nullptr);
  move(d, 0, {shining(Vec3(-2, 0, 0), Vec3(0, 1, 0)), shining(Vec3(2, 0, 0), Vec3(0, 1, 0))});
  const auto moving = build(d);
  EXPECT_TRUE(line(*moving).used);
  EXPECT_EQ(line(*moving).reason, "1 object moves");
  EXPECT_FALSE(moving->meshes()[0].baked);
}

TEST(Motion, keys_that_are_not_finite_are_ignored_and_reported) {
  SceneDescription d = sliding_square();
  move(d, 0, {shining(Vec3(-2, 0, 0), Vec3(0, 1, 0)), shining(Vec3(NAN, 0, 0), Vec3(0, 1, 0))});
  Diagnostics diagnostics;
  const auto scene = Scene::build(d, {}, diagnostics);
  EXPECT_FALSE(scene->moves());
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].message.find("motion is invalid"), std::string::npos);
}

}  // namespace ajar::test_motion
