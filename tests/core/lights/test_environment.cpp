#include <gtest/gtest.h>

#include "graph_fixtures.h"
#include "lights/environment.h"

namespace ajar::test_environment {

using namespace fixtures;

// The sun disc is smaller than a cell of the map and at its centre, so that no corner of the map lies in it.
TEST(Environment, a_sun_between_the_corners_of_the_map_is_sampled) {
  const float pi = kPi, azimuth = 100.5f * 2.0f * pi / 1024.0f, elevation = 0.5f * pi - 150.5f * pi / 512.0f;
  GraphBuilder g;
  const int sky = g.node(
      "ShaderNodeTexSky", {},
      {text_property("sky_type", "NISHITA"), number_property("sun_elevation", {elevation}),
       number_property("sun_rotation", {0.5f * pi - azimuth}), number_property("sun_size", {0.003f})});
  const int background = g.node("ShaderNodeBackground",
                                {linked_input("Color", sky, "Color"), value_input("Strength", 1.0f)});
  g.graph.surface = {background, "Background"};
  const ShaderProgram program = compile(g.graph);
  const auto discs = program.sky_discs();
  ASSERT_EQ(discs.size(), 1u);
  const Environment environment(program, kVisibleAll);

  // The irradiance by the sun alone on a plane that faces it: estimated by samples of the density, and by quadrature
  // over the disc.
  constexpr int kSide = 256, kRings = 200;
  double sampled = 0.0;
  int near = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    float pdf;
    const Vec3 wi = environment.sample({(float(i % kSide) + 0.5f) / kSide, (float(i / kSide) + 0.5f) / kSide}, pdf);
    near += glm::dot(wi, discs[0].direction) > std::cos(0.006f);
    if (glm::length(wi - discs[0].direction) < discs[0].angular_radius)
      sampled += luminance(environment.radiance(wi, 0)) / pdf;
  }
  sampled /= kSide * kSide;
  double exact = 0.0;
  const Vec3 side = glm::normalize(glm::cross(discs[0].direction, Vec3(0, 0, 1)));
  for (int k = 0; k < kRings; ++k) {
    const float r = discs[0].angular_radius * (float(k) + 0.5f) / kRings;
    exact += luminance(environment.radiance(glm::normalize(discs[0].direction + r * side), 0)) * 2.0f * pi * r *
             discs[0].angular_radius / kRings;
  }
  EXPECT_GT(near, kSide * kSide / 5);  // most of the light comes from the sun
  EXPECT_NEAR(sampled, exact, 0.02 * exact);
}

}  // namespace ajar::test_environment
