#include <gtest/gtest.h>

#include <random>

#include "description/diagnostics.h"
#include "shading/functions/texture_functions.h"

namespace ajar::test_box_projection {

namespace {

float largest_difference(Vec3 a, Vec3 b) { return max_component(glm::abs(a - b)); }

}  // namespace

TEST(BoxProjection, weights_are_those_of_cycles) {
  const struct {
    Vec3 normal;
    float blend;
    Vec3 weights;
  } cases[] = {{{0.9f, 0.3f, -0.2f}, 0.25f, {1.0f, 0.0f, 0.0f}},
               {{-0.5f, 0.6f, 0.1f}, 0.25f, {0.3181819f, 0.6818181f, 0.0f}},
               {{0.1f, -0.55f, 0.5f}, 0.25f, {0.0f, 0.5952382f, 0.4047618f}},
               {{0.6f, 0.2f, 0.55f}, 0.25f, {0.5869565f, 0.0f, 0.4130435f}},
               {{0.5f, -0.6f, -0.45f}, 0.25f, {0.2741936f, 0.6290324f, 0.0967741f}},
               {{0.9f, 0.3f, -0.2f}, 0.8f, {0.7589285f, 0.1696428f, 0.07142854f}},
               {{-0.5f, 0.6f, 0.1f}, 0.8f, {0.4431818f, 0.5568181f, 0.0f}},
               {{0.5f, -0.6f, -0.45f}, 0.8f, {0.3185484f, 0.4072581f, 0.2741935f}},
               {{0.1f, 0.7f, 0.6f}, 0.0f, {0.0f, 1.0f, 0.0f}},
               {{0.0f, 0.5f, 0.5f}, 0.0f, {1.0f, 0.0f, 0.0f}},  // equal weights: the first axis is used
               {{0.0f, 0.0f, 0.0f}, 0.5f, {1.0f, 0.0f, 0.0f}}};
  for (const auto& c : cases) {
    const Vec3 w = nodes::box_weights(c.normal, c.blend);
    EXPECT_LT(largest_difference(w, c.weights), 2e-6f)
        << c.normal.x << ' ' << c.normal.y << ' ' << c.normal.z << ", blend " << c.blend;
  }
}

TEST(BoxProjection, weights_are_continuous_and_symmetric_in_the_axes) {
  std::mt19937 engine(3);
  std::normal_distribution<float> normal;
  for (const float blend : {0.2f, 0.6f, 1.0f})
    for (int i = 0; i < 20000; ++i) {
      const Vec3 n = glm::normalize(Vec3(normal(engine), normal(engine), normal(engine)));
      const Vec3 near = glm::normalize(n +
                                       1e-3f * glm::normalize(Vec3(normal(engine), normal(engine), normal(engine))));
      const Vec3 w = nodes::box_weights(n, blend), turned = nodes::box_weights({n.y, n.z, n.x}, blend);
      EXPECT_LT(largest_difference(w, nodes::box_weights(near, blend)), 3e-3f / blend);
      EXPECT_LT(largest_difference(Vec3(w.y, w.z, w.x), turned), 1e-5f);
      EXPECT_NEAR(w.x + w.y + w.z, 1.0f, 1e-5f);
    }
}

TEST(BoxProjection, each_side_shows_the_image_as_in_blender) {
  // Four columns and four rows. Red is the number of the column, green that of the row.
  ImageDescription description;
  description.name = "Grid";
  description.width = description.height = 4;
  description.color_space = "Non-Color";
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      description.pixels.insert(description.pixels.end(), {float(column), float(row), 0.0f, 1.0f});
  TextureStore store({description});
  Diagnostics diagnostics;
  ImageLookup lookup;
  lookup.texture = store.load(0, "", diagnostics);
  lookup.interpolation = Interpolation::Closest;
  ASSERT_TRUE(diagnostics.empty());
  const Vec3 p(0.1f, 0.3f, 0.6f);  // in columns and rows 0, 1 and 2
  const struct {
    Vec3 normal;
    float column, row;
  } sides[] = {{{1, 0, 0}, 1, 2},  {{-1, 0, 0}, 2, 2}, {{0, 1, 0}, 3, 2},
               {{0, -1, 0}, 0, 2}, {{0, 0, 1}, 2, 0},  {{0, 0, -1}, 1, 0}};
  for (const auto& side : sides)
    for (const float blend : {0.0f, 0.5f}) {
      lookup.blend = blend;
      EXPECT_EQ(nodes::image_box(lookup, p, side.normal), Vec4(side.column, side.row, 0.0f, 1.0f))
          << side.normal.x << ' ' << side.normal.y << ' ' << side.normal.z;
    }
  // For a normal halfway between x and y, the mean of both sides.
  EXPECT_LT(glm::length(nodes::image_box(lookup, p, {1, 1, 0}) - Vec4(2.0f, 2.0f, 0.0f, 1.0f)), 1e-5f);
}

}  // namespace ajar::test_box_projection
