// What surfaces that depend on the kind of the ray are, and that every technique renders them with the mean of path tracing.
#include "shading/ray_kind_surfaces.h"

#include "agreement.h"
#include "feature_scenes.h"
#include "gate.h"

namespace ajar::test_ray_kind_surfaces {

namespace {

using namespace fixtures;

NodeInput shader(const char* socket, int node) { return linked_input(socket, node, "BSDF"); }

/// A material with the node that `make` adds to the graph, which has a Light Path node, as its surface.
MaterialDescription material(const std::function<NodeLink(GraphBuilder&, int light_path)>& make) {
  GraphBuilder b;
  const int light_path = b.node("ShaderNodeLightPath", {});
  b.graph.surface = make(b, light_path);
  MaterialDescription result;
  result.graph = b.graph;
  return result;
}

/// Glass that lets shadow rays pass, as artists make window panes.
NodeLink pane(GraphBuilder& b, int light_path) {
  const int glass = b.node("ShaderNodeBsdfGlass", {value_input("Color", Vec4(1.0f)), value_input("Roughness", 0.0f),
                                                   value_input("IOR", 1.45f)}),
            transparent = b.node("ShaderNodeBsdfTransparent", {value_input("Color", Vec4(1.0f))});
  return {b.node("ShaderNodeMixShader", {linked_input("Fac", light_path, "Is Shadow Ray"), shader("Shader", glass),
                                         shader("Shader_001", transparent)}),
          "Shader"};
}

TEST(RayKindSurfaces, scattering_that_follows_the_light_path_is_found_and_emission_is_not) {
  const auto mix = [](GraphBuilder& b, int light_path, const char* one, const char* two) {
    const int first = b.node(one, {}), second = b.node(two, {});
    return NodeLink{b.node("ShaderNodeMixShader", {linked_input("Fac", light_path, "Is Camera Ray"),
                                                   shader("Shader", first), shader("Shader_001", second)}),
                    "Shader"};
  };
  const auto principled = [](GraphBuilder& b, int light_path, const char* socket) {
    const int twice = b.node("ShaderNodeMath",
                             {linked_input("Value", light_path, "Ray Depth"), value_input("Value_001", 2.0f)});
    return NodeLink{b.node("ShaderNodeBsdfPrincipled", {linked_input(socket, twice, "Value")}), "BSDF"};
  };
  struct Case {
    const char* what;
    RayKinds kinds;
    MaterialDescription material;
  };
  using B = GraphBuilder&;
  const Case cases[] = {
      {"a pane that casts no shadow", RayKinds::Shadow, material(pane)},
      {"a lamp that the camera does not see", RayKinds::All,
       material([&](B b, int p) { return mix(b, p, "ShaderNodeEmission", "ShaderNodeBsdfTransparent"); })},
      {"roughness by depth", RayKinds::All, material([&](B b, int p) { return principled(b, p, "Roughness"); })},
      {"strength of emission", RayKinds::None,
       material([&](B b, int p) { return principled(b, p, "Emission Strength"); })},
      {"two emissions", RayKinds::None,
       material([&](B b, int p) { return mix(b, p, "ShaderNodeEmission", "ShaderNodeEmission"); })},
      {"emission beside a surface", RayKinds::None, material([&](B b, int p) {
         const int diffuse = b.node("ShaderNodeBsdfDiffuse", {}),
                   emission = b.node("ShaderNodeEmission", {linked_input("Strength", p, "Is Camera Ray")});
         return NodeLink{b.node("ShaderNodeAddShader", {shader("Shader", diffuse), shader("Shader_001", emission)}),
                         "Shader"};
       })},
      {"a node that is not used", RayKinds::None, material([](B b, int) {
         return NodeLink{b.node("ShaderNodeBsdfDiffuse", {}), "BSDF"};
       })},
      {"no surface", RayKinds::None, material([](B, int) { return NodeLink{}; })}};
  for (const Case& c : cases) EXPECT_EQ(ray_kinds_of(c.material), c.kinds) << c.what;
}

TEST(RayKindSurfaces, transparent_parts_that_cast_shadows_are_found) {
  const auto made = [](float alpha, bool casts) {
    MaterialDescription m = material([&](GraphBuilder& b, int) {
      return NodeLink{b.node("ShaderNodeBsdfPrincipled", {value_input("Alpha", alpha)}), "BSDF"};
    });
    m.transparent_shadow = !casts;
    return m;
  };
  EXPECT_EQ(ray_kinds_of(made(0.5f, true)), RayKinds::Shadow);
  EXPECT_EQ(ray_kinds_of(made(0.5f, false)), RayKinds::None);
  EXPECT_EQ(ray_kinds_of(made(1.0f, true)), RayKinds::None);
}

TEST(RayKindSurfaces, a_graph_with_a_cycle_is_searched_once) {
  GraphBuilder b;
  const int mix = b.node("ShaderNodeMixShader", {});
  b.graph.nodes[size_t(mix)].inputs = {shader("Shader", mix), linked_input("Fac", mix, "Shader")};
  b.graph.surface = {mix, "Shader"};
  MaterialDescription m;
  m.graph = b.graph;
  EXPECT_EQ(ray_kinds_of(m), RayKinds::None);
}

TEST(RayKindSurfaces, a_very_long_chain_of_nodes_ends_the_search) {
  const auto chain = [](int length) {
    return material([&](GraphBuilder& b, int) {
      int last = b.node("ShaderNodeValue", {});
      for (int i = 0; i < length; ++i) last = b.node("ShaderNodeMath", {linked_input("Value", last, "Value")});
      return NodeLink{b.node("ShaderNodeBsdfDiffuse", {linked_input("Roughness", last, "Value")}), "BSDF"};
    });
  };
  EXPECT_EQ(ray_kinds_of(chain(1000)), RayKinds::None);
  EXPECT_EQ(ray_kinds_of(chain(1000000)), RayKinds::All) << "as if it were one: no stack is long enough";
}

/// A surface that is `one` for the rays for which this output of the Light Path node is 0, and `two` for the others.
int add_mix(SceneDescription& d, const char* output, const std::function<int(GraphBuilder&)>& one,
            const std::function<int(GraphBuilder&)>& two) {
  GraphBuilder b;
  const int light_path = b.node("ShaderNodeLightPath", {}), first = one(b), second = two(b);
  b.graph.surface = {b.node("ShaderNodeMixShader", {linked_input("Fac", light_path, output), shader("Shader", first),
                                                    shader("Shader_001", second)}),
                     "Shader"};
  return add_material(d, b);
}
std::function<int(GraphBuilder&)> closure(const char* type, Color color, float roughness = 0.0f) {
  return [=](GraphBuilder& b) {
    const int node = b.node(type, {value_input("Color", Vec4(color, 1.0f))});
    if (type != std::string("ShaderNodeBsdfTransparent") && type != std::string("ShaderNodeBsdfTranslucent"))
      b.graph.nodes[size_t(node)].inputs.push_back(value_input("Roughness", roughness));
    return node;
  };
}
const auto kClear = closure("ShaderNodeBsdfTransparent", Color(1.0f));

/// An emission shader.
int emission(GraphBuilder& b) { return b.node("ShaderNodeEmission", {value_input("Strength", 6.0f)}); }

std::vector<TransportScene> scenes() {
  std::vector<TransportScene> all;
  const auto add = [&](const char* name, const std::function<void(SceneDescription&)>& fill) {
    SceneDescription d = grey_room(9);
    fill(d);
    d.settings.photons = 1000;
    all.push_back({name, std::move(d)});
  };
  const LightDescription lamp = area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f);
  const Mat4 ball = moved(Vec3(0.2f, 0.3f, -0.5f), 0.4f), other_ball = moved(Vec3(-0.4f, 0.2f, -0.6f), 0.3f);
  const auto across = [](float height) { return moved(Vec3(0.0f, 0.0f, height)); };
  // All light of the lamp comes past the pane: by shadow rays that pass it, and by refraction.
  add("lamp_behind_a_pane", [&](SceneDescription& d) {
    const auto glass = closure("ShaderNodeBsdfGlass", Color(1.0f));
    add_object(d, plane(1.0f), add_mix(d, "Is Shadow Ray", glass, kClear), across(0.5f));
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
  });
  // A shade that lets a part of all rays pass, and more of the shadow rays.
  add("lamp_in_a_shade", [&](SceneDescription& d) {
    add_object(d, cube(),
               add_mix(d, "Is Shadow Ray", closure("ShaderNodeBsdfTranslucent", Color(0.9f, 0.8f, 0.6f)),
                       closure("ShaderNodeBsdfTransparent", Color(0.5f))),
               moved(Vec3(0.0f, 0.1f, 0.5f), 0.25f));
    d.lights.push_back(area_lamp(Vec3(0.0f, 0.1f, 0.5f), Vec3(0, 0, -1), 0.2f, 4.0f));
    d.lights.push_back(area_lamp(Vec3(0.7f, -0.5f, 0.9f), Vec3(0, 0, -1), 0.1f, 4.0f));
  });
  // The same for diffuse rays too: only walks from the eye go by way of it.
  add("lamp_in_an_eye_only_shade", [&](SceneDescription& d) {
    add_object(d, cube(),
               add_mix(d, "Is Diffuse Ray", closure("ShaderNodeBsdfTranslucent", Color(0.9f, 0.8f, 0.6f)),
                       closure("ShaderNodeBsdfTransparent", Color(0.5f))),
               moved(Vec3(0.0f, 0.1f, 0.5f), 0.25f));
    d.lights.push_back(area_lamp(Vec3(0.0f, 0.1f, 0.5f), Vec3(0, 0, -1), 0.2f, 4.0f));
    d.lights.push_back(area_lamp(Vec3(0.7f, -0.5f, 0.9f), Vec3(0, 0, -1), 0.1f, 4.0f));
  });
  add("colours_by_kind", [&](SceneDescription& d) {
    const auto diffuse = [](Color c) { return closure("ShaderNodeBsdfDiffuse", c); };
    add_object(d, plane(1.0f),
               add_mix(d, "Is Camera Ray", diffuse(Color(0.2f, 0.9f, 0.2f)), diffuse(Color(0.9f, 0.2f, 0.2f))),
               across(-0.95f));
    add_object(d, sphere(),
               add_mix(d, "Is Diffuse Ray", closure("ShaderNodeBsdfGlossy", Color(0.9f), 0.1f),
                       diffuse(Color(0.2f, 0.3f, 0.9f))),
               ball);
    add_object(d, sphere(), add_glossy(d, 0.0f), other_ball);
    d.lights.push_back(lamp);
  });
  add("net_without_transparent_shadows", [&](SceneDescription& d) {
    GraphBuilder b;
    b.graph.surface = {b.node("ShaderNodeBsdfPrincipled",
                              {value_input("Base Color", Vec4(0.8f, 0.5f, 0.3f, 1.0f)), value_input("Alpha", 0.4f)}),
                       "BSDF"};
    const int net = add_material(d, b);
    d.materials.back().transparent_shadow = false;
    add_object(d, plane(0.6f), net, across(0.3f));
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
  });
  // Only walks from the eye can pass it where it emits.
  add("emitter_that_the_camera_does_not_see", [&](SceneDescription& d) {
    add_object(d, plane(0.3f), add_mix(d, "Is Camera Ray", emission, kClear), moved(Vec3(0.1f, 0.4f, 0.0f)));
    add_object(d, sphere(), add_glossy(d, 0.2f), ball);
  });
  add("shade_in_fog", [&](SceneDescription& d) {
    add_object(d, cube(), add_mix(d, "Is Shadow Ray", closure("ShaderNodeBsdfTranslucent", Color(0.8f)), kClear),
               moved(Vec3(0.0f, 0.1f, 0.5f), 0.25f));
    add_object(d, cube(), add_medium(d, "ShaderNodeVolumeScatter", Color(0.8f), Vec2(0.5f)), moved(Vec3(0.0f), 0.9f));
    d.lights.push_back(area_lamp(Vec3(0.0f, 0.1f, 0.5f), Vec3(0, 0, -1), 0.2f, 8.0f));
  });
  add("roughness_by_depth_with_limits", [&](SceneDescription& d) {
    GraphBuilder b;
    const int path = b.node("ShaderNodeLightPath", {}),
              half = b.node("ShaderNodeMath",
                            {linked_input("Value", path, "Ray Depth"), value_input("Value_001", 0.5f)},
                            {text_property("operation", "MULTIPLY")});
    b.graph.surface = {
        b.node("ShaderNodeBsdfPrincipled", {value_input("Base Color", Vec4(0.8f, 0.6f, 0.4f, 1.0f)),
                                            linked_input("Metallic", half, "Value"), value_input("Roughness", 0.3f)}),
        "BSDF"};
    add_object(d, cube(), add_material(d, b), moved(Vec3(0.0f, 0.0f, -1.9f), 1.0f));
    add_object(d, sphere(), add_glass(d, 0.0f), ball);
    d.lights.push_back(lamp);
    d.settings.bounces = {5, 2, 2, 3, 8, 0};
  });
  return all;
}
const std::vector<TransportScene> kScenes = scenes();

class RayKindScene : public ::testing::TestWithParam<size_t> {};
INSTANTIATE_TEST_SUITE_P(In, RayKindScene, ::testing::Range<size_t>(0, kScenes.size()),
                         [](const auto& info) { return kScenes[info.param].name; });

/// All blocks, and the mean of the image so precisely that a bias of this size would show.
void expect_mean_of_path_tracing(const TransportScene& scene, const char* integrator, int samples, double visible) {
  expect_agreement(scene, integrator, samples, int(kScenes.size()), visible, 512);
}

TEST_P(RayKindScene, bidirectional_path_tracing_has_the_mean_of_path_tracing) {
  expect_mean_of_path_tracing(kScenes[GetParam()], "bdpt", 256, 0.03);
}
TEST_P(RayKindScene, energy_redistribution_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 1)) GTEST_SKIP() << kLeftOut;
  expect_mean_of_path_tracing(kScenes[GetParam()], "erpt", 256, 0.06);
}
TEST_P(RayKindScene, metropolis_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 0)) GTEST_SKIP() << kLeftOut;
  expect_mean_of_path_tracing(kScenes[GetParam()], "metropolis", 256, 0.06);
}
TEST_P(RayKindScene, population_monte_carlo_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 1)) GTEST_SKIP() << kLeftOut;
  expect_mean_of_path_tracing(kScenes[GetParam()], "pmc_pt", 256, 0.06);
}
TEST_P(RayKindScene, photon_mapping_has_the_mean_of_path_tracing) {
  expect_agreement_within_bias(kScenes[GetParam()], "photon_map", 0.02, 64);
}
TEST_P(RayKindScene, metropolis_photon_sampling_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 0)) GTEST_SKIP() << kLeftOut;
  expect_agreement_within_bias(kScenes[GetParam()], "mps", 0.03, 64);
}
TEST_P(RayKindScene, irradiance_caching_has_the_mean_of_path_tracing) {
  if (is_left_out(GetParam(), 1)) GTEST_SKIP() << kLeftOut;
  expect_agreement_within_bias(kScenes[GetParam()], "irradiance_cache", 0.03);
}

