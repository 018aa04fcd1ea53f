#include "transport/photons/arrival_map.h"

#include <gtest/gtest.h>

#include "feature_scenes.h"
#include "math/random.h"
#include "math/statistics.h"
#include "sampling/sampler.h"
#include "transport/photons/photon_gather.h"

namespace ajar::test_arrival_map {

namespace {

const Vec3 kUp(0, 0, 1);

/// A map of `count` lookups that are distributed over a square of side 2, half of them in each half, and its correct density at
/// the centre.
struct Filled {
  ArrivalMap map;
  double density = 0.0;

  Filled(int count, float difference, Sampler& sampler) {
    std::vector<ArrivalLog> pass(2);
    for (int i = 0; i < count; ++i) {
      const Vec2 u = sampler.get_2d();
      const float w = 1.0f + difference * float(i % 2);
      pass[size_t(i % 2)].at[ArrivalMap::kGathered].push_back(
          {{Vec3(2.0f * u - 1.0f, 0.0f), pack_direction(kUp)}, w, uint32_t(i / 2 % 2)});
      density += double(w) / 4.0;
    }
    map.add(pass);
  }
};

/// Moments over replicates.
template <class Value>
RunningMoments moments_of(int count, float difference, uint32_t replicates, Value&& value) {
  RunningMoments moments;
  Sampler sampler(Sampler::Kind::Independent, 1);
  for (uint32_t replicate = 0; replicate < replicates; ++replicate) {
    sampler.start(replicate, 0);
    moments.add(value(Filled(count, difference, sampler)));
  }
  return moments;
}
/// The estimate of the inverse density at the centre times the correct density.
RunningMoments relative_inverse(int count, float radius) {
  return moments_of(count, 0.5f, 4000, [&](const Filled& filled) {
    EXPECT_EQ(filled.map.inverse_density(ArrivalMap::kSeen, 0, Vec3(0.0f), kUp, radius), 0.0);
    return filled.map.inverse_density(ArrivalMap::kGathered, 0, Vec3(0.0f), kUp, radius) * filled.density;
  });
}

}  // namespace

// Different throughputs cause a relative bias of their variance divided by n, here below half a per cent.
TEST(ArrivalMap, the_mean_of_the_inverse_density_is_correct_for_few_lookups_in_the_disc) {
  const int count = 200;
  const float radius = 0.4f;
  const double mean_count = 0.5 * count * M_PI * double(radius * radius) / 4.0;
  const RunningMoments m = relative_inverse(count, radius);
  EXPECT_NEAR(m.mean(), 1.0 - std::exp(-mean_count), 0.005 + 4.0 * std::sqrt(m.variance_of_mean()));
}

TEST(ArrivalMap, the_mean_of_the_inverse_density_is_correct_for_many_lookups_in_the_disc) {
  const RunningMoments m = relative_inverse(800, 0.5f);
  EXPECT_NEAR(m.mean(), 1.0, 0.005 + 4.0 * std::sqrt(m.variance_of_mean()));
  EXPECT_LT(std::sqrt(m.variance_of_mean()), 0.01);
}

// A fixed number of lookups, 100 in each half, makes the expectation of 1 / W a hundredth too small.
TEST(ArrivalMap, photons_of_both_kinds_have_all_light_together) {
  for (const float chains : {0.3f, 1.0f}) {
    const RunningMoments m = moments_of(200, 0.0f, 8000, [&](const Filled& filled) {
      const ArrivalMap::Factors factors = filled.map.factors(ArrivalMap::kGathered, {Vec3(0.0f), kUp, false}, 0.4f,
                                                             double(chains), filled.density);
      EXPECT_GE(factors.plain, 0.0);
      EXPECT_LE(factors.plain, 1.0);
      return factors.of_chain * filled.density * (101.0 / 100.0) + factors.plain;
    });
    const double error = std::sqrt(m.variance_of_mean());
    ASSERT_LT(4.0 * error, 0.005) << "inconclusive: a bias of 0.5 % has to show";
    EXPECT_NEAR(m.mean(), 1.0, 4.0 * error) << chains;
  }
}

TEST(ArrivalMap, passes_are_averaged) {
  ArrivalLog one;
  for (int i = 0; i < 5; ++i)
    one.at[ArrivalMap::kSeen].push_back({{Vec3(0.01f * float(i), 0, 0), pack_direction(Vec3(0, 0, 1))}, 2.0f});
  ArrivalMap map;
  map.add({one});
  map.add({ArrivalLog()});
  // Half of the throughput in the disc of radius 1 is 10 over two passes. The factor for five lookups is 6 / 5.
  EXPECT_NEAR(map.inverse_density(ArrivalMap::kSeen, 0, Vec3(0.0f), kUp, 1.0f), M_PI / (10.0 * 6.0 / 5.0), 1e-5);
}

/// Throughput that lookups of gather rays record, for one sample of each pixel.
RunningMoments recorded_throughput(const Scene& scene, const PathMedia* media, int stride) {
  const PhotonMaps maps;
  const GatherSettings settings;
  RunningMoments moments;
  const int width = scene.settings().width;
  for (uint32_t sample = 0; sample < 64; ++sample) {
    ArrivalLog log;
    log.stride[ArrivalMap::kGathered] = stride;
    PhotonGatherer gatherer(scene, media, maps, settings, 7);
    gatherer.log_arrivals(&log, true);
    for (int pixel = 0; pixel < width * scene.settings().height; ++pixel) {
      gatherer.start(uint32_t(pixel), sample);
      const Vec2 on_film(float(pixel % width) + 0.5f, float(pixel / width) + 0.5f);
      float alpha;
      Color seen;
      gatherer.trace(scene.camera().generate_ray(on_film, Vec2(0.5f), 0.5f), nullptr, alpha, seen);
    }
    double sum = 0.0;
    for (const Arrival& arrival : log.at[ArrivalMap::kGathered]) sum += double(arrival.throughput);
    moments.add(sum);
  }
  return moments;
}

/// Gather rays start at surfaces, and in fog.
TEST(ArrivalMap, a_part_of_the_lookups_stands_for_all) {
  for (const fixtures::TransportScene& scene : fixtures::feature_scenes()) {
    if (scene.name != "fog_around_the_camera" && scene.name != "points") continue;
    const auto built = fixtures::build(scene.description);
    const std::unique_ptr<PathMedia> media = built->has_media() ? std::make_unique<PathMedia>(*built) : nullptr;
    const RunningMoments all = recorded_throughput(*built, media.get(), 1),
                         part = recorded_throughput(*built, media.get(), 3);
    const double error = std::sqrt(all.variance_of_mean() + part.variance_of_mean());
    EXPECT_NEAR(part.mean(), all.mean(), 4.0 * error) << scene.name;
    EXPECT_LT(error, 0.01 * all.mean()) << scene.name << ": inconclusive";
  }
}

}  // namespace ajar::test_arrival_map
