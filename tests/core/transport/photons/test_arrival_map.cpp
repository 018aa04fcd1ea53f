#include "transport/photons/arrival_map.h"

#include <gtest/gtest.h>

#include "feature_scenes.h"
#include "math/random.h"
#include "math/statistics.h"
#include "sampling/sampler.h"
#include "transport/photons/photon_gather.h"

namespace ajar::test_arrival_map {

namespace {

const SurfacePoint kCentre{Vec3(0.0f), pack_direction(Vec3(0, 0, 1))};

/// A map of `count` lookups that are distributed over a square of side 2, half of them in each half, and its correct
/// density at the centre. Every `rare`-th lookup has 100 times the throughput of the others.
struct Filled {
  ArrivalMap map;
  double density = 0.0;

  Filled(int count, int rare, Sampler& sampler) {
    std::vector<ArrivalLog> pass(2);
    for (int i = 0; i < count; ++i) {
      const Vec2 u = sampler.get_2d();
      const float w = i % rare == 0 ? 100.0f : 1.0f;
      pass[size_t(i % 2)].at[ArrivalMap::kGathered].push_back(
          {{Vec3(2.0f * u - 1.0f, 0.0f), kCentre.packed_normal}, w, uint32_t(i % 2)});
      density += double(w) / 4.0;
    }
    map.add(pass);
  }
};

/// Moments over replicates.
template <class Value>
RunningMoments moments_of(int count, int rare, uint32_t replicates, Value&& value) {
  RunningMoments moments;
  Sampler sampler(Sampler::Kind::Independent, 1);
  for (uint32_t replicate = 0; replicate < replicates; ++replicate) {
    sampler.start(replicate, 0);
    moments.add(value(Filled(count, rare, sampler)));
  }
  return moments;
}

}  // namespace

// With many lookups in the disc, only the nearest of them are used.
TEST(ArrivalMap, the_mean_of_the_density_is_correct_for_few_and_for_many_lookups_in_the_disc) {
  for (const int count : {50, 800}) {
    const RunningMoments m = moments_of(count, 1, 20000, [](const Filled& filled) {
      EXPECT_EQ(filled.map.density(ArrivalMap::kSeen, 0, kCentre, 0.5f), 0.0);
      return filled.map.density(ArrivalMap::kGathered, 0, kCentre, 0.5f) / filled.density;
    });
    const double error = std::sqrt(m.variance_of_mean());
    ASSERT_LT(4.0 * error, 0.012) << "inconclusive: a bias of 1.2 % has to show";
    EXPECT_NEAR(m.mean(), 1.0, 4.0 * error) << count;
  }
}

// Where few lookups have most of the throughput, the reciprocal of the density has a much too large expectation.
TEST(ArrivalMap, photons_of_both_kinds_have_all_light_together) {
  for (const int rare : {1, 25}) {
    for (const float chains : {0.3f, 1.0f}) {
      PhotonMap photon;
      photon.build({{kCentre, Color(1.0f), 0}});
      const RunningMoments m = moments_of(200, rare, 40000, [&](const Filled& filled) {
        double sum = 0.0;
        photon.weigh([&](const PhotonMap::Weighable& at) {
          const ArrivalMap::Factors factors = filled.map.factors(ArrivalMap::kGathered, at, 0.4f, double(chains),
                                                                 filled.density);
          sum = factors.of_chain * filled.density + factors.plain;
          return 1.0;
        });
        return sum;
      });
      const double error = std::sqrt(m.variance_of_mean());
      ASSERT_LT(4.0 * error, rare == 1 ? 0.005 : 0.02) << "inconclusive: such a bias has to show";
      EXPECT_NEAR(m.mean(), 1.0, 4.0 * error) << chains << ", one in " << rare;
    }
  }
}

TEST(ArrivalMap, passes_are_averaged) {
  ArrivalLog one;
  for (int i = 0; i < 5; ++i)
    one.at[ArrivalMap::kSeen].push_back({{Vec3(0.01f * float(i), 0, 0), pack_direction(Vec3(0, 0, 1))}, 2.0f});
  ArrivalMap map;
  map.add({one});
  map.add({ArrivalLog()});
  // Half of the throughput in the disc of radius 1 is 10 over two passes.
  EXPECT_NEAR(map.density(ArrivalMap::kSeen, 0, kCentre, 1.0f), 10.0 / M_PI, 1e-5);
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
