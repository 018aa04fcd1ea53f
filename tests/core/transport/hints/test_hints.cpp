#include "transport/hints/hints.h"

#include <gtest/gtest.h>

#include <limits>

#include "math/warps.h"

#include "scene_fixtures.h"
#include "statistical.h"

namespace ajar::test_hints {

using namespace fixtures;

namespace {

int add_delta(SceneDescription& d, const std::string& type) {
  MaterialDescription material;
  material.name = type;
  material.graph.nodes.push_back(closure_node(type, Color(1.0f)));
  material.graph.nodes[0].inputs.push_back({"Roughness", {}, Vec4(0.0f)});
  material.graph.nodes[0].inputs.push_back({"IOR", {}, Vec4(1.5f)});
  material.graph.surface = {0, "BSDF"};
  d.materials.push_back(material);
  return int(d.materials.size()) - 1;
}

/// A floor, a wall at x = 0 up to z = 1, and a lamp to the left of it.
SceneDescription two_sides() {
  SceneDescription d;
  add_object(d, plane(5.0f), add_diffuse(d, Color(0.5f)));
  d.objects.back().name = "Floor";
  const Mat4 upright(Vec4(0, 0, 0.2f, 0), Vec4(0, 1, 0, 0), Vec4(-1, 0, 0, 0), Vec4(0, 0, 0, 1));
  add_object(d, plane(5.0f), 0, upright);  // z from -1 to 1
  d.objects.back().name = "Wall";
  d.lights.push_back(point_light(Vec3(-1, 0, 0.5f), 10.0f));
  d.lights.push_back(point_light(Vec3(3, 3, 3), 10.0f));
  set_camera(d, Vec3(2, -2, 2), Vec3(1, 0, 0), 8);
  return d;
}

HintDescription hint(const std::string& name, std::vector<Vec3> points) {
  HintDescription h;
  h.name = name;
  h.points = std::move(points);
  return h;
}

}  // namespace

TEST(Hints, do_not_attach_to_a_light_that_moves) {
  for (const bool moves : {false, true}) {
    SceneDescription d = two_sides();
    d.lights.clear();
    const Mat4 first = moved(Vec3(-1, 0, 0.5f), 0.1f), last = moved(Vec3(-1, 0.5f, 0.5f), 0.1f);
    add_object(d, sphere(6), add_diffuse(d, Color(0.0f), Color(5.0f)), first);
    if (moves) {
      d.instances.back().first_motion_key = 0;
      d.instances.back().motion_key_count = 2;
      d.motion_keys = {rows(first), rows(last)};
    }
    d.hints.push_back(hint("Through", {{-0.9f, 0, 0.5f}, {-0.5f, 0, 0.2f}, {0, 1, 0.5f}}));
    std::vector<HintReport> reports;
    Hints::attach(*build(d), reports);
    ASSERT_EQ(reports.size(), 1u);
    EXPECT_EQ(reports[0].attached, !moves) << reports[0].reason;
    EXPECT_EQ(reports[0].reason == "the light near its first point moves", moves) << reports[0].reason;
  }
}

TEST(Hints, attach_to_the_nearest_light_and_to_the_surfaces_at_their_points) {
  SceneDescription d = two_sides();
  d.hints.push_back(hint("Bounce", {{-0.9f, 0, 0.5f}, {-1.5f, 0.2f, 0.01f}, {0, 1, 0.5f}}));
  std::vector<HintReport> reports;
  const Hints hints = Hints::attach(*build(d), reports);
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_TRUE(reports[0].attached) << reports[0].reason;
  ASSERT_EQ(hints.size(), 1u);
  EXPECT_EQ(hints[0].light, 0u);
  ASSERT_EQ(hints[0].vertices.size(), 3u);
  EXPECT_EQ(hints[0].vertices[0].position, Vec3(-1, 0, 0.5f));
  EXPECT_NEAR(hints[0].vertices[1].position.z, 0.0f, 1e-5f);
  EXPECT_LT(glm::length(hints[0].vertices[2].position - Vec3(0, 1, 0.5f)), 0.01f);
}

TEST(Hints, malformed_hints_are_reported_by_name_and_ignored) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  SceneDescription d = two_sides();
  d.hints = {hint("One point", {{-1, 0, 0.5f}}),
             hint("Space", {{-1, 0, 0.5f}, {-1, 0, 50.0f}}),
             hint("Wall between", {{-1, 0, 0.5f}, {2, 0, 0.0f}}),
             hint("Not a number", {{-1, 0, 0.5f}, {nan, 0, 0}}),
             hint("Endless", std::vector<Vec3>(10000, Vec3(-1, 0, 0))),
             hint("Nowhere near a light", {{-1, 50, 0}, {-1, 50.5f, 0}}),
             hint("Same point", {{-1, 0, 0.5f}, {-1, 0, 0.5f}}),
             hint("Good", {{-1, 0, 0.5f}, {-2, 0, 0}})};
  d.hints.push_back(hint("Switched off", {{-1, 0, 0.5f}, {-2, 0, 0}}));
  d.hints.back().enabled = false;
  std::vector<HintReport> reports;
  const Hints hints = Hints::attach(*build(d), reports);
  ASSERT_EQ(hints.size(), 1u);
  EXPECT_EQ(hints[0].name, "Good");
  ASSERT_EQ(reports.size(), 8u);
  for (const HintReport& report : reports) {
    EXPECT_EQ(report.attached, report.name == "Good") << report.name;
    EXPECT_EQ(report.reason.empty(), report.attached) << report.name;
  }
  EXPECT_NE(reports[2].reason.find("'Wall' blocks the segment"), std::string::npos) << reports[2].reason;
  EXPECT_EQ(reports[2].segments.back(), HintSegmentState::Failed);
}

