#include "shading/shader_program.h"

#include <gtest/gtest.h>

#include <random>

#include "geometry/geometry.h"
#include "graph_fixtures.h"

namespace ajar::test_shader_program {

namespace {

using namespace fixtures;

/// A node whose value the compiler cannot fold to a constant.
int varying_value(GraphBuilder& g) { return g.node("ShaderNodeLightPath"); }

}  // namespace

TEST(ShaderProgram, empty_graph_is_black_and_opaque) {
  const ShaderProgram program = compile(NodeGraph());
  SurfaceShading shading;
  program.evaluate_surface(ShadingPoint(), shading);
  EXPECT_TRUE(shading.bsdf.empty());
  EXPECT_EQ(shading.emission, Color(0.0f));
  EXPECT_EQ(program.evaluate_transparency(ShadingPoint()), Color(0.0f));
  EXPECT_FALSE(program.emits() || program.scatters() || program.may_be_transparent());
}

TEST(ShaderProgram, constant_graphs_have_no_instructions) {
  GraphBuilder g;
  const int a = g.node("ShaderNodeMath", {value_input("Value", 2.0f), value_input("Value_001", 3.0f)},
                       {text_property("operation", "MULTIPLY")});
  const int b = g.node("ShaderNodeMath", {linked_input("Value", a, "Value"), value_input("Value_001", 0.5f)},
                       {text_property("operation", "MULTIPLY")});
  const int rgb = g.node("ShaderNodeRGB", {}, {number_property("value", {0.1f, 0.2f, 0.3f, 1.0f})});
  const int emission = g.node("ShaderNodeEmission",
                              {linked_input("Color", rgb, "Color"), linked_input("Strength", b, "Value")});
  g.graph.surface = {emission, "Emission"};
  const ShaderProgram program = compile(g.graph);
  EXPECT_EQ(program.instruction_count(), 0);
  EXPECT_TRUE(program.is_constant() && program.emission_is_constant() && program.emits());
  const Color e = program.evaluate_emission(ShadingPoint());
  EXPECT_FLOAT_EQ(e.x, 0.3f);
  EXPECT_FLOAT_EQ(e.z, 0.9f);
}

TEST(ShaderProgram, unused_nodes_and_mixes_with_weight_zero_are_removed) {
  GraphBuilder g;
  const int ray = varying_value(g);
  const int dead = g.node("ShaderNodeEmission", {linked_input("Strength", ray, "Ray Length")});
  const int diffuse = g.node("ShaderNodeBsdfDiffuse", {value_input("Color", 0.5f)});
  const int mix = g.node("ShaderNodeMixShader", {value_input("Fac", 0.0f), linked_input("Shader", diffuse, "BSDF"),
                                                 linked_input("Shader_001", dead, "Emission")});
  g.graph.surface = {mix, "Shader"};
  const ShaderProgram program = compile(g.graph);
  EXPECT_EQ(program.instruction_count(), 0) << program.listing();
  EXPECT_FALSE(program.emits());
  EXPECT_TRUE(program.scatters());
}

TEST(ShaderProgram, shared_subexpressions_are_evaluated_once) {
  GraphBuilder g;
  const int ray = varying_value(g);
  const auto doubled = [&] {
    return g.node("ShaderNodeMath", {linked_input("Value", ray, "Ray Length"), value_input("Value_001", 2.0f)},
                  {text_property("operation", "MULTIPLY")});
  };
  const int sum = g.node("ShaderNodeMath",
                         {linked_input("Value", doubled(), "Value"), linked_input("Value_001", doubled(), "Value")});
  g.emit(sum, "Value");
  const ShaderProgram program = compile(g.graph);
  EXPECT_EQ(program.instruction_count(), 4)
      << program.listing();  // ray length, its double, the sum, the conversion to a colour
  ShadingPoint point;
  point.ray_length = 1.5f;
  EXPECT_FLOAT_EQ(program.evaluate_emission(point).y, 6.0f);
}

TEST(ShaderProgram, mix_factors_multiply_into_weights) {
  GraphBuilder g;
  const int red = g.node("ShaderNodeEmission", {value_input("Color", Vec4(1, 0, 0, 1)), value_input("Strength", 1.0f)});
  const int green = g.node("ShaderNodeEmission",
                           {value_input("Color", Vec4(0, 1, 0, 1)), value_input("Strength", 1.0f)});
  const int inner = g.node("ShaderNodeMixShader", {value_input("Fac", 0.25f), linked_input("Shader", red, "Emission"),
                                                   linked_input("Shader_001", green, "Emission")});
  const int outer = g.node("ShaderNodeMixShader", {value_input("Fac", 0.5f), linked_input("Shader", inner, "Shader"),
                                                   linked_input("Shader_001", green, "Emission")});
  g.graph.surface = {outer, "Shader"};
  const Color e = compile(g.graph).evaluate_emission(ShadingPoint());
  EXPECT_FLOAT_EQ(e.x, 0.375f);
  EXPECT_FLOAT_EQ(e.y, 0.125f + 0.5f);
}

TEST(ShaderProgram, principled_alpha_and_emission_become_closures) {
  GraphBuilder g;
  const int principled = g.node(
      "ShaderNodeBsdfPrincipled",
      {value_input("Base Color", 0.8f), value_input("Emission", Vec4(1, 0.5f, 0, 1)),
       value_input("Emission Strength", 2.0f), value_input("Alpha", 0.25f), value_input("Specular", 0.5f)});
  g.graph.surface = {principled, "BSDF"};
  const ShaderProgram program = compile(g.graph);
  EXPECT_TRUE(program.is_constant() && program.scatters() && program.emits() && program.may_be_transparent());
  EXPECT_FLOAT_EQ(program.evaluate_transparency(ShadingPoint()).x, 0.75f);
  EXPECT_FLOAT_EQ(program.evaluate_emission(ShadingPoint()).x, 0.5f);
  SurfaceShading shading;
  program.evaluate_surface(ShadingPoint(), shading);
  EXPECT_FLOAT_EQ(shading.emission.y, 0.25f);
  EXPECT_FLOAT_EQ(shading.bsdf.transparency().z, 0.75f);
}

TEST(ShaderProgram, principled_of_blender_4_reads_its_own_sockets) {
  GraphBuilder g;
  const int principled = g.node("ShaderNodeBsdfPrincipled",
                                {value_input("Base Color", 0.8f), value_input("Emission Color", Vec4(1, 1, 1, 1)),
                                 value_input("Emission Strength", 3.0f), value_input("Coat Weight", 0.0f),
                                 value_input("Specular IOR Level", 0.5f), value_input("Alpha", 1.0f)});
  g.graph.surface = {principled, "BSDF"};
  const ShaderProgram program = compile(g.graph);
  EXPECT_FLOAT_EQ(program.evaluate_emission(ShadingPoint()).x, 3.0f);
  EXPECT_FALSE(program.may_be_transparent());
}

TEST(ShaderProgram, diffuse_closure_reaches_the_bsdf) {
  GraphBuilder g;
  const int diffuse = g.node("ShaderNodeBsdfDiffuse",
                             {value_input("Color", Vec4(0.2f, 0.4f, 0.6f, 1)), value_input("Roughness", 0.0f)});
  g.graph.surface = {diffuse, "BSDF"};
  SurfaceShading shading;
  ShadingPoint point;
  point.wo = glm::normalize(Vec3(0.3f, 0.1f, 0.9f));
  compile(g.graph).evaluate_surface(point, shading);
  const Color f = shading.bsdf.f(point.wo, glm::normalize(Vec3(-0.2f, 0.5f, 0.7f)));
  EXPECT_NEAR(f.x, 0.2f * kInvPi, 1e-6f);
  EXPECT_NEAR(f.z, 0.6f * kInvPi, 1e-6f);
}

TEST(ShaderProgram, emission_code_does_not_contain_code_for_scattering) {
  GraphBuilder g;
  const int ray = varying_value(g);
  const int diffuse = g.node("ShaderNodeBsdfDiffuse", {linked_input("Color", ray, "Ray Length")});
  const int emission = g.node("ShaderNodeEmission", {value_input("Color", 1.0f), value_input("Strength", 2.0f)});
  const int add = g.node("ShaderNodeAddShader",
                         {linked_input("Shader", diffuse, "BSDF"), linked_input("Shader_001", emission, "Emission")});
  g.graph.surface = {add, "Shader"};
  const ShaderProgram program = compile(g.graph);
  EXPECT_FALSE(program.is_constant());
  EXPECT_TRUE(program.emission_is_constant());
}

TEST(ShaderProgram, a_color_that_is_linked_as_a_closure_is_emission) {
  GraphBuilder g;
  g.graph.surface = {g.node("ShaderNodeRGB", {}, {number_property("value", {1, 2, 3, 1})}), "Color"};
  EXPECT_FLOAT_EQ(compile(g.graph).evaluate_emission(ShadingPoint()).z, 3.0f);
}

// ---- Broken and unknown nodes ----------------------------------------------------------------

TEST(ShaderProgram, an_unknown_closure_is_replaced_by_diffuse_and_reported_once) {
  GraphBuilder g;
  const int unknown = g.node("ShaderNodeBsdfOfTheFuture", {value_input("Color", Vec4(1, 0, 0, 1))});
  const int mix = g.node("ShaderNodeAddShader",
                         {linked_input("Shader", unknown, "BSDF"), linked_input("Shader_001", unknown, "BSDF")});
  g.graph.surface = {mix, "Shader"};
  Diagnostics diagnostics;
  const ShaderProgram program = compile(g.graph, &diagnostics);
  compile(g.graph, &diagnostics);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_EQ(diagnostics[0].object, "Material");
  EXPECT_NE(diagnostics[0].message.find("ShaderNodeBsdfOfTheFuture"), std::string::npos);
  EXPECT_TRUE(program.scatters());
}

TEST(ShaderProgram, the_hair_model_of_huang_is_transparent_only_if_it_is_not_round) {
  for (const float aspect : {1.0f, 0.8f}) {
    GraphBuilder g;
    const int hair = g.node("ShaderNodeBsdfHairPrincipled", {value_input("Aspect Ratio", aspect)},
                            {text_property("model", "HUANG")});
    g.graph.surface = {hair, "BSDF"};
    Diagnostics diagnostics;
    const ShaderProgram program = compile(g.graph, &diagnostics);
    EXPECT_TRUE(diagnostics.empty());
    EXPECT_EQ(program.may_be_transparent(), aspect != 1.0f);
    EXPECT_EQ(program.view_dependence() == ShaderProgram::ViewDependence::Direction, aspect != 1.0f);
    ShadingPoint point;
    point.wo = point.ng = point.ns = Vec3(0, 0, 1);
    point.dpdu = Vec3(1, 0, 0);
    SurfaceShading shading;
    program.evaluate_surface(point, shading);
    ASSERT_EQ(shading.bsdf.lobe_count(), 1);
    EXPECT_EQ(shading.bsdf.lobe(0).kind, LobeKind::HairHuang);
  }
}

TEST(ShaderProgram, unknown_value_nodes_return_their_first_link) {
  GraphBuilder g;
  const int rgb = g.node("ShaderNodeRGB", {}, {number_property("value", {0.25f, 0.5f, 1, 1})});
  const int unknown = g.node("ShaderNodeFromTheFuture",
                             {value_input("Amount", 3.0f), linked_input("Thing", rgb, "Color")});
  g.emit(unknown, "Result");
  Diagnostics diagnostics;
  const Color e = compile(g.graph, &diagnostics).evaluate_emission(ShadingPoint());
  EXPECT_EQ(e, Color(0.25f, 0.5f, 1.0f));
  EXPECT_EQ(diagnostics.size(), 1u);
}

TEST(ShaderProgram, malformed_graphs_fall_back_without_crashing) {
  Diagnostics diagnostics;
  GraphBuilder loop;  // two Math nodes that are linked to each other
  loop.node("ShaderNodeMath", {linked_input("Value", 1, "Value"), value_input("Value_001", 1.0f)});
  loop.node("ShaderNodeMath", {linked_input("Value", 0, "Value"), value_input("Value_001", 1.0f)});
  loop.emit(0, "Value");
  EXPECT_TRUE(is_finite(compile(loop.graph, &diagnostics).evaluate_emission(ShadingPoint())));

  GraphBuilder closures;  // a Mix Shader that is linked to itself
  closures.node("ShaderNodeMixShader", {linked_input("Shader", 0, "Shader"), linked_input("Shader_001", 0, "Shader")});
  closures.graph.surface = {0, "Shader"};
  compile(closures.graph, &diagnostics);

  GraphBuilder dangling;
  dangling.node("ShaderNodeEmission", {linked_input("Color", 77, "Color"), {"Strength", {0, "Emission"}, Vec4(1.0f)}});
  dangling.graph.surface = {0, "Emission"};
  compile(dangling.graph, &diagnostics);
  dangling.graph.surface = {5, "Emission"};
  compile(dangling.graph, &diagnostics);

  GraphBuilder nan;
  nan.node("ShaderNodeEmission", {value_input("Color", NAN), value_input("Strength", INFINITY)});
  nan.graph.surface = {0, "Emission"};
  EXPECT_TRUE(is_finite(compile(nan.graph, &diagnostics).evaluate_emission(ShadingPoint())));
  EXPECT_GE(diagnostics.size(), 4u);
}

TEST(ShaderProgram, deep_graphs_are_computed_without_deep_recursion) {
  Diagnostics diagnostics;
  GraphBuilder chain;
  int last = chain.node("ShaderNodeLightPath");
  for (int i = 0; i < 20000; ++i)
    last = chain.node("ShaderNodeMath",
                      {linked_input("Value", last, i ? "Value" : "Ray Length"), value_input("Value_001", 1.0f)},
                      {text_property("operation", "ADD")});
  chain.emit(last, "Value");
  ShadingPoint point;
  point.ray_length = 3.0f;
  EXPECT_FLOAT_EQ(compile(chain.graph, &diagnostics).evaluate_emission(point).x, 20003.0f);
  EXPECT_TRUE(diagnostics.empty());

  // A loop at the end of the chain is cut as in a short graph.
  chain.graph.nodes[1].inputs[0] = linked_input("Value", last, "Value");
  EXPECT_TRUE(is_finite(compile(chain.graph, &diagnostics).evaluate_emission(point)));
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].message.find("is linked to itself"), std::string::npos);

  // Every second node compares its heights at three points.
  GraphBuilder bumps;
  last = bumps.node("ShaderNodeNewGeometry");
  for (int i = 0; i < 3000; ++i) {
    const int height = bumps.node(
        "ShaderNodeMath", {linked_input("Value", last, i ? "Normal" : "Position"), value_input("Value_001", 1.0f)});
    last = bumps.node("ShaderNodeBump", {linked_input("Height", height, "Value")});
  }
  bumps.emit(last, "Normal");
  diagnostics.clear();
  EXPECT_TRUE(is_finite(compile(bumps.graph, &diagnostics).evaluate_emission(point)));
  EXPECT_TRUE(diagnostics.empty());
}

