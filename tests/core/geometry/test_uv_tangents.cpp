#include "geometry/uv_tangents.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ajar {
namespace {

const Vec3 kUp(0.0f, 0.0f, 1.0f);

void expect_near(Vec4 found, Vec4 expected, const char* what) {
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(found[i], expected[i], 1e-5f) << what << ' ' << i;
}

/// A square of two triangles in the plane of x and y, whose corners have the given coordinates.
std::vector<Vec4> square(const std::vector<Vec2>& uvs) {
  const std::vector<Vec3> positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const std::vector<UVec3> triangles = {{0, 1, 2}, {0, 2, 3}};
  return uv_tangents(positions, triangles, std::vector<Vec3>(6, kUp), uvs);
}

TEST(UvTangents, follow_u_and_know_mirrored_maps) {
  for (const Vec4& t : square({{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}})) expect_near(t, {1, 0, 0, 1}, "plain");
  for (const Vec4& t : square({{0, 0}, {0, 1}, {1, 1}, {0, 0}, {1, 1}, {1, 0}}))
    expect_near(t, {0, 1, 0, -1}, "transposed");
}

TEST(UvTangents, triangles_without_an_area_in_the_map_take_the_tangent_of_a_neighbour) {
  // The second triangle is a line in the map, connected along an edge of the first one.
  const auto found = square({{0, 0}, {0, 1}, {-1, 1}, {0, 0}, {-1, 1}, {-0.5f, 0.5f}});
  expect_near(found[3], found[0], "first corner");
  expect_near(found[4], found[2], "second corner");
  expect_near(found[5], {1, 0, 0, -1}, "no group reaches the third corner");
  for (const Vec4& t : square(std::vector<Vec2>(6, Vec2(0.0f)))) expect_near(t, {1, 0, 0, -1}, "no coordinates");
}

TEST(UvTangents, are_smooth_where_the_surface_and_the_map_are) {
  // Two squares that meet at an angle along y, with the mean of their normals there; u turns around the edge.
  const float s = std::sqrt(0.5f);
  const std::vector<Vec3> positions = {{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 1, 0}, {0, 0, -1}, {0, 1, -1}};
  const std::vector<UVec3> triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}};
  const Vec3 left(0, 0, 1), middle(s, 0, s), right(1, 0, 0);
  const std::vector<Vec3> normals = {left,   middle, middle, left,   middle, left,
                                     middle, right,  right,  middle, right,  middle};
  const auto at = [](int vertex) {
    constexpr Vec2 kUv[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0}, {2, 1}};
    return kUv[vertex];
  };
  std::vector<Vec2> uvs;
  for (const UVec3& t : triangles)
    for (int k = 0; k < 3; ++k) uvs.push_back(at(int(t[k])));
  const auto found = uv_tangents(positions, triangles, normals, uvs);
  expect_near(found[0], {1, 0, 0, 1}, "left");
  for (const int corner : {1, 2, 4, 6, 9, 11}) expect_near(found[size_t(corner)], {s, 0, -s, 1}, "middle");
  expect_near(found[7], {0, 0, -1, 1}, "right");

  // With another map on the right, there is a seam.
  for (size_t corner = 6; corner < 12; ++corner) uvs[corner] = Vec2(uvs[corner].y + 5.0f, -uvs[corner].x);
  const auto cut = uv_tangents(positions, triangles, normals, uvs);
  expect_near(cut[1], {s, 0, -s, 1}, "left of the seam");
  expect_near(cut[6], {0, 1, 0, 1}, "right of the seam");
}

TEST(UvTangents, of_a_mesh_without_a_map_run_around_the_vertical_axis) {
  const std::vector<Vec3> positions = {{1, -0.1f, -0.1f}, {1, 0.1f, -0.1f}, {1, 0, 0.1f}};
  const auto found = uv_tangents(positions, std::vector<UVec3>{{0, 1, 2}}, std::vector<Vec3>(3, {1, 0, 0}), {});
  EXPECT_GT(std::abs(found[0].y), 0.95f);
  EXPECT_TRUE(uv_tangents({}, {}, {}, {}).empty());
}

}  // namespace
}  // namespace ajar
