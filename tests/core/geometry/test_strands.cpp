// Strands of hair: intersections with rays, the shading point at a hit, and rays that leave strands.
#include "geometry/strands.h"

#include <gtest/gtest.h>

#include "integrators/integrator.h"
#include "math/random.h"
#include "math/warps.h"
#include "render/session.h"
#include "scene_fixtures.h"
#include "shading/functions/point_functions.h"
#include "transport_scenes.h"

namespace ajar::test_strands {

using namespace fixtures;

namespace {

constexpr StrandShape kShapes[] = {StrandShape::Ribbon, StrandShape::Round, StrandShape::Linear};

SceneDescription empty_scene() {
  SceneDescription d;
  set_camera(d, Vec3(0, -4, 0), Vec3(0), 16);
  return d;
}

/// A straight strand along z from 0 to 4, of radius 0.1, at x = y = 0.
MeshDescription straight(StrandShape shape) {
  return hair({{{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {0, 0, 3}, {0, 0, 4}}}, 0.1f, 0.1f, shape);
}

ShadingPoint met(const Scene& scene, Vec3 origin, Vec3 direction) {
  Ray ray;
  ray.origin = origin;
  ray.direction = glm::normalize(direction);
  ShadingPoint point;
  const Hit hit = scene.intersect(ray, kRayCamera);
  EXPECT_TRUE(hit.found());
  if (hit.found()) scene.shading_point(ray, hit, point);
  return point;
}

bool meets(const Scene& scene, Vec3 origin, Vec3 direction) {
  Ray ray;
  ray.origin = origin;
  ray.direction = glm::normalize(direction);
  return scene.intersect(ray, kRayCamera).found();
}

const Diagnostic* find(const Diagnostics& diagnostics, const std::string& text) {
  for (const Diagnostic& d : diagnostics)
    if (d.message.find(text) != std::string::npos) return &d;
  return nullptr;
}

}  // namespace

TEST(Strands, a_ray_does_not_hit_the_strand_that_it_leaves_and_hits_the_next_one) {
  for (const StrandShape shape : kShapes)
    for (const bool is_instance : {false, true}) {
      SceneDescription d = empty_scene();
      // The second strand is at a distance of three radii.
      const MeshDescription pair = hair({{{0, 0, 0}, {0, 0, 2}, {0, 0, 4}}, {{0.3f, 0, 0}, {0.3f, 0, 2}, {0.3f, 0, 4}}},
                                        0.1f, 0.1f, shape);
      const int object = add_object(d, pair, add_diffuse(d, Color(0.5f)));
      if (is_instance) {  // of two instances, neither is moved to world space
        d.instances.push_back(d.instances[size_t(object)]);
        d.instances.back().world_from_object = rows(moved(Vec3(0, 3, 0)));
      }
      const auto scene = build(d);
      const ShadingPoint point = met(*scene, Vec3(0.02f, -4, 2), Vec3(0, 1, 0));
      // Through the strand itself, and nearly along it.
      for (const Vec3 way : {Vec3(0.1f, 1, 0), Vec3(-0.02f, 0.02f, 1), Vec3(0.01f, 0, 1)}) {
        Ray ray = scene->spawn_ray(point, glm::normalize(way));
        ray.t_max = 1.0f;
        EXPECT_FALSE(scene->intersect(ray, kRayDiffuse).found());
        EXPECT_EQ(scene->transmittance(ray, 8), Color(1.0f));
      }
      const Ray across = scene->spawn_ray(point, Vec3(1, 0, 0));
      EXPECT_NEAR(scene->intersect(across, kRayDiffuse).t, shape == StrandShape::Ribbon ? 0.28f : 0.26f, 0.005f);
      EXPECT_EQ(scene->transmittance(across, 8), Color(0.0f));
    }
}

TEST(Strands, catmull_rom_interpolates_the_points_and_the_tangent_is_the_derivative) {
  MeshDescription mesh = hair({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {3, 1, 2}}, {{5, 5, 5}, {6, 5, 5}}}, 0.2f, 0.1f);
  const auto strands = make_strands(mesh);
  ASSERT_EQ(strands->segment_count(), 4u);
  const uint32_t point_of[] = {0, 1, 2, 4}, strand_of[] = {0, 0, 0, 1};
  for (uint32_t s = 0; s < 4; ++s) {
    EXPECT_EQ(strands->point_of(s), point_of[s]);
    EXPECT_EQ(strands->strand_of(s), strand_of[s]);
    EXPECT_EQ(strands->root(s), mesh.positions[strand_of[s] == 0 ? 0 : 4]);
    EXPECT_LT(glm::length(strands->center(s, 0.0f, 0.0f) - mesh.positions[point_of[s]]), 1e-6f);
    EXPECT_LT(glm::length(strands->center(s, 1.0f, 0.0f) - mesh.positions[point_of[s] + 1]), 1e-6f);
    for (float u : {0.1f, 0.5f, 0.8f}) {
      const Vec3 difference = (strands->center(s, u + 1e-2f, 0.0f) - strands->center(s, u - 1e-2f, 0.0f)) / 2e-2f;
      EXPECT_LT(glm::length(strands->tangent(s, u, 0.0f) - difference), 2e-3f) << s << " " << u;
    }
  }
  EXPECT_FLOAT_EQ(strands->lengths[0], 2.0f + std::sqrt(8.0f));
  EXPECT_FLOAT_EQ(strands->intercepts[1], 1.0f / strands->lengths[0]);
  EXPECT_FLOAT_EQ(strands->intercepts[3], 1.0f);
  EXPECT_FLOAT_EQ(strands->intercepts[4], 0.0f);
  EXPECT_FLOAT_EQ(strands->radius(3, 0.5f, 0.0f), 0.15f);
}

TEST(Strands, straight_pieces_have_round_joints_and_ends) {
  const MeshDescription bent = hair({{{0, 0, 0}, {0, 0, 1}, {1, 0, 1}}, {{3, 0, 0}, {3, 0, 1}}}, 0.1f, 0.1f,
                                    StrandShape::Linear);
  for (const bool bakes : {true, false}) {
    SceneDescription d = empty_scene();
    add_object(d, bent, add_diffuse(d, Color(0.5f)));
    const auto scene = build(d, nullptr, bakes);
    const Vec3 along(0, 1, 0);
    for (const float x : {0.0f, 3.0f}) {
      EXPECT_TRUE(meets(*scene, {x, -5, -0.08f}, along));
      EXPECT_TRUE(meets(*scene, {x + 0.06f, -5, -0.06f}, along));
      EXPECT_FALSE(meets(*scene, {x + 0.08f, -5, -0.08f}, along));  // outside the sphere, inside its box
      EXPECT_FALSE(meets(*scene, {x, -5, -0.11f}, along));
    }
    EXPECT_TRUE(meets(*scene, {-0.06f, -5, 1.06f}, along));
    EXPECT_FALSE(meets(*scene, {-0.08f, -5, 1.08f}, along));
    // A smooth curve would bend above the second piece.
    for (const float x : {0.2f, 0.5f, 0.8f}) {
      EXPECT_TRUE(meets(*scene, {x, -5, 1.09f}, along));
      EXPECT_FALSE(meets(*scene, {x, -5, 1.11f}, along));
      const ShadingPoint point = met(*scene, {x, -5, 1.05f}, along);
      EXPECT_LT(glm::length(point.ns - Vec3(0, -std::sqrt(0.75f), 0.5f)), 2e-3f);
      EXPECT_LT(glm::length(glm::normalize(point.dpdu) - Vec3(1, 0, 0)), 1e-4f);
      EXPECT_EQ(point.primitive, 1u);
    }
  }
}

TEST(Strands, hits_and_normals_are_those_of_a_tube) {
  for (const StrandShape shape : kShapes) {
    SceneDescription d = empty_scene();
    add_object(d, straight(shape), add_diffuse(d, Color(0.5f)));
    const auto scene = build(d);
    for (float x : {-0.09f, -0.05f, 0.0f, 0.03f, 0.08f}) {
      const ShadingPoint point = met(*scene, {x, -5, 1.3f}, {0, 1, 0});
      const Vec3 normal(x / 0.1f, -std::sqrt(1.0f - sqr(x / 0.1f)), 0.0f);
      EXPECT_LT(glm::length(point.ns - normal), 2e-3f)
          << x << " " << point.ns.x << " " << point.ns.y << " " << point.ns.z;
      EXPECT_EQ(point.ns, point.ng);
      EXPECT_FALSE(point.backfacing);
      EXPECT_NEAR(point.position.x, x, 1e-5f);
      EXPECT_NEAR(point.position.y, shape == StrandShape::Ribbon ? 0.0f : 0.1f * normal.y, 1e-4f);
      EXPECT_NEAR(point.position.z, 1.3f, 1e-5f);
      EXPECT_EQ(point.primitive, 1u);
      EXPECT_NEAR(point.barycentric.x, 0.3f, 1e-3f);
      EXPECT_LT(glm::length(glm::normalize(point.dpdu) - Vec3(0, 0, 1)), 1e-4f);
    }
    EXPECT_FALSE(meets(*scene, {0.11f, -5, 1.3f}, {0, 1, 0}));
    EXPECT_FALSE(meets(*scene, {0.0f, -5, 4.3f}, {0, 1, 0}));
  }
}

TEST(Strands, instanced_and_baked_strands_give_the_same_hits) {
  const Mat4 matrix(Vec4(0, 2, 0, 0), Vec4(-2, 0, 0, 0), Vec4(0, 0, 2, 0), Vec4(0.5f, 0.25f, 1, 1));
  for (const StrandShape shape : kShapes) {
    SceneDescription d = empty_scene();
    add_object(d, curls(40, shape), add_diffuse(d, Color(0.5f)), matrix);
    const auto baked = build(d), instanced = build(d, nullptr, false);
    EXPECT_TRUE(baked->meshes()[0].baked);
    EXPECT_FALSE(instanced->meshes()[0].baked);
    Pcg32 rng(8);
    int both = 0, one = 0, alike = 0;
    for (int i = 0; i < 20000; ++i) {
      Ray ray;
      ray.origin = Vec3(0.5f, 0.25f, 1) + 6.0f * warp::square_to_sphere({rng.next_float(), rng.next_float()});
      ray.direction = glm::normalize(Vec3(0.5f, 0.25f, 1) +
                                     2.5f * warp::square_to_sphere({rng.next_float(), rng.next_float()}) - ray.origin);
      const Hit a = baked->intersect(ray, kRayCamera), b = instanced->intersect(ray, kRayCamera);
      if (!a.found() || !b.found()) {
        one += a.found() != b.found() ? 1 : 0;
        continue;
      }
      ShadingPoint p, q;
      baked->shading_point(ray, a, p);
      instanced->shading_point(ray, b, q);
      ++both;
      const bool same = a.primitive == b.primitive && glm::length(p.position - q.position) < 1e-4f &&
                        glm::dot(p.ns, q.ns) > 0.999f &&
                        glm::dot(glm::normalize(p.dpdu), glm::normalize(q.dpdu)) > 0.999f;
      alike += same ? 1 : 0;
    }
    // Grazing rays may hit or miss.
    EXPECT_GT(both, 1000);
    EXPECT_LT(one, both / 100);
    EXPECT_GT(alike, both * 98 / 100);
  }
}

TEST(Strands, an_uneven_scale_flattens_strands) {
  for (const StrandShape shape : kShapes) {
    SceneDescription d = empty_scene();
    const Mat4 matrix(Vec4(0.25f, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(0, 0, 0, 1));
    add_object(d, straight(shape), add_diffuse(d, Color(0.5f)), matrix);
    const auto scene = build(d);
    EXPECT_TRUE(meets(*scene, {0.02f, -5, 1.3f}, {0, 1, 0})) << int(shape);
    EXPECT_FALSE(meets(*scene, {0.03f, -5, 1.3f}, {0, 1, 0})) << int(shape);
    EXPECT_TRUE(meets(*scene, {-5, 0.09f, 1.3f}, {1, 0, 0})) << int(shape);
    EXPECT_FALSE(meets(*scene, {-5, 0.11f, 1.3f}, {1, 0, 0})) << int(shape);
  }
}

TEST(Strands, rays_that_leave_a_strand_do_not_hit_it_at_their_origin) {
  // A single straight strand is convex. No ray that leaves a tube outwards or a ribbon in any direction hits it again.
  for (const StrandShape shape : kShapes) {
    for (const float scale : {1e-3f, 1.0f, 100.0f}) {
      SceneDescription d = empty_scene();
      add_object(d, straight(shape), add_diffuse(d, Color(0.5f)),
                 Mat4(Vec4(scale, 0, 0, 0), Vec4(0, scale, 0, 0), Vec4(0, 0, scale, 0), Vec4(0, 0, 0, 1)));
      const auto scene = build(d);
      Pcg32 rng(3);
      int met_again = 0, met_first = 0;
      for (int i = 0; i < 20000; ++i) {
        const Vec3 from = scale * (Vec3(0, 0, 2) + 5.0f * warp::square_to_sphere({rng.next_float(), rng.next_float()}));
        const Vec3 to = scale *
                        Vec3(0.2f * rng.next_float() - 0.1f, 0.2f * rng.next_float() - 0.1f, 4.0f * rng.next_float());
        Ray ray;
        ray.origin = from;
        ray.direction = glm::normalize(to - from);
        const Hit hit = scene->intersect(ray, kRayCamera);
        if (!hit.found()) continue;
        ShadingPoint point;
        scene->shading_point(ray, hit, point);
        Vec3 away = warp::square_to_sphere({rng.next_float(), rng.next_float()});
        if (shape != StrandShape::Ribbon && glm::dot(away, point.ng) < 0.0f) away = -away;
        if (glm::length(glm::cross(glm::normalize(point.dpdu), away)) < 0.05f) continue;  // along the strand
        ++met_first;
        met_again += scene->is_blocked(scene->spawn_ray(point, away)) ? 1 : 0;
      }
      EXPECT_GT(met_first, 5000);
      EXPECT_LE(met_again, met_first / 2000) << int(shape) << " " << scale;
    }
  }
}

TEST(Strands, white_strands_are_invisible_in_a_white_world) {
  // Light arrives at a single strand from all directions, so that its radiance is that of the world.
  for (const StrandShape shape : kShapes) {
    SceneDescription d = empty_scene();
    set_camera(d, Vec3(0, -4, 2), Vec3(0, 0, 2), 24, 0.1f);
    set_world(d, Color(1.0f));
    add_object(d, straight(shape), add_diffuse(d, Color(1.0f)));
    d.settings.samples = 64;
    Session session;
    session.start(std::move(d));
    ASSERT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.take_error(), "");
    for (const float value : session.snapshot("Combined")) ASSERT_NEAR(value, 1.0f, 1e-4f);
  }
}

TEST(Strands, hair_info_returns_the_strand_and_the_position_on_it) {
  MeshDescription mesh = hair({{{-1, 0, 0}, {-1, 0, 1}, {-1, 0, 4}}, {{1, 0, 0}, {1, 0, 2}}}, 0.2f, 0.1f);
  mesh.material_slots = {0, 1};
  mesh.attributes.push_back({"UVMap", Domain::Face, 2, {0.25f, 0.5f, 0.75f, 1.0f}});
  mesh.attributes.push_back({"heat", Domain::Vertex, 1, {0, 1, 2, 3, 5}});
  mesh.active_uv = "UVMap";
  SceneDescription d = empty_scene();
  const int first = add_diffuse(d, Color(0.5f)), second = add_diffuse(d, Color(0.2f));
  d.objects[size_t(add_object(d, mesh, first))].materials = {first, second};
  const auto scene = build(d);
  ShadingPoint point = met(*scene, {-1, -5, 1.75f}, {0, 1, 0.0001f});
  using nodes::HairOutput;
  const float u = point.barycentric.x;
  EXPECT_EQ(point.primitive, 1u);
  EXPECT_EQ(nodes::hair_info(point, HairOutput::IsStrand), 1.0f);
  EXPECT_NEAR(nodes::hair_info(point, HairOutput::Intercept), (1.0f + 3.0f * u) / 4.0f, 1e-6f);
  EXPECT_NEAR(nodes::hair_info(point, HairOutput::Length), 4.0f, 1e-6f);
  EXPECT_NEAR(nodes::hair_info(point, HairOutput::Thickness), 2.0f * (0.15f + u * (0.1f - 0.15f)), 1e-6f);
  EXPECT_LT(glm::length(nodes::hair_tangent_normal(point) - Vec3(0, -1, 0)), 1e-3f);
  EXPECT_EQ(nodes::active_uv(point), Vec3(0.25f, 0.5f, 0.0f));
  EXPECT_NEAR(nodes::attribute(point, "heat", nullptr).x, 1.0f + u, 1e-6f);
  EXPECT_EQ(scene->material_index(point), first);
  const float random = nodes::hair_info(point, HairOutput::Random);
  point = met(*scene, {1, -5, 0.5f}, {0, 1, 0});
  EXPECT_EQ(scene->material_index(point), second);
  EXPECT_EQ(nodes::active_uv(point), Vec3(0.75f, 1.0f, 0.0f));
  EXPECT_NE(nodes::hair_info(point, HairOutput::Random), random);
  EXPECT_LT(glm::length(nodes::radial_tangent(point, nodes::Axis::Z) - Vec3(0, 0, 1)), 1e-5f);
  EXPECT_EQ(nodes::true_normal(point), point.wo);
}

TEST(Strands, hair_info_is_zero_on_triangles) {
  SceneDescription d = empty_scene();
  add_object(d, cube(), add_diffuse(d, Color(0.5f)));
  const auto scene = build(d);
  const ShadingPoint point = met(*scene, {0.1f, -5, 0.2f}, {0, 1, 0});
  using nodes::HairOutput;
  for (HairOutput output :
       {HairOutput::IsStrand, HairOutput::Intercept, HairOutput::Length, HairOutput::Thickness, HairOutput::Random})
    EXPECT_EQ(nodes::hair_info(point, output), 0.0f);
  EXPECT_EQ(nodes::hair_tangent_normal(point), Vec3(0.0f));
}

TEST(Strands, invalid_strands_are_omitted_and_reported_with_the_object_name) {
  const auto built = [](MeshDescription mesh, const char* text) {
    SceneDescription d = empty_scene();
    const int material = add_diffuse(d, Color(0.5f));
    add_object(d, plane(1.0f), material);
    add_object(d, std::move(mesh), material);
    Diagnostics diagnostics;
    const auto scene = build(d, &diagnostics);
    const Diagnostic* found = find(diagnostics, text);
    EXPECT_TRUE(found) << text;
    EXPECT_EQ(found ? found->object : "", "Hair");
    return scene->statistics().strands;
  };
  const MeshDescription good = hair({{{0, 0, 0}, {0, 0, 1}}, {{1, 0, 0}, {1, 0, 1}, {1, 1, 1}}}, 0.1f, 0.0f);
  MeshDescription bad = good;
  bad.strands[1] = 7;
  EXPECT_EQ(built(bad, "do not match the points"), 0u);
  bad = good;
  bad.strands = {1, 2};
  EXPECT_EQ(built(bad, "do not match the points"), 0u);
  bad = good;
  bad.radii.pop_back();
  EXPECT_EQ(built(bad, "do not match the points"), 0u);
  bad = good;
  bad.positions[0].x = kInfinity;
  EXPECT_EQ(built(bad, "1 strand with invalid points left out"), 1u);
  bad = good;
  bad.radii[0] = -1.0f;
  EXPECT_EQ(built(bad, "1 invalid radius or attribute value replaced"), 2u);
  bad = good;
  bad.material_slots = {0};
  EXPECT_EQ(built(bad, "Material slots do not match the strands"), 2u);
  bad = good;
  bad.attributes.push_back({"uv", Domain::Corner, 2, {}});
  EXPECT_EQ(built(bad, "Attribute 'uv' does not match"), 2u);
}

TEST(Strands, strands_without_length_are_omitted) {
  MeshDescription mesh = hair({{{0, 0, 0}, {0, 0, 0}}, {{1, 0, 0}, {1, 0, 1}}, {{2, 0, 0}, {2, 0, 0}, {2, 0, 1}}}, 0.1f,
                              0.1f);
  mesh.attributes.push_back({"number", Domain::Face, 1, {1, 2, 3}});
  mesh.attributes.push_back({"height", Domain::Vertex, 1, {0, 0, 0, 1, 0, 0, 1}});
  mesh.strands.push_back(uint32_t(mesh.positions.size()));
  mesh.positions.push_back(Vec3(3));
  mesh.radii.push_back(0.1f);
  mesh.attributes[0].values.push_back(4.0f);
  mesh.attributes[1].values.push_back(0.0f);
  SceneDescription d = empty_scene();
  add_object(d, mesh, add_diffuse(d, Color(0.5f)));
  const auto scene = build(d);
  EXPECT_EQ(scene->statistics().strands, 2u);
  const ShadingPoint point = met(*scene, {2, -5, 0.5f}, {0, 1, 0});
  EXPECT_EQ(nodes::attribute(point, "number", nullptr).x, 3.0f);
  EXPECT_NEAR(nodes::attribute(point, "height", nullptr).x, point.barycentric.x, 1e-6f);
  EXPECT_NEAR(glm::length(point.ns), 1.0f, 1e-5f);
}

TEST(Strands, hair_without_any_length_is_reported_and_the_rest_renders) {
  SceneDescription d = empty_scene();
  add_object(d, hair({{{0, 0, 0}, {0, 0, 0}}, {{1, 0, 0}, {1, 0, 0}}}, 0.1f, 0.1f), add_diffuse(d, Color(0.5f)));
  add_object(d, plane(1.0f), add_diffuse(d, Color(0.5f)));
  Diagnostics diagnostics;
  const auto scene = build(d, &diagnostics);
  const Diagnostic* found = find(diagnostics, "No strand has a length");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->object, "Hair");
  EXPECT_TRUE(meets(*scene, {0, 0, 5}, {0, 0, -1}));
}

TEST(Strands, emissive_strands_are_not_lights_and_are_reported) {
  SceneDescription d = empty_scene();
  add_object(d, straight(StrandShape::Ribbon), add_diffuse(d, Color(0.5f), Color(2.0f)));
  Diagnostics diagnostics;
  const auto scene = build(d, &diagnostics);
  EXPECT_TRUE(scene->emission_without_lights());
  EXPECT_EQ(scene->lights().size(), 0u);
  ASSERT_TRUE(find(diagnostics, "only random rays find"));
}

}  // namespace ajar::test_strands
