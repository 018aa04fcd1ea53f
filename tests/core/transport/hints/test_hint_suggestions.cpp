#include "transport/hints/hint_suggestions.h"

#include <gtest/gtest.h>

#include "scene_fixtures.h"

namespace ajar::test_hint_suggestions {

using namespace fixtures;

namespace {

/// A closed room that is divided by a wall at x = 0 with a gap below z = `gap` - 1. The lamp is on the left, the camera
/// on the right.
SceneDescription two_rooms(float gap) {
  SceneDescription d;
  const int grey = add_diffuse(d, Color(0.6f));
  add_object(d, cube(true), grey);
  // Turns the square into the plane x = 0; its x axis becomes z.
  const float half_height = 0.5f * (2.0f - gap);
  const Mat4 upright(Vec4(0, 0, half_height, 0), Vec4(0, 1, 0, 0), Vec4(-1, 0, 0, 0),
                     Vec4(0, 0, 1.0f - half_height, 1));
  add_object(d, plane(1.0f), grey, upright);
  d.lights.push_back(point_light(Vec3(-0.8f, 0, 0.7f), 100.0f, 0.05f));
  set_camera(d, Vec3(0.9f, -0.9f, 0.3f), Vec3(0.4f, 0.8f, -0.2f), 16, 0.8f);
  return d;
}

}  // namespace

TEST(HintSuggestions, lead_through_the_gap_and_attach) {
  const float gap = 0.08f;
  const auto suggestions = suggest_hints(*build(two_rooms(gap)), 4, 8000, 3);
  ASSERT_FALSE(suggestions.empty());
  double share = 0.0;
  for (const HintSuggestion& suggestion : suggestions) {
    share += suggestion.share;
    ASSERT_GE(suggestion.points.size(), 3u);
    EXPECT_LT(glm::length(suggestion.points[0] - Vec3(-0.8f, 0, 0.7f)), 0.051f);
    // Where the curve crosses the wall, it passes the gap.
    for (size_t i = 0; i + 1 < suggestion.points.size(); ++i) {
      const Vec3 a = suggestion.points[i], b = suggestion.points[i + 1];
      if (a.x * b.x >= 0.0f) continue;
      EXPECT_LT(glm::mix(a, b, a.x / (a.x - b.x)).z, -1.0f + gap + 1e-3f);
    }
  }
  EXPECT_LE(share, 1.0 + 1e-9);
  EXPECT_GT(share, 0.05);
}

TEST(HintSuggestions, are_empty_where_path_tracing_is_efficient) {
  SceneDescription d = two_rooms(1.9f);
  EXPECT_TRUE(suggest_hints(*build(d), 4, 4000, 3).empty());
}

TEST(HintSuggestions, are_the_same_for_the_same_seed) {
  const auto scene = build(two_rooms(0.1f));
  const auto a = suggest_hints(*scene, 3, 3000, 5), b = suggest_hints(*scene, 3, 3000, 5);
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].points, b[i].points);
}

}  // namespace ajar::test_hint_suggestions
