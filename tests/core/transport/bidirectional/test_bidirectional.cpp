#include "agreement.h"
#include "gate.h"

namespace ajar::test_bidirectional {

using namespace fixtures;

namespace {
const std::vector<TransportScene> kScenes = transport_scenes();

}  // namespace

class Agreement : public ::testing::TestWithParam<size_t> {};

TEST_P(Agreement, bidirectional_path_tracing_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 0)) GTEST_SKIP() << kLeftOut;
  expect_agreement(kScenes[GetParam()], "bdpt", 16, int(kScenes.size()));
}
TEST_P(Agreement, metropolis_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 1)) GTEST_SKIP() << kLeftOut;
  expect_agreement(kScenes[GetParam()], "metropolis", 64, int(kScenes.size()));
}

INSTANTIATE_TEST_SUITE_P(Scenes, Agreement, ::testing::Range<size_t>(0, kScenes.size()),
                         [](const auto& info) { return kScenes[info.param].name; });

TEST(Bidirectional, the_image_does_not_depend_on_the_number_of_threads) {
  SceneDescription d = kScenes[1].description;
  d.settings.width = 40;
  d.settings.height = 33;
  const auto one = render(d, "bdpt", 4, 5, 1);
  EXPECT_EQ(one, render(d, "bdpt", 4, 5, 2));
  EXPECT_EQ(one, render(d, "bdpt", 4, 5, 8));
  EXPECT_NE(one, render(d, "bdpt", 4, 6, 2));
}

}  // namespace ajar::test_bidirectional
