#include "transport/photons/point_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "math/random.h"
#include "math/warps.h"

namespace ajar::test_point_tree {

namespace {

std::vector<SurfacePoint> random_points(size_t count) {
  Pcg32 rng(7);
  std::vector<SurfacePoint> points(count);
  for (SurfacePoint& p : points) {
    const float x = rng.next_float(), y = rng.next_float(), z = 0.1f * rng.next_float();
    const float u = rng.next_float();
    p = {Vec3(x, y, z), pack_direction(warp::square_to_sphere({u, rng.next_float()}))};
  }
  return points;
}

struct Found {
  float distance2;
  uint32_t original;
};
std::vector<Found> brute_force(const std::vector<SurfacePoint>& points, Vec3 p, Vec3 n, float radius) {
  std::vector<Found> found;
  for (uint32_t i = 0; i < points.size(); ++i) {
    const Vec3 offset = points[i].position - p;
    const float outside = std::max(0.0f, std::abs(glm::dot(offset, n)) - radius / (2.0f * PointTree::kFlatness));
    const float d2 = length_squared(offset) + (sqr(PointTree::kSteepness) - 1.0f) * sqr(outside);
    if (d2 < radius * radius && glm::dot(unpack_direction(points[i].packed_normal), n) >= PointTree::kMinNormalCosine)
      found.push_back({d2, i});
  }
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.distance2 < b.distance2; });
  return found;
}

}  // namespace

/// The direction after packing and unpacking, with this number of steps on each side of 0.
template <class There, class Back>
void expect_one_rounding_step(float steps, There pack, Back unpack) {
  // Half a step in both coordinates moves a point of the octahedron by sqrt(6)/2 steps, at a distance of at least
  // 1/sqrt(3) from the centre.
  const float bound = 0.5f / steps * std::sqrt(6.0f) * std::sqrt(3.0f) + 1e-6f;
  Pcg32 rng(1);
  for (int i = 0; i < 100000; ++i) {
    const float u = rng.next_float();
    const Vec3 d = warp::square_to_sphere({u, rng.next_float()});
    ASSERT_LT(glm::length(unpack(pack(d)) - d), bound);
  }
  for (const Vec3 axis : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)})
    EXPECT_EQ(unpack(pack(axis)), axis);
}

TEST(PointTree, packed_directions_have_the_error_of_one_rounding_step) {
  expect_one_rounding_step(8191.0f, pack_direction, unpack_direction);
  expect_one_rounding_step(4095.0f, pack_direction_short, unpack_direction_short);
  expect_one_rounding_step(
      4095.0f, [](Vec3 d) { return pack_direction_short(d) | 0xfc000000u; }, unpack_direction_short);
}

// A ball around a point of a sphere contains the area pi r^2 of it.
TEST(PointTree, a_lookup_on_a_sphere_covers_the_area_of_a_disc) {
  constexpr int kLookups = 2000;
  constexpr float kRadius = 0.2f;
  Pcg32 rng(11);
  const auto on_sphere = [&] {
    const float u = rng.next_float();
    return warp::square_to_sphere({u, rng.next_float()});
  };
  /// Mean estimate of the density of the points, over the density.
  const auto mean_density = [&](int count, int neighbours) {
    std::vector<SurfacePoint> points(static_cast<size_t>(count));
    for (SurfacePoint& p : points) {
      p.position = on_sphere();
      p.packed_normal = pack_direction(p.position);
    }
    PointTree tree;
    std::vector<uint32_t> order;
    tree.build(std::move(points), order);
    PointTree::Neighbours found;
    double sum = 0.0;
    for (int i = 0; i < kLookups; ++i) {
      const Vec3 at = on_sphere();
      tree.nearest(at, at, neighbours, kRadius, found);
      sum += double(found.count) / double(found.radius2);
    }
    return sum / kLookups * 4.0 / count;
  };
  EXPECT_NEAR(mean_density(100000, 40), 1.0, 0.02) << "a few of the thousand points within the radius";
  EXPECT_NEAR(mean_density(2000, PointTree::kMaxNeighbours), 1.0, 0.03) << "all points within the radius";
}

