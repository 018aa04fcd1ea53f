// Lobes that are turned to another direction are those that the makers make for it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "graph_fixtures.h"
#include "math/random.h"
#include "math/warps.h"
#include "shading/bsdf/closures.h"
#include "transport/paths/path_vertex.h"

namespace ajar::test_turned_lobes {

using namespace fixtures;
using closures::PrincipledInputs;

namespace {

class Random {
 public:
  explicit Random(uint64_t seed) : rng_(seed) {}
  float number() { return rng_.next_float(); }
  /// 0 in half of the cases.
  float amount() { return number() < 0.5f ? 0.0f : number(); }
  Color color() {
    const float r = number(), g = number();
    return {r, g, number()};
  }
  /// On the side of z, not within a degree of the surface.
  Vec3 direction() {
    const float u = number();
    const Vec3 d = warp::square_to_hemisphere({u, number()});
    return glm::normalize(Vec3(d.x, d.y, d.z + 0.02f));
  }

 private:
  Pcg32 rng_;
};

PrincipledInputs any_principled(Random& random, int version) {
  PrincipledInputs in;
  in.version = version;
  in.correlated = version == 2;
  in.distribution = random.number() < 0.5f ? closures::Distribution::MultiGgx : closures::Distribution::Ggx;
  in.base_color = random.color();
  in.metallic = random.amount();
  in.roughness = 0.1f + 0.9f * random.number();
  in.ior = 1.1f + random.number();
  in.transmission = random.amount();
  in.anisotropic = random.amount();
  in.specular_ior_level = random.number();
  in.specular_tint_color = random.color();
  in.sheen = random.amount();
  in.clearcoat = random.amount();
  in.clearcoat_roughness = 0.1f + 0.8f * random.number();
  if (random.number() < 0.5f) in.coat_tint = random.color();
  in.subsurface = random.amount();
  in.diffuse_roughness = random.amount();
  if (random.number() < 0.3f) in.film.thickness = 400.0f;
  const Vec3 tilt(0.2f * (random.number() - 0.5f), 0.2f * (random.number() - 0.5f), 1.0f);
  in.normal = random.number() < 0.5f ? Vec3(0, 0, 1) : glm::normalize(tilt);
  in.clearcoat_normal = random.number() < 0.5f ? Vec3(0, 0, 1) : in.normal;
  return in;
}

Bsdf made(const PrincipledInputs& in, Vec3 wo) {
  Bsdf bsdf;
  bsdf.start(Vec3(0, 0, 1), Vec3(0, 0, 1));
  closures::add_principled(bsdf, {wo, Vec3(0, 0, 1), false}, Color(1.0f), in);
  bsdf.prepare(wo);
  return bsdf;
}

void expect_equal(Color a, Color b, const char* what) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 2e-4f * std::abs(b[c]) + 1e-6f) << what;
}

}  // namespace

TEST(TurnedLobes, are_those_that_are_made_for_the_direction) {
  Random random(1);
  int turned = 0, layered = 0;
  for (int i = 0; i < 2000; ++i) {
    const PrincipledInputs in = any_principled(random, i % 4 == 0 ? 1 : 2);
    const Vec3 from = random.direction(), wo = random.direction();
    const Bsdf bsdf = made(in, from), expected = made(in, wo);
    if (!bsdf.can_turn_to(wo)) continue;
    ++turned;
    layered += bsdf.layer_count() > 0;
    const Bsdf actual = turned_to(bsdf, wo);
    for (int k = 0; k < 4; ++k) {
      const Vec3 up = random.direction(), wi = k == 3 ? -up : up;
      const Bsdf::Evaluation a = actual.evaluate(wo, wi), b = expected.evaluate(wo, wi);
      expect_equal(a.f_cos, b.f_cos, "value");
      EXPECT_NEAR(a.pdf_solid_angle, b.pdf_solid_angle, 2e-4f * b.pdf_solid_angle + 1e-6f);
    }
    // A third direction from the turned lobes.
    const Vec3 again = random.direction();
    if (actual.can_turn_to(again))
      expect_equal(turned_to(actual, again).evaluate(again, wo).f_cos, made(in, again).evaluate(again, wo).f_cos,
                   "turned twice");
  }
  EXPECT_GT(turned, 1000);
  EXPECT_GT(layered, 500);
}

TEST(TurnedLobes, a_pair_of_directions_is_evaluated_as_by_both_ends) {
  Random random(2);
  int pairs = 0;
  for (int i = 0; i < 3000; ++i) {
    const PrincipledInputs in = any_principled(random, i % 4 == 0 ? 1 : 2);
    const Vec3 from = random.direction(), to_eye = i % 3 == 0 ? from : random.direction(),
               to_light = i % 3 == 1 ? from : random.direction();
    const Bsdf bsdf = made(in, from);
    const auto follow = [&](Vec3 wo) { return wo == from || bsdf.can_turn_to(wo); };
    if (!follow(to_eye) || !follow(to_light)) continue;
    ++pairs;
    const Bsdf::PairEvaluation pair = bsdf.evaluate_pair(to_eye, to_light, true);
    const Bsdf::Evaluation forward = made(in, to_eye).evaluate(to_eye, to_light);
    expect_equal(pair.f_cos, forward.f_cos, "value");
    EXPECT_NEAR(pair.pdf_to_light, forward.pdf_solid_angle, 2e-4f * forward.pdf_solid_angle + 1e-6f);
    const float back = made(in, to_light).evaluate(to_light, to_eye).pdf_solid_angle;
    EXPECT_NEAR(pair.pdf_to_eye, back, 2e-4f * back + 1e-6f);
  }
  EXPECT_GT(pairs, 1500);
}