// Light samples past a pane, and rays that hit the lamp past it, find other light. Their weights define how much of it
// is seen: those of the power heuristic, as in Cycles. A guide must not move weight from one to the other. In bdpt, light
// past the pane has these weights in weight_past_ray_kinds.
TEST(RayKindSurfaces, light_of_a_large_lamp_past_a_pane_has_the_weights_of_the_power_heuristic) {
  SceneDescription d = kScenes[0].description;
  d.lights[0] = area_lamp(Vec3(0.0f, 0.0f, 0.95f), Vec3(0, 0, -1), 1.7f, 8.0f);
  const RunningMoments plain = whole(d, "path", 512, 16, 100), joined = whole(d, "bdpt", 256, 16, 200);
  d.settings.guiding = Guiding::On;
  const RunningMoments guided = whole(d, "path", 512, 16, 300);
  for (const RunningMoments& other : {joined, guided}) {
    const double visible = 4.8 * std::sqrt(plain.variance_of_mean() + other.variance_of_mean()) / plain.mean();
    EXPECT_LT(visible, 0.02) << "inconclusive";
    EXPECT_TRUE(statistical::means_agree(plain, other)) << plain.mean() << " and " << other.mean();
  }
}

}  // namespace

}  // namespace ajar::test_ray_kind_surfaces