TEST(PointTree, agrees_with_a_search_over_all_points) {
  const auto points = random_points(5000);
  PointTree tree;
  std::vector<uint32_t> order;
  tree.build(points, order);
  Pcg32 rng(3);
  PointTree::Neighbours found;
  for (int query = 0; query < 400; ++query) {
    const float x = rng.next_float(), y = rng.next_float(), u = rng.next_float();
    const Vec3 p(x, y, 0.05f), n = warp::square_to_sphere({u, rng.next_float()});
    const float radius = 0.02f + 0.5f * rng.next_float();
    const auto expected = brute_force(points, p, n, radius);
    const int k = 1 + int(rng.next_float() * 80.0f);
    tree.nearest(p, n, k, radius, found);
    if (expected.size() >= size_t(k)) {
      // The k-th point is at the edge of the disc.
      EXPECT_EQ(found.count, k - 1);
      EXPECT_NEAR(found.radius2, expected[size_t(k) - 1].distance2, 2e-6f * found.radius2) << "rounding of heights";
    } else {
      EXPECT_EQ(found.count, int(expected.size()));
      EXPECT_EQ(found.radius2, radius * radius);
    }
    std::vector<uint32_t> a, b;
    for (int i = 0; i < found.count; ++i) a.push_back(order[found.index[i]]), b.push_back(expected[size_t(i)].original);
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    EXPECT_EQ(a, b);
    const int nearest = tree.nearest(p, n, radius);
    EXPECT_EQ(nearest < 0, expected.empty());
    if (nearest >= 0) {
      EXPECT_EQ(order[uint32_t(nearest)], expected[0].original);
    }
  }
}

TEST(PointTree, any_number_of_points_can_be_built_and_searched) {
  PointTree::Neighbours found;
  for (size_t count : {0, 1, 7, 8, 9, 10, 17, 1000, 20000}) {
    const auto points = random_points(count);
    PointTree tree;
    std::vector<uint32_t> order;
    tree.build(points, order);
    ASSERT_EQ(tree.size(), count);
    for (uint32_t i = 0; i < count; ++i) EXPECT_EQ(tree[i].position, points[order[i]].position);
    tree.nearest(Vec3(0.5f), Vec3(0, 0, 1), 60, 1.0f, found);
    EXPECT_LE(found.count, int(count));
  }
}

TEST(PointTree, points_on_the_other_side_of_a_thin_wall_are_not_found) {
  std::vector<SurfacePoint> points;
  for (int i = 0; i < 100; ++i)
    points.push_back({Vec3(0.001f * float(i % 10), 0.001f * float(i / 10), 0.012f), pack_direction({0, 0, -1})});
  PointTree tree;
  std::vector<uint32_t> order;
  tree.build(points, order);
  EXPECT_EQ(tree.nearest(Vec3(0.0f), Vec3(0, 0, 1), 1.0f), -1);
  EXPECT_NE(tree.nearest(Vec3(0.0f), Vec3(0, 0, -1), 1.0f), -1);
}

TEST(PointTree, points_on_the_other_face_of_a_thin_pane_can_be_left_out) {
  std::vector<SurfacePoint> points;
  for (int i = 0; i < 100; ++i) {
    const uint32_t side = i % 4 == 0 ? SurfacePoint::kFront : i % 4 == 1 ? SurfacePoint::kBack : 0u;
    points.push_back({Vec3(0.001f * float(i % 10), 0.001f * float(i / 10), 0.0f), pack_direction({0, 0, 1}) | side});
  }
  PointTree tree;
  std::vector<uint32_t> order;
  tree.build(points, order);
  PointTree::Neighbours found;
  const auto count = [&](uint32_t not_side) {
    tree.nearest(Vec3(0.0f), Vec3(0, 0, 1), PointTree::kMaxNeighbours, 1.0f, found, not_side);
    return found.count;
  };
  EXPECT_EQ(count(0), 100);
  EXPECT_EQ(count(SurfacePoint::kBack), 75);
  EXPECT_EQ(count(SurfacePoint::kSides), 50);
  EXPECT_EQ(other_side(points[0]), SurfacePoint::kBack);
  EXPECT_EQ(other_side(points[2]), 0u);
}

TEST(PointTree, coincident_points_can_be_built_and_searched) {
  std::vector<SurfacePoint> points(10000, SurfacePoint{Vec3(1.0f), pack_direction({0, 0, 1})});
  PointTree tree;
  std::vector<uint32_t> order;
  tree.build(points, order);
  PointTree::Neighbours found;
  tree.nearest(Vec3(1.0f), Vec3(0, 0, 1), 60, 1.0f, found);
  EXPECT_EQ(found.count, 59);
}

}  // namespace ajar::test_point_tree
