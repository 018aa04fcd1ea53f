#include "shading/media/phase_shape.h"

#include <gtest/gtest.h>

#include <string>

#include "graph_fixtures.h"
#include "math/statistics.h"
#include "shading/media/medium.h"
#include "statistical.h"

namespace ajar::test_phase_shape {

using namespace fixtures;

namespace {

struct Case {
  std::string name;
  PhaseShape shape;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const float g : {0.0f, 5e-4f, 0.3f, -0.7f, 0.9f, 0.99f})
    all.push_back({"Henyey-Greenstein " + std::to_string(g), PhaseShape::henyey_greenstein(g)});
  for (const float g : {0.0f, 2e-3f, 0.3f, -0.7f, 0.95f})
    for (const float alpha : {0.5f, 1.0f, 250.0f})
      all.push_back({"Draine " + std::to_string(g) + " " + std::to_string(alpha), PhaseShape::draine(g, alpha)});
  // The last index makes delta 1 at 90 degrees; that before, at 180 degrees.
  for (const float ior : {1.001f, 1.05f, 1.33f, 1.9f, 1.0f + std::sqrt(4.0f / 3.0f), 1.0f + std::sqrt(2.0f / 3.0f)})
    for (const float backscatter : {0.0183f, 0.1f, 0.3f, 0.7f})
      all.push_back({"Fournier-Forand " + std::to_string(ior) + " " + std::to_string(backscatter),
                     PhaseShape::fournier_forand(backscatter, ior)});
  return all;
}

}  // namespace

// The cosines are compared with the integral of the density over 40 ranges, finer near the forward direction.
TEST(PhaseShape, every_shape_integrates_to_one_and_is_sampled_with_its_density) {
  constexpr int kBins = 40, kSamples = 40000, kSteps = 4000;
  for (const Case& c : cases()) {
    double within[kBins], total = 0.0;
    const auto edge = [](int i) { return std::pow(double(i) / kBins, 3.0); };  // of (1 - cosine) / 2
    for (int bin = 0; bin < kBins; ++bin) {
      within[bin] = 0.0;
      const double low = edge(bin), high = edge(bin + 1);
      for (int k = 0; k < kSteps; ++k)
        within[bin] += c.shape.evaluate(float(1.0 - 2.0 * (low + (high - low) * (k + 0.5) / kSteps)));
      within[bin] *= 4.0 * double(kPi) * (high - low) / kSteps;
      total += within[bin];
    }
    EXPECT_NEAR(total, 1.0, 5e-3) << c.name;
    Pcg32 rng(3);
    double counts[kBins] = {};
    for (int i = 0; i < kSamples; ++i) {
      const double x = 0.5 * (1.0 - double(c.shape.sample((float(i) + rng.next_float()) / kSamples)));
      ++counts[std::min(int(std::cbrt(x) * kBins), kBins - 1)];
    }
    for (int bin = 0; bin < kBins; ++bin)  // stratified samples: two at each edge, and rounding of the cosine
      EXPECT_NEAR(counts[bin] / kSamples, within[bin], 1e-3 + 0.01 * within[bin]) << c.name << ", range " << bin;
  }
}

TEST(PhaseShape, fournier_forand_scatters_the_given_fraction_backwards) {
  for (const float ior : {1.05f, 1.33f, 1.9f})
    for (const float backscatter : {0.0183f, 0.1f, 0.3f}) {
      const PhaseShape shape = PhaseShape::fournier_forand(backscatter, ior);
      constexpr int kSteps = 4000;
      double back = 0.0;
      for (int i = 0; i < kSteps; ++i) back += shape.evaluate(-(float(i) + 0.5f) / kSteps) * 2.0 * double(kPi) / kSteps;
      EXPECT_NEAR(back, backscatter, 1e-3) << ior;
    }
}

TEST(PhaseShape, shapes_have_the_mean_cosines_of_their_papers) {
  for (const float g : {0.0f, 0.3f, -0.7f}) {
    EXPECT_FLOAT_EQ(PhaseShape::henyey_greenstein(g).mean_cosine(), g);
    const PhaseShape shape = PhaseShape::draine(g, 2.0f);
    RunningMoments mean;
    for (int i = 0; i < 20000; ++i) mean.add(double(shape.sample((float(i) + 0.5f) / 20000.0f)));
    EXPECT_NEAR(mean.mean(), double(shape.mean_cosine()), 2e-3);
  }
  EXPECT_NEAR(PhaseShape::rayleigh().evaluate(1.0f), 2.0f * PhaseShape::rayleigh().evaluate(0.0f), 1e-6f);
}