TEST(ShaderProgram, many_paths_through_a_graph_cost_nothing) {
  GraphBuilder wide;  // every node uses the previous one twice: 2^60 paths through the graph
  int last = wide.node("ShaderNodeEmission", {value_input("Color", 1.0f), value_input("Strength", 1.0f)});
  for (int i = 0; i < 60; ++i)
    last = wide.node("ShaderNodeMixShader", {value_input("Fac", 0.5f), linked_input("Shader", last, "Shader"),
                                             linked_input("Shader_001", last, "Shader")});
  wide.graph.surface = {last, "Shader"};
  EXPECT_FLOAT_EQ(compile(wide.graph).evaluate_emission(ShadingPoint()).x, 1.0f);
}

TEST(ShaderProgram, ten_thousand_values_can_be_in_use_at_once) {
  // v_i = ray length + c_i. They are added in one order and, weighted, in the reverse order, so that all of them are in
  // use between the two sums.
  constexpr int kCount = 10000;
  GraphBuilder graph;
  const int ray = graph.node("ShaderNodeLightPath");
  std::vector<int> values;
  for (int i = 0; i < kCount; ++i)
    values.push_back(graph.node(
        "ShaderNodeMath", {linked_input("Value", ray, "Ray Length"), value_input("Value_001", 1e-3f * float(i + 1))},
        {text_property("operation", "MULTIPLY")}));
  const auto add = [&](int a, int b) {
    return graph.node("ShaderNodeMath", {linked_input("Value", a, "Value"), linked_input("Value_001", b, "Value")},
                      {text_property("operation", "ADD")});
  };
  int forwards = values.front(), backwards = values.back();
  for (int i = 1; i < kCount; ++i) forwards = add(forwards, values[size_t(i)]);
  for (int i = kCount - 2; i >= 0; --i) backwards = add(backwards, values[size_t(i)]);
  const int difference = graph.node(
      "ShaderNodeMath", {linked_input("Value", forwards, "Value"), linked_input("Value_001", backwards, "Value")},
      {text_property("operation", "DIVIDE")});
  graph.emit(difference, "Value");
  Diagnostics diagnostics;
  const ShaderProgram program = compile(graph.graph, &diagnostics);
  ShadingPoint point;
  for (const float length : {1.0f, 2.5f}) {
    point.ray_length = length;
    EXPECT_NEAR(program.evaluate_emission(point).x, 1.0f, 1e-4f);
    SurfaceShading shading;
    program.evaluate_surface(point, shading);
    EXPECT_NEAR(shading.emission.x, 1.0f, 1e-4f);
  }
  EXPECT_TRUE(diagnostics.empty());
}