TEST(Hints, follow_specular_surfaces_with_or_without_control_points_there) {
  SceneDescription d;
  add_object(d, plane(5.0f), add_diffuse(d, Color(0.5f)));
  add_object(d, sphere(48), add_delta(d, "ShaderNodeBsdfGlass"),
             Mat4(Vec4(0.5f, 0, 0, 0), Vec4(0, 0.5f, 0, 0), Vec4(0, 0, 0.5f, 0), Vec4(0, 0, 1, 1)));
  d.lights.push_back(
      point_light(Vec3(0.1f, 0.05f, 3), 10.0f));  // not at a pole of the mesh, where the triangles are narrow
  set_camera(d, Vec3(2, -2, 2), Vec3(1, 0, 0), 8);
  d.hints = {hint("All", {{0.1f, 0.05f, 3}, {0.025f, 0.01f, 1.5f}, {0, 0, 0.5f}, {0, 0, 0}}),
             hint("Ends", {{0.1f, 0.05f, 3}, {0, 0, 0}})};
  std::vector<HintReport> reports;
  const Hints hints = Hints::attach(*build(d), reports);
  ASSERT_EQ(hints.size(), 2u) << reports[0].reason << " / " << reports[1].reason;
  for (size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(hints[i].vertices.size(), 4u) << i;
    EXPECT_TRUE(hints[i].vertices[1].specular && hints[i].vertices[1].transmitted);
    EXPECT_TRUE(hints[i].vertices[2].specular && hints[i].vertices[2].transmitted);
    EXPECT_FALSE(hints[i].vertices[3].specular);
    EXPECT_LT(glm::length(hints[i].vertices[3].position), 0.2f);
  }
  EXPECT_EQ(reports[1].segments,
            (std::vector{HintSegmentState::Attached, HintSegmentState::Bounced, HintSegmentState::Bounced}));
}

