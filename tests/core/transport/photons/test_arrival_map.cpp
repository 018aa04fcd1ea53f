#include "transport/photons/arrival_map.h"

#include <gtest/gtest.h>

#include "math/random.h"
#include "math/statistics.h"
#include "sampling/sampler.h"

namespace ajar::test_arrival_map {

namespace {

/// `count` lookups are distributed over a square of side 2. Returns the estimate of the inverse density at its centre
/// times the correct density, as moments over replicates.
RunningMoments relative_inverse(int count, float radius) {
  RunningMoments moments;
  Sampler sampler(Sampler::Kind::Independent, 1);
  for (uint32_t replicate = 0; replicate < 4000; ++replicate) {
    sampler.start(replicate, 0);
    std::vector<ArrivalLog> pass(2);
    double throughput = 0.0;
    for (int i = 0; i < count; ++i) {
      const Vec2 u = sampler.get_2d();
      const float w = 1.0f + 0.5f * float(i % 2);
      pass[size_t(i % 2)].at[ArrivalMap::kGathered].push_back(
          {{Vec3(2.0f * u - 1.0f, 0.0f), pack_direction(Vec3(0, 0, 1))}, w});
      throughput += double(w);
    }
    ArrivalMap map;
    map.add(pass);
    moments.add(map.inverse_density(ArrivalMap::kGathered, Vec3(0.0f), Vec3(0, 0, 1), radius) * throughput / 4.0);
    EXPECT_EQ(map.inverse_density(ArrivalMap::kSeen, Vec3(0.0f), Vec3(0, 0, 1), radius), 0.0);
  }
  return moments;
}

}  // namespace

// Different throughputs cause a relative bias of their variance divided by n, here below half a per cent.
TEST(ArrivalMap, the_mean_of_the_inverse_density_is_correct_for_few_lookups_in_the_disc) {
  const int count = 100;
  const float radius = 0.4f;
  const double mean_count = count * M_PI * double(radius * radius) / 4.0;
  const RunningMoments m = relative_inverse(count, radius);
  EXPECT_NEAR(m.mean(), 1.0 - std::exp(-mean_count), 0.005 + 4.0 * std::sqrt(m.variance_of_mean()));
}

TEST(ArrivalMap, the_mean_of_the_inverse_density_is_correct_for_many_lookups_in_the_disc) {
  const RunningMoments m = relative_inverse(400, 0.5f);
  EXPECT_NEAR(m.mean(), 1.0, 0.005 + 4.0 * std::sqrt(m.variance_of_mean()));
  EXPECT_LT(std::sqrt(m.variance_of_mean()), 0.01);
}

TEST(ArrivalMap, passes_are_averaged) {
  ArrivalLog one;
  for (int i = 0; i < 5; ++i)
    one.at[ArrivalMap::kSeen].push_back({{Vec3(0.01f * float(i), 0, 0), pack_direction(Vec3(0, 0, 1))}, 2.0f});
  ArrivalMap map;
  map.add({one});
  map.add({ArrivalLog()});
  // The throughput in the disc of radius 1 is 10 over two passes. The factor for five lookups is 6 / 5.
  EXPECT_NEAR(map.inverse_density(ArrivalMap::kSeen, Vec3(0.0f), Vec3(0, 0, 1), 1.0f), M_PI * 2.0 / (10.0 * 6.0 / 5.0),
              1e-5);
}

}  // namespace ajar::test_arrival_map