TEST(PhaseShape, droplets_of_any_diameter_have_valid_shapes) {
  float previous = -1.0f;
  for (const float diameter : {-1.0f, 0.0f, 0.05f, 0.1f, 0.5f, 1.0f, 1.5f, 3.0f, 4.999f, 5.0f, 20.0f, 50.0f, 1e9f}) {
    const MieShapes shapes = mie_shapes(diameter);
    EXPECT_GE(shapes.draine_share, 0.0f) << diameter;
    EXPECT_LE(shapes.draine_share, 1.0f) << diameter;
    for (const PhaseShape& shape : {shapes.henyey_greenstein, shapes.draine})
      for (const float cosine : {-1.0f, 0.0f, 1.0f}) {
        EXPECT_GE(shape.evaluate(cosine), 0.0f) << diameter;
        EXPECT_TRUE(std::isfinite(shape.evaluate(cosine))) << diameter;
      }
    const float mean = glm::mix(shapes.henyey_greenstein.mean_cosine(), shapes.draine.mean_cosine(),
                                shapes.draine_share);
    if (diameter >= 5.0f) {  // larger droplets scatter forwards
      EXPECT_GE(mean, previous) << diameter;
    }
    previous = mean;
  }
}

TEST(PhaseShape, nodes_give_a_medium_its_phase_function) {
  const auto scattering = [](const char* phase, const NodeInput& first, const NodeInput& second) {
    GraphBuilder b;
    b.graph.volume = {b.node("ShaderNodeVolumeScatter", {value_input("Density", 2.0f), first, second},
                             {text_property("phase", phase)}),
                      "Volume"};
    ShadingPoint point;
    MediumPoint m;
    compile(b.graph).add_medium(point, m);
    return m;
  };
  const MediumPoint water = scattering("FOURNIER_FORAND", value_input("Backscatter", 0.2f), value_input("IOR", 1.2f));
  ASSERT_EQ(water.lobe_count, 1);
  EXPECT_EQ(water.lobes[0].shape, PhaseShape::fournier_forand(0.2f, 1.2f));
  const MediumPoint dust = scattering("DRAINE", value_input("Anisotropy", 0.4f), value_input("Alpha", 3.0f));
  EXPECT_EQ(dust.lobes[0].shape, PhaseShape::draine(0.4f, 3.0f));
  EXPECT_EQ(scattering("RAYLEIGH", value_input("Anisotropy", 0.4f), value_input("Alpha", 3.0f)).lobes[0].shape,
            PhaseShape::rayleigh());
  const MediumPoint fog = scattering("MIE", value_input("Diameter", 10.0f), value_input("Alpha", 3.0f));
  ASSERT_EQ(fog.lobe_count, 2);
  EXPECT_NEAR(fog.extinction.x, 2.0f * 0.8f, 1e-5f);
  EXPECT_NEAR(fog.lobes[1].scattering.x, 1.6f * mie_shapes(10.0f).draine_share, 1e-5f);

  GraphBuilder b;
  b.graph.volume = {
      b.node("ShaderNodeVolumeCoefficients",
             {value_input("Scatter Coefficients", Vec4(1.0f, 2.0f, 3.0f, 0.0f)),
              value_input("Absorption Coefficients", Vec4(0.5f, 0.25f, 0.0f, 0.0f)),
              value_input("Emission Coefficients", Vec4(4.0f, 5.0f, 6.0f, 0.0f)), value_input("Anisotropy", 0.3f)}),
      "Volume"};
  ShadingPoint point;
  MediumPoint m;
  compile(b.graph).add_medium(point, m);
  EXPECT_EQ(m.scattering, Color(1.0f, 2.0f, 3.0f));
  EXPECT_EQ(m.extinction, Color(1.5f, 2.25f, 3.0f));
  EXPECT_EQ(m.emission, Color(4.0f, 5.0f, 6.0f));
  EXPECT_EQ(m.lobes[0].shape, PhaseShape::henyey_greenstein(0.3f));
}

}  // namespace ajar::test_phase_shape