TEST(Hints, directions_are_sampled_with_their_density) {
  Hints::Hint h;
  h.vertices = {{Vec3(0.0f)}, {Vec3(1, 2, 3)}};
  for (const float spread : {0.002f, 0.0872665f, 1.0f}) {
    h.one_minus_cos = {warp::one_minus_cos(spread)};
    const Vec3 from(0.5f, 0.1f, -0.2f);
    const auto map = [&](Vec2 u) { return std::optional(Hints::sample_direction(h, 0, from, u)); };
    const auto pdf = [&](Vec3 w) { return double(Hints::pdf_solid_angle(h, 0, from, w)); };
    statistical::DensityTest test;
    test.level = {0.01, 3};
    test.outside_fraction = 2e-3;  // rounding at the edge of the cone
    EXPECT_TRUE(statistical::chi_square_agrees(statistical::from_square(map), pdf, test)) << spread;
  }
}

TEST(Hints, the_density_of_a_path_is_zero_if_the_hint_cannot_propose_it) {
  SceneDescription d = two_sides();
  d.hints = {hint("A", {{-1, 0, 0.5f}, {-2, 0, 0}}), hint("B", {{-1, 0, 0.5f}, {-2, 0.02f, 0}}),
             hint("C", {{-1, 0, 0.5f}, {-1, 2, 0}})};
  d.hints[1].weight = 3.0f;
  d.hints[1].spread = 0.2f;
  std::vector<HintReport> reports;
  const Hints hints = Hints::attach(*build(d), reports);
  ASSERT_EQ(hints.size(), 3u);
  const Hints::PathPoint near_both[] = {{Vec3(-1, 0, 0.5f), false}, {Vec3(-2, 0.01f, 0), false}};
  const double a = 0.5 / M_PI / double(warp::one_minus_cos(d.hints[0].spread)),
               b = 0.5 / M_PI / double(warp::one_minus_cos(0.2f));
  const double probability = hints[0].light_probabilities.back();  // with which walks from lights choose this lamp
  EXPECT_GT(probability, 0.1);
  EXPECT_LT(probability, 0.9);
  EXPECT_NEAR(Hints::pdf(hints[0], 0, LightType::Point, Vec3(0, 0, 1), near_both) * probability, a, 1e-4 * a);
  EXPECT_NEAR(Hints::pdf(hints[1], 0, LightType::Point, Vec3(0, 0, 1), near_both) * probability, b, 1e-4 * b);
  EXPECT_EQ(Hints::pdf(hints[2], 0, LightType::Point, Vec3(0, 0, 1), near_both), 0.0);
  EXPECT_EQ(Hints::pdf(hints[0], 1, LightType::Point, Vec3(0, 0, 1), near_both), 0.0);
  EXPECT_NEAR(hints[1].share, 0.6, 1e-6);
  const Hints::PathPoint elsewhere[] = {{Vec3(-1, 0, 0.5f), false}, {Vec3(-3, -2, 0), false}};
  EXPECT_EQ(Hints::pdf(hints[0], 0, LightType::Point, Vec3(0, 0, 1), elsewhere), 0.0);
  const Hints::PathPoint longer[] = {near_both[0], near_both[1], {Vec3(-2, 0.01f, 1), false}};
  EXPECT_EQ(Hints::pdf(hints[0], 0, LightType::Point, Vec3(0, 0, 1), longer), 0.0);
  const Hints::PathPoint specular[] = {near_both[0], {near_both[1].position, true}};
  EXPECT_EQ(Hints::pdf(hints[0], 0, LightType::Point, Vec3(0, 0, 1), specular), 0.0);
  // On a sphere, only the half that faces the hint is proposed.
  EXPECT_NEAR(Hints::pdf(hints[0], 0, LightType::Sphere, hints[0].axis, near_both) * probability, 2.0 * a, 2e-4 * a);
  EXPECT_EQ(Hints::pdf(hints[0], 0, LightType::Sphere, -hints[0].axis, near_both), 0.0);
  EXPECT_EQ(hints.choose(0.1f), 0u);
  EXPECT_EQ(hints.choose(0.5f), 1u);
  EXPECT_EQ(hints.choose(0.99f), 2u);
}

}  // namespace ajar::test_hints
