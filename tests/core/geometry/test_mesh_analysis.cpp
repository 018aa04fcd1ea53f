#include "geometry/mesh_analysis.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ajar::test_mesh_analysis {

namespace {

// Six squares of four triangles each. The edges are in the order of Blender 3.4.1; the expected values are those of its
// Cycles.
TEST(MeshAnalysis, islands_have_the_random_numbers_of_cycles) {
  const std::vector<MeshEdge> edges = {{0, 1},   {1, 2},   {2, 3},   {0, 4},   {5, 6},   {6, 7},   {7, 8},   {5, 9},
                                       {10, 11}, {11, 12}, {12, 13}, {10, 14}, {0, 3},   {16, 17}, {10, 13}, {15, 19},
                                       {20, 23}, {20, 21}, {21, 22}, {22, 23}, {20, 24}, {25, 26}, {26, 27}, {27, 28},
                                       {1, 4},   {11, 14}, {21, 24}, {2, 4},   {12, 14}, {22, 24}, {3, 4},   {13, 14},
                                       {23, 24}, {15, 16}, {5, 8},   {15, 18}, {25, 28}, {25, 29}, {6, 9},   {16, 19},
                                       {26, 29}, {17, 18}, {7, 9},   {17, 19}, {27, 29}, {8, 9},   {18, 19}, {28, 29}};
  const float expected[] = {0.58242583f, 0.50820202f, 0.86176836f, 0.40074369f, 0.61932057f, 0.74848819f};
  const std::vector<float> random = random_per_island(30, edges);
  ASSERT_EQ(random.size(), 30u);
  for (size_t v = 0; v < 30; ++v) EXPECT_FLOAT_EQ(random[v], expected[v / 5]) << v;
}

TEST(MeshAnalysis, edges_with_invalid_indices_are_ignored) {
  const std::vector<MeshEdge> edges = {{0, 7}, {9, 1}, {0, 0}};
  const std::vector<float> random = random_per_island(2, edges);
  EXPECT_NE(random[0], random[1]);
  const std::vector<Vec3> two = {Vec3(0), Vec3(1)};
  EXPECT_EQ(pointiness(two, two, edges), (std::vector<float>{0.0f, 0.0f}));
  EXPECT_TRUE(random_per_island(0, {}).empty());
  EXPECT_TRUE(pointiness({}, {}, {}).empty());
}

/// A cube whose corner numbers have one bit for each axis. With `split`, every face has four vertices of its own.
struct Cube {
  std::vector<Vec3> positions, normals;
  std::vector<MeshEdge> edges;
  explicit Cube(bool split, float side = 1.0f) {
    const auto corner = [](int i) { return Vec3(i & 1, i >> 1 & 1, i >> 2 & 1) * 2.0f - 1.0f; };
    if (!split) {
      for (int i = 0; i < 8; ++i) positions.push_back(corner(i)), normals.push_back(glm::normalize(corner(i)));
      for (uint32_t i = 0; i < 8; ++i)
        for (uint32_t axis : {1u, 2u, 4u})
          if (!(i & axis)) edges.push_back({i, i | axis});
    } else {
      for (int axis = 0; axis < 3; ++axis)
        for (int up = 0; up < 2; ++up) {
          const uint32_t first = uint32_t(positions.size());
          for (int k = 0; k < 4; ++k) {
            const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
            positions.push_back(corner((up << axis) | (k == 1 || k == 2 ? u : 0) | (k >= 2 ? v : 0)));
            Vec3 normal(0.0f);
            normal[axis] = up ? 1.0f : -1.0f;
            normals.push_back(normal);
            edges.push_back({first + uint32_t(k), first + uint32_t((k + 1) % 4)});
          }
        }
    }
    for (Vec3& p : positions) p *= side;
  }
};

TEST(MeshAnalysis, corners_of_a_cube_point_out_however_it_is_split) {
  // The mean of the three edges is -1/3 of the signs of the corner: its cosine to the normal is -1 / sqrt(3).
  const float expected = float(std::acos(-1.0 / std::sqrt(3.0)) / M_PI);
  for (const bool split : {false, true}) {
    const Cube cube(split);
    for (const float value : pointiness(cube.positions, cube.normals, cube.edges)) EXPECT_NEAR(value, expected, 1e-6f);
  }
  // With inverted normals, the corners are concave.
  Cube hollow(true);
  for (Vec3& n : hollow.normals) n = -n;
  for (const float value : pointiness(hollow.positions, hollow.normals, hollow.edges))
    EXPECT_NEAR(value, 1.0f - expected, 1e-6f);
}

TEST(MeshAnalysis, a_bump_in_a_plane_is_shared_with_its_neighbours) {
  // A cross of five vertices, the middle raised by 1. From the middle, the edges fall at 45 degrees; from the tips,
  // they rise.
  const std::vector<Vec3> positions = {{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}},
                          normals(5, Vec3(0, 0, 1));
  const std::vector<MeshEdge> edges = {{0, 1}, {0, 2}, {3, 0}, {0, 4}, {4, 0}};  // the last edge is there twice
  const std::vector<float> found = pointiness(positions, normals, edges);
  const float middle = 0.75f, tip = 0.25f;  // before averaging: 135 and 45 degrees
  // The mean of the edges of the middle is shorter than one, but its angle is that of the cosine -1 / sqrt(2).
  EXPECT_NEAR(found[0], (middle + 4.0f * tip) / 5.0f, 1e-6f);
  for (int i = 1; i < 5; ++i) EXPECT_NEAR(found[size_t(i)], (tip + middle) / 2.0f, 1e-6f);
}

TEST(MeshAnalysis, walls_with_equal_coordinate_sums_do_not_compare_all_pairs) {
  // A wall perpendicular to (1, 1, 1): all sums of coordinates are equal, so that sorting by them separates no
  // vertices. There are 2e10 pairs.
  constexpr int kSide = 450;
  const Vec3 u = glm::normalize(Vec3(1, -1, 0)), v = glm::normalize(Vec3(1, 1, -2));
  std::vector<Vec3> positions, normals;
  for (int i = 0; i < kSide * kSide; ++i)
    positions.push_back(0.01f * (float(i % kSide) * u + float(i / kSide) * v)), normals.push_back(Vec3(0.57735f));
  std::vector<MeshEdge> edges;
  for (uint32_t i = 0; i + 1 < positions.size(); ++i) edges.push_back({i, i + 1});
  const std::vector<float> found = pointiness(positions, normals, edges);
  EXPECT_NEAR(found[kSide * 10 + 20], 0.5f, 1e-3f);
}

}  // namespace

}  // namespace ajar::test_mesh_analysis
