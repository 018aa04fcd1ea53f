#include "transport/media/majorant_grid.h"

#include <gtest/gtest.h>

#include "math/random.h"
#include "math/types.h"

namespace ajar::test_majorant_grid {

namespace {

TEST(MajorantGrid, places_are_between_the_borders_of_their_cells) {
  MajorantGrid even(Vec3(-1, 2, 0), Vec3(3, 4, 0));
  even.divide({16, 8, 1});
  MajorantGrid endless = MajorantGrid::endless(Vec3(5, -3, 0.5f), 20.0f);
  endless.divide({16, 4, 256});
  for (const MajorantGrid* grid : {&even, &endless})
    for (int axis = 0; axis < 3; ++axis) {
      const int n = grid->cells()[size_t(axis)];
      for (int cell = 0; cell < n; ++cell) {
        const float lower = grid->border(axis, cell), upper = grid->border(axis, cell + 1);
        ASSERT_LT(lower, upper);
        EXPECT_NEAR(grid->size(axis, cell), upper - lower, 1e-5f * std::max(std::abs(lower), std::abs(upper)));
        for (const float u : {0.01f, 0.5f, 0.99f})
          EXPECT_EQ(int(grid->place(axis, lower + u * (upper - lower))), cell) << axis;
      }
      EXPECT_LT(grid->place(axis, grid->border(axis, 0) - grid->size(axis, 0)), 0.0f);
      EXPECT_GT(grid->place(axis, grid->border(axis, n) + grid->size(axis, n - 1)), float(n));
    }
}

TEST(MajorantGrid, half_of_the_cells_of_an_endless_medium_are_even) {
  MajorantGrid grid = MajorantGrid::endless(Vec3(0), 8.0f);
  grid.divide({16, 8, 4});
  size_t count = 0;
  for (size_t i = 0; i < grid.count(); ++i) {
    const auto cell = grid.cell(i);
    EXPECT_EQ(grid.index(cell), i);
    count += grid.is_even(cell) ? 1 : 0;
    if (grid.is_even(cell)) {
      EXPECT_LT(glm::length(grid.size(cell) - Vec3(2, 4, 8)), 1e-5f);
    }
  }
  EXPECT_EQ(count, size_t(8 * 4 * 2));
  EXPECT_FLOAT_EQ(grid.border(0, 4), -8.0f);
  EXPECT_FLOAT_EQ(grid.border(0, 12), 8.0f);
  EXPECT_NEAR(grid.border(0, 16), 8.0f * 0x1p20f, 8.0f);
}

}  // namespace

}  // namespace ajar::test_majorant_grid