TEST(TurnedLobes, pairs_on_both_sides_of_glass) {
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    Bsdf bsdf;
    const Vec3 wo = random.direction(), a = random.direction(), b = -random.direction();
    bsdf.start(Vec3(0, 0, 1), Vec3(0, 0, 1));
    const closures::RoughBoundary boundary{closures::Distribution::MultiGgx, 0.2f + 0.7f * random.number(), 1.5f, true};
    closures::add_glass(bsdf, {wo, Vec3(0, 0, 1), false}, random.color(), Vec3(0, 0, 1), boundary, true, true);
    closures::add_translucent(bsdf, {wo, Vec3(0, 0, 1), false}, Color(0.3f), Vec3(0, 0, 1));
    closures::add_diffuse(bsdf, {wo, Vec3(0, 0, 1), false}, Color(0.2f), Vec3(0, 0, 1), random.amount());
    bsdf.prepare(wo);
    for (const auto& [to_eye, to_light] : {std::pair(a, b), std::pair(b, a), std::pair(-a, b), std::pair(a, -b)}) {
      const Bsdf::PairEvaluation pair = bsdf.evaluate_pair(to_eye, to_light, false);
      const Bsdf::Evaluation forward = bsdf.evaluate(to_eye, to_light);
      expect_equal(pair.f_cos, forward.f_cos, "value");
      EXPECT_NEAR(pair.pdf_to_light, forward.pdf_solid_angle, 1e-4f * forward.pdf_solid_angle + 1e-6f);
      const float back = bsdf.evaluate(to_light, to_eye).pdf_solid_angle;
      EXPECT_NEAR(pair.pdf_to_eye, back, 1e-4f * back + 1e-6f);
    }
  }
}

TEST(TurnedLobes, not_where_a_normal_is_bent) {
  PrincipledInputs in;
  in.version = 2;
  in.normal = in.clearcoat_normal = glm::normalize(Vec3(0.5f, 0.0f, 1.0f));
  const Vec3 above(0, 0, 1), grazing = glm::normalize(Vec3(-1.0f, 0.0f, 0.1f));
  ASSERT_NE(closures::safe_shading_normal(Vec3(0, 0, 1), grazing, in.normal), in.normal);
  EXPECT_TRUE(made(in, above).can_turn_to(above));
  EXPECT_FALSE(made(in, above).can_turn_to(grazing));
  EXPECT_FALSE(made(in, above).can_turn_to(-above)) << "the other side";
}

TEST(TurnedLobes, shaders_say_how_they_depend_on_the_direction) {
  using ViewDependence = ShaderProgram::ViewDependence;
  const auto dependence = [](const char* node, const char* output, const char* input) {
    GraphBuilder g;
    const int surface = node ? g.node("ShaderNodeBsdfDiffuse", {linked_input(input, g.node(node), output)})
                             : g.node("ShaderNodeBsdfDiffuse");
    g.graph.surface = {surface, "BSDF"};
    return compile(g.graph).view_dependence();
  };
  EXPECT_EQ(dependence(nullptr, nullptr, nullptr), ViewDependence::None);
  EXPECT_EQ(dependence("ShaderNodeNormalMap", "Normal", "Normal"), ViewDependence::Side);
  EXPECT_EQ(dependence("ShaderNodeNewGeometry", "Backfacing", "Color"), ViewDependence::Side);
  EXPECT_EQ(dependence("ShaderNodeNewGeometry", "Incoming", "Color"), ViewDependence::Direction);
  EXPECT_EQ(dependence("ShaderNodeLayerWeight", "Facing", "Color"), ViewDependence::Direction);
}

TEST(TurnedLobes, a_bent_normal_of_a_shader_is_known) {
  GraphBuilder g;
  const int tilt = g.node("ShaderNodeCombineXYZ", {value_input("X", 0.5f), value_input("Z", 1.0f)});
  g.graph.surface = {g.node("ShaderNodeBsdfDiffuse", {linked_input("Normal", tilt, "Vector")}), "BSDF"};
  const ShaderProgram program = compile(g.graph);
  SurfaceShading shading;
  ShadingPoint point;
  point.ng = point.ns = Vec3(0, 0, 1);
  const Vec3 above(0, 0, 1);
  point.wo = above;
  program.evaluate_surface(point, shading);
  EXPECT_TRUE(shading.bsdf.can_turn_to(above));
  point.wo = glm::normalize(Vec3(-1.0f, 0.0f, 0.1f));
  program.evaluate_surface(point, shading);
  EXPECT_FALSE(shading.bsdf.can_turn_to(above)) << "the normal for this direction is not that of the shader";
}

}  // namespace ajar::test_turned_lobes
