// Tests of the resolutions of pictures for a view, and of finer pictures from coarse light.
#include "view/view_pictures.h"

#include <gtest/gtest.h>

#include "view/surface_detail.h"

namespace ajar::test_view_pictures {

namespace {

constexpr double kPixels = 800.0 * 480.0;

/// A schedule that has measured these times for one pixel.
ViewSchedule measured(double sample, double network) {
  ViewSchedule schedule;
  for (int i = 0; i < 40; ++i) {
    schedule.rendered(1000.0, 1.0, 1000.0 * sample);
    schedule.denoised(1000.0, 1000.0 * network);
  }
  return schedule;
}

}  // namespace

TEST(ViewPictures, the_first_picture_takes_less_than_its_time) {
  for (const double seconds : {1e-9, 1e-7, 1e-6, 3e-6, 1e-5}) {
    const ViewSchedule schedule = measured(seconds, seconds);
    const int divider = schedule.first(kPixels).divider;
    EXPECT_LE(schedule.expected_seconds(kPixels / (divider * divider)), ViewSchedule::kFirstSeconds) << seconds;
    EXPECT_NEAR(schedule.expected_seconds(1.0), 2.0 * seconds, 1e-2 * seconds);
  }
  EXPECT_EQ(measured(1e-9, 1e-9).first(kPixels).divider, 1);
  EXPECT_EQ(measured(1.0, 1.0).first(kPixels).divider, ViewSchedule::kCoarsest);
}

TEST(ViewPictures, resolutions_go_from_coarse_to_fine_and_end_at_the_full_one) {
  for (const double seconds : {1e-7, 1e-6, 1e-5, 1e-4, 1.0})
    for (const bool guided : {false, true}) {
      const ViewSchedule schedule = measured(seconds, seconds);
      ViewLevel level = schedule.first(kPixels);
      int count = 0;
      while (level.divider > 1) {
        const ViewLevel next = schedule.finer(level, kPixels, guided);
        ASSERT_LT(next.divider, level.divider);
        EXPECT_TRUE(guided || !next.surfaces);
        level = next;
        ASSERT_LT(++count, 6);
      }
    }
  // As in a room: a coarse picture, the surfaces of the view, the whole picture.
  const ViewSchedule room = measured(1.6e-6, 0.8e-6);
  const ViewLevel first = room.first(kPixels), second = room.finer(first, kPixels, true);
  EXPECT_EQ(first.divider, 4);
  EXPECT_EQ(second.divider, 2);
  EXPECT_TRUE(second.surfaces);
  EXPECT_EQ(room.finer(second, kPixels, true).divider, 1);
}

TEST(ViewPictures, a_divided_region_covers_the_region) {
  for (const int divider : {1, 2, 3, 7, 16})
    for (const std::array<int, 4>& region :
         {std::array<int, 4>{0, 0, 101, 57}, {3, 5, 4, 6}, {100, 56, 101, 57}, {10, 20, 90, 50}}) {
      const ViewSize size = divided(101, 57, region, divider);
      EXPECT_EQ(size.width, (101 + divider - 1) / divider);
      EXPECT_LT(size.region[0], size.region[2]);
      EXPECT_LT(size.region[1], size.region[3]);
      EXPECT_LE(size.region[0] * divider, region[0]);
      EXPECT_GE(size.region[2] * divider, region[2]);
      EXPECT_LE(size.region[1] * divider, region[1]);
      EXPECT_GE(size.region[3] * divider, region[3]);
      EXPECT_LE(size.region[2], size.width);
      EXPECT_LE(size.region[3], size.height);
    }
}

/// Two surfaces that meet within a coarse pixel, one with a texture, below light that grows to the right.
TEST(ViewPictures, coarse_light_on_fine_surfaces_has_sharp_borders_and_textures) {
  constexpr int kWidth = 63, kHeight = 31, kBorder = 33;
  const ViewSize fine = divided(kWidth, kHeight, {0, 0, kWidth, kHeight}, 1),
                 coarse = divided(kWidth, kHeight, {0, 0, kWidth, kHeight}, 2);
  const auto make = [&](const ViewSize& size, int divider, std::vector<float>& albedo, std::vector<float>& normal) {
    std::vector<float> rgba;
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        const int column = x * divider;
        const bool left = column < kBorder;
        const float grey = left ? 0.8f : column % 4 < 2 ? 0.3f : 0.5f;
        const float light = 1.0f + 0.01f * (float(x) + 0.5f) * float(divider);
        for (int c = 0; c < 3; ++c) {
          albedo.push_back(grey);
          normal.push_back(c == (left ? 0 : 2) ? 1.0f : 0.0f);
          rgba.push_back(grey * light);
        }
        rgba.push_back(left ? 1.0f : 0.5f);
      }
    return rgba;
  };
  std::vector<float> albedo[2], normal[2];
  const std::vector<float> known = make(coarse, 2, albedo[0], normal[0]),
                           expected = make(fine, 1, albedo[1], normal[1]);
  const std::vector<float> found = with_surfaces(known, {albedo[0], normal[0], coarse}, {albedo[1], normal[1], fine});
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 0.06f * expected[i]) << i / 4 % kWidth;
}

}  // namespace ajar::test_view_pictures