TEST(ShaderProgram, a_long_program_uses_few_registers) {
  GraphBuilder graph;
  const int ray = graph.node("ShaderNodeLightPath");
  int last = ray;
  for (int i = 0; i < 900; ++i)
    last = graph.node("ShaderNodeMixRGB",
                      {value_input("Fac", 0.1f), linked_input("Color1", last, i ? "Color" : "Ray Length"),
                       linked_input("Color2", ray, "Ray Length")});
  graph.emit(last, "Color");
  Diagnostics diagnostics;
  ShadingPoint point;
  point.ray_length = 2.0f;
  const ShaderProgram program = compile(graph.graph, &diagnostics);
  EXPECT_NEAR(program.evaluate_emission(point).x, 2.0f, 1e-3f);
  EXPECT_GE(program.instruction_count(), 900);
  EXPECT_LE(program.register_count(), 16);
  EXPECT_TRUE(diagnostics.empty());
}

TEST(ShaderProgram, random_graphs_never_crash_and_never_give_nan) {
  static const char* kTypes[] = {"ShaderNodeMath",
                                 "ShaderNodeVectorMath",
                                 "ShaderNodeMixRGB",
                                 "ShaderNodeMix",
                                 "ShaderNodeMapping",
                                 "ShaderNodeTexChecker",
                                 "ShaderNodeTexImage",
                                 "ShaderNodeTexEnvironment",
                                 "ShaderNodeValToRGB",
                                 "ShaderNodeRGBCurve",
                                 "ShaderNodeMixShader",
                                 "ShaderNodeAddShader",
                                 "ShaderNodeBsdfPrincipled",
                                 "ShaderNodeBsdfGlass",
                                 "ShaderNodeEmission",
                                 "ShaderNodeBsdfTransparent",
                                 "ShaderNodeTexCoord",
                                 "ShaderNodeNewGeometry",
                                 "ShaderNodeHueSaturation",
                                 "ShaderNodeNormalMap",
                                 "ShaderNodeBump",
                                 "ShaderNodeNonsense",
                                 "ShaderNodeMapRange",
                                 "ShaderNodeBsdfDiffuse",
                                 "ShaderNodeBsdfAnisotropic",
                                 "ShaderNodeAttribute",
                                 "ShaderNodeBlackbody",
                                 "ShaderNodeTexNoise",
                                 "ShaderNodeTexMusgrave",
                                 "ShaderNodeTexVoronoi",
                                 "ShaderNodeTexWave",
                                 "ShaderNodeTexMagic",
                                 "ShaderNodeTexBrick",
                                 "ShaderNodeTexWhiteNoise",
                                 "ShaderNodeTexIES",
                                 "ShaderNodeWavelength",
                                 "ShaderNodeDisplacement",
                                 "ShaderNodeVectorDisplacement"};
  static const char* kSockets[] = {
      "Value",      "Value_001",   "Vector",   "Fac",          "Color",       "Color1",     "Color2",       "Shader",
      "Shader_001", "Base Color",  "Normal",   "Roughness",    "Alpha",       "Emission",   "Strength",     "IOR",
      "Tangent",    "Anisotropic", "Metallic", "Transmission", "Temperature", "Hue",        "Factor_Float", "A_Color",
      "Scale",      "Location",    "W",        "Detail",       "Lacunarity",  "Distortion", "Row Height",   "Exponent",
      "Height",     "Wavelength"};
  static const char* kOutputs[] = {"Value",  "Vector",       "Color",    "Fac",      "Alpha",
                                   "Shader", "BSDF",         "Emission", "Normal",   "Generated",
                                   "UV",     "Result_Color", "Result",   "Position", "Backfacing"};
  static const char* kOperations[] = {"ADD",    "DIVIDE",    "POWER",   "LOGARITHM", "TANGENT",
                                      "MODULO", "NORMALIZE", "REFRACT", "SINH",      "WRAP"};
  std::mt19937 rng(7);
  const auto pick = [&](const auto& list) { return std::string(list[rng() % std::size(list)]); };
  const auto value = [&]() -> float {
    switch (rng() % 8) {
      case 0: return NAN;
      case 1: return INFINITY;
      case 2: return 1e30f;
      case 3: return -3.0f;
      case 4: return 0.0f;
      default: return float(rng() % 1000) / 500.0f;
    }
  };
  for (int trial = 0; trial < 2000; ++trial) {
    GraphBuilder g;
    const int count = 1 + int(rng() % 12);
    for (int i = 0; i < count; ++i) {
      Node n;
      n.type = pick(kTypes);
      n.name = "n" + std::to_string(i);
      for (int k = int(rng() % 8); k > 0; --k) {
        NodeInput in{pick(kSockets), {}, Vec4(value(), value(), value(), value())};
        if (rng() % 2) in.link = {int(rng() % unsigned(count + 1)), pick(kOutputs)};
        n.inputs.push_back(in);
      }
      n.properties.push_back({"operation", pick(kOperations), {}});
      n.properties.push_back({"image", "", {value()}});
      if (rng() % 2) n.properties.push_back({"ramp", "", std::vector<float>(rng() % 20, value())});
      if (rng() % 2) n.properties.push_back({"curve", "", std::vector<float>(rng() % 20, value())});
      g.graph.nodes.push_back(n);
    }
    g.graph.surface = {int(rng() % unsigned(count)), pick(kOutputs)};
    const ShaderProgram program = compile(g.graph);
    ShadingPoint point;
    point.wo = glm::normalize(Vec3(float(rng() % 100) - 50.0f, 3.0f, 20.0f));
    point.ray_length = 2.0f;
    SurfaceShading shading;
    program.evaluate_surface(point, shading);
    EXPECT_TRUE(is_finite(shading.emission)) << trial << '\n' << program.listing();
    EXPECT_TRUE(is_finite(program.evaluate_transparency(point)));
    EXPECT_TRUE(std::isfinite(shading.holdout));
    const auto e = shading.bsdf.evaluate(point.wo, glm::normalize(Vec3(0.1f, 0.2f, 0.9f)));
    EXPECT_TRUE(is_finite(e.f_cos) && std::isfinite(e.pdf_solid_angle)) << trial << '\n' << program.listing();
  }
}

}  // namespace ajar::test_shader_program
