// The precision of floats is sufficient: their rounding changes images by at most a tenth of the noise at 4096 samples
// per pixel.
#include <gtest/gtest.h>

#include "rounding.h"
#include "transport_scenes.h"

namespace ajar::test_rounding {

namespace {

using namespace fixtures;

constexpr int kImageSamples = 16, kSeeds = 16;
constexpr double kMaxShareOfNoise = 0.1;

SceneDescription scene_named(const std::string& name) {
  for (TransportScene& scene : transport_scenes())
    if (scene.name == name) return std::move(scene.description);
  throw std::runtime_error(name);
}

SceneDescription foggy() {
  SceneDescription d = scene_named("area_lamp");
  GraphBuilder b;
  b.graph.volume = {b.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(0.8f)), value_input("Density", 0.5f),
                                                       value_input("Anisotropy", 0.3f)}),
                    "Volume"};
  d.world.graph = b.graph;
  d.settings.bounces.volume = 4;
  return d;
}

struct Case {
  const char *integrator, *scene;
};
std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.integrator << " " << c.scene; }
class RoundingIn : public testing::TestWithParam<Case> {};

TEST_P(RoundingIn, of_floats_is_at_most_a_tenth_of_the_noise_at_4096_samples) {
  const std::string name = GetParam().scene;
  const auto shares = rounding::measure(build(name == "fog" ? foggy() : scene_named(name)), GetParam().integrator,
                                        kImageSamples, kSeeds);
  ASSERT_EQ(shares.size(), std::size(rounding::kDirected)) << "a thread did not use the rounding mode";
  for (const rounding::Share& share : shares) {
    EXPECT_LT(share.total(), kMaxShareOfNoise)
        << share.mode << ": straying " << share.straying << ", shift " << share.shift;
    EXPECT_GT(share.total(), 0.0) << share.mode << " changed nothing, so the rounding mode was not active";
  }
}
INSTANTIATE_TEST_SUITE_P(Scenes, RoundingIn,
                         testing::Values(Case{"path", "rough_glass_and_mirror"}, Case{"path", "textured_emission"},
                                         Case{"path", "sun"}, Case{"path", "fog"}, Case{"bdpt", "glossy"}),
                         [](const auto& info) { return std::string(info.param.integrator) + "_" + info.param.scene; });

/// A room of two metres at a distance of a million metres from the origin, where the step of floats is six centimetres.
/// Rounding dominates this image.
TEST(Rounding, that_dominates_the_image_is_detected) {
  SceneDescription d = scene_named("area_lamp");
  const auto move = [](std::array<float, 12>& m) {
    for (size_t i = 0; i < 3; ++i) m[4 * i + 3] += 1e6f;
  };
  for (InstanceDescription& instance : d.instances) move(instance.world_from_object);
  for (LightDescription& light : d.lights) move(light.world_from_light);
  move(d.camera.world_from_camera);
  for (const rounding::Share& share : rounding::measure(build(std::move(d)), "path", 4, 8))
    EXPECT_GT(share.total(), kMaxShareOfNoise) << share.mode;
}

}  // namespace

}  // namespace ajar::test_rounding
