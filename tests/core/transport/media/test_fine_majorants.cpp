#include "transport/media/fine_majorants.h"

#include <gtest/gtest.h>

namespace ajar {
namespace {

TEST(FineMajorants, shares_are_rounded_up_by_nine_percent_at_most) {
  for (float share = 1.0f; share > 1e-9f; share *= 0.987f) {
    const float kept = FineMajorants::share_of(FineMajorants::code_of(share));
    EXPECT_GE(kept, share);
    EXPECT_LE(kept, 1.092f * share);
  }
  EXPECT_EQ(FineMajorants::share_of(FineMajorants::code_of(1.0f)), 1.0f);
  EXPECT_EQ(FineMajorants::share_of(FineMajorants::code_of(1.5f)), 1.0f);
  EXPECT_GT(FineMajorants::share_of(FineMajorants::code_of(0.0f)), 0.0f);
}

TEST(FineMajorants, each_divided_cell_is_found_once) {
  const FineMajorants fine(8, {5, 2});
  EXPECT_TRUE(fine.divides(5) && fine.divides(2));
  EXPECT_FALSE(fine.divides(0));
  EXPECT_FALSE(FineMajorants().divides(0));
  int calls = 0;
  const auto find = [&](FineMajorants::Cells& cells) { cells.fill(uint8_t(++calls)); };
  EXPECT_EQ(fine.in(5, find)[0], 1);
  EXPECT_EQ(fine.in(2, find)[7], 2);
  EXPECT_EQ(fine.in(5, find)[3], 1);
  EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace ajar
