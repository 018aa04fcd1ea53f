#include <gtest/gtest.h>

#include "graph_fixtures.h"
#include "lights/sources/environment.h"
#include "math/frame.h"
#include "math/warps.h"

namespace ajar::test_environment {

using namespace fixtures;

ShaderProgram sky_program(const char* type, float sun_elevation, float sun_rotation, float sun_size) {
  GraphBuilder g;
  const int sky = g.node("ShaderNodeTexSky", {},
                         {text_property("sky_type", type), number_property("sun_elevation", {sun_elevation}),
                          number_property("sun_rotation", {sun_rotation}), number_property("sun_size", {sun_size})});
  const int background = g.node("ShaderNodeBackground",
                                {linked_input("Color", sky, "Color"), value_input("Strength", 1.0f)});
  g.graph.surface = {background, "Background"};
  return compile(g.graph);
}

// The sun disc is smaller than a cell of the map and at its centre, so that no corner of the map lies in it.
TEST(Environment, a_sun_between_the_corners_of_the_map_is_sampled) {
  const float pi = kPi, azimuth = 100.5f * 2.0f * pi / 1024.0f, elevation = 0.5f * pi - 150.5f * pi / 512.0f;
  const ShaderProgram program = sky_program("NISHITA", elevation, 0.5f * pi - azimuth, 0.003f);
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

// The second moment of estimates of the light of a sun, by quadrature over its disc. It would be large if the cells of
// the map at the rim of a large sun, or near the zenith, were sampled too rarely.
TEST(Environment, suns_of_all_sizes_and_elevations_are_sampled_by_their_radiance) {
  for (const Vec2 sun :
       {Vec2(0.0095f, 0.3f), Vec2(0.1f, 0.3f), Vec2(0.3f, 0.9f), Vec2(0.1f, 1.52f), Vec2(1.0f, 0.4f)}) {
    const ShaderProgram program = sky_program("MULTIPLE_SCATTERING", sun.y, 1.0f, sun.x);
    const auto discs = program.sky_discs();
    ASSERT_EQ(discs.size(), 1u);
    const Environment environment(program, kVisibleAll);
    const Frame frame(discs[0].direction);
    constexpr int kCount = 50000;
    const float height = warp::one_minus_cos(discs[0].angular_radius);
    double mean = 0.0, squares = 0.0;
    for (int i = 0; i < kCount; ++i) {
      const float h = height * (float(i) + 0.5f) / kCount, r = safe_sqrt(h * (2.0f - h)), phi = 2.4f * float(i % 9973);
      const Vec3 wi = frame.to_world({r * std::cos(phi), r * std::sin(phi), 1.0f - h});
      const double radiance = luminance(environment.radiance(wi, 0)), solid_angle = 2.0 * kPi * height / kCount;
      mean += radiance * solid_angle;
      squares += radiance * radiance * solid_angle / environment.pdf_solid_angle(wi);
    }
    EXPECT_LT(squares, 1.6 * mean * mean) << sun.x << " at " << sun.y;
    EXPECT_GT(environment.disc_share(), 0.6f);
  }
}

// A sun of the size of the real one in a picture of a sky. The second moment of its light would be large if its rim were
// sampled by the mean of whole cells, and larger where it reaches into a cell without a corner in it.
TEST(Environment, a_sun_in_a_picture_is_sampled_by_its_own_shape) {
  constexpr int kWidth = 4096, kHeight = 2048;
  for (const float shift : {0.0f, 0.3f, 0.5f}) {  // in cells of the map, which are 4 x 4 pixels
    ImageDescription image;
    image.name = "sky";
    image.color_space = "Linear";
    image.width = kWidth;
    image.height = kHeight;
    image.pixels.assign(size_t(kWidth) * kHeight * 4, 1.0f);
    const float theta = kPi * (140.0f + shift) / 512.0f, phi = 2.0f * kPi * (200.0f + shift) / 1024.0f;
    constexpr float kRadius = 0.00465f;
    int lit = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const float dy = kPi * (float(y) + 0.5f) / kHeight - theta,
                    dx = (2.0f * kPi * (float(x) + 0.5f) / kWidth - phi) * std::sin(theta);
        if (dx * dx + dy * dy > kRadius * kRadius) continue;
        ++lit;
        for (int k = 0; k < 3; ++k) image.pixels[4 * (size_t(kHeight - 1 - y) * kWidth + size_t(x)) + size_t(k)] = 3e5f;
      }
    ASSERT_GT(lit, 20);
    TextureStore textures({image});
    GraphBuilder g;
    const int picture = g.node("ShaderNodeTexEnvironment", {}, {number_property("image", {0.0f})});
    const int background = g.node("ShaderNodeBackground", {linked_input("Color", picture, "Color")});
    g.graph.surface = {background, "Background"};
    const ShaderProgram program = compile(g.graph, nullptr, &textures);
    const Environment environment(program, kVisibleAll);
    constexpr int kSide = 512;
    double mean = 0.0, of_sun = 0.0, squares = 0.0;
    for (int i = 0; i < kSide * kSide; ++i) {
      float pdf;
      const Vec3 wi = environment.sample({(float(i % kSide) + 0.5f) / kSide, (float(i / kSide) + 0.5f) / kSide}, pdf);
      ASSERT_GT(pdf, 0.0f);
      const double radiance = luminance(environment.radiance(wi, 0)), value = radiance / pdf / (kSide * kSide);
      mean += value;
      if (!(radiance > 10.0)) continue;
      of_sun += value;
      squares += value * value * (kSide * kSide);
    }
    EXPECT_NEAR(mean, 4.0 * M_PI * double(environment.mean_luminance()), 0.02 * mean) << shift;
    EXPECT_GT(of_sun, 0.5 * mean) << shift;
    EXPECT_LT(squares, 1.2 * of_sun * of_sun) << shift;
  }
}

// A program with noise is evaluated at few corners, except where they differ. The density stays positive, and follows a
// small bright spot.
TEST(Environment, a_bright_spot_in_a_slow_sky_is_sampled_by_its_own_shape) {
  GraphBuilder g;
  const int coordinates = g.node("ShaderNodeTexCoord");
  const int noise = g.node("ShaderNodeTexNoise",
                           {linked_input("Vector", coordinates, "Generated"), value_input("Scale", 5.0f)});
  const int towards = g.node(
      "ShaderNodeVectorMath",
      {linked_input("Vector", coordinates, "Generated"), value_input("Vector_001", Vec4(0.6f, 0.0f, 0.8f, 0.0f))},
      {text_property("operation", "DOT_PRODUCT")});
  const int spot = g.node("ShaderNodeMapRange",
                          {linked_input("Value", towards, "Value"), value_input("From Min", 0.998f),
                           value_input("From Max", 0.999f), value_input("To Max", 500.0f)});
  const int sum = g.node("ShaderNodeMath",
                         {linked_input("Value", noise, "Fac"), linked_input("Value_001", spot, "Result")},
                         {text_property("operation", "ADD")});
  const int background = g.node("ShaderNodeBackground", {linked_input("Strength", sum, "Value")});
  g.graph.surface = {background, "Background"};
  const ShaderProgram program = compile(g.graph);
  ASSERT_TRUE(program.emission_is_slow());
  const Environment environment(program, kVisibleAll);
  constexpr int kSide = 200;
  double sampled = 0.0, squares = 0.0;
  for (int i = 0; i < kSide * kSide; ++i) {
    float pdf;
    const Vec3 wi = environment.sample({(float(i % kSide) + 0.5f) / kSide, (float(i / kSide) + 0.5f) / kSide}, pdf);
    ASSERT_GT(pdf, 0.0f);
    EXPECT_NEAR(environment.pdf_solid_angle(wi) / pdf, 1.0f, 2e-2f);
    const double value = luminance(environment.radiance(wi, 0)) / pdf;
    sampled += value / (kSide * kSide);
    squares += value * value / (kSide * kSide);
  }
  // About 500 over a cone of cos 0.9985, and a half everywhere.
  EXPECT_NEAR(sampled, 2.0 * M_PI * (500.0 * 0.0015 + 1.0), 0.5);
  EXPECT_NEAR(sampled, 4.0 * M_PI * double(environment.mean_luminance()), 0.02 * sampled);
  EXPECT_LT(squares / (sampled * sampled), 8.0);  // uniform directions have about 150
}

}  // namespace ajar::test_environment
