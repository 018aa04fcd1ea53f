// Materials that treat kinds of rays differently: only path tracing renders them, and the artist is told.
#include "scene/path_tracing_only.h"

#include "agreement.h"
#include "render/session.h"

namespace ajar::test_path_tracing_only {

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

/// A room whose lamp is behind a closed pane.
SceneDescription lamp_behind_a_pane() {
  SceneDescription d = grey_room(16);
  GraphBuilder b;
  b.graph.surface = pane(b, b.node("ShaderNodeLightPath", {}));
  add_object(d, cube(true), add_material(d, b), moved(Vec3(0.0f, 0.0f, 0.6f), 0.3f));
  d.lights.push_back(area_lamp(Vec3(0.0f, 0.0f, 0.7f), Vec3(0, 0, -1), 0.2f, 20.0f));
  return d;
}

TEST(PathTracingOnly, scattering_that_follows_the_light_path_is_found_and_emission_is_not) {
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
    bool found;
    MaterialDescription material;
  };
  using B = GraphBuilder&;
  const Case cases[] = {
      {"a pane that casts no shadow", true, material(pane)},
      {"a lamp that the camera does not see", true,
       material([&](B b, int p) { return mix(b, p, "ShaderNodeEmission", "ShaderNodeBsdfTransparent"); })},
      {"roughness by depth", true, material([&](B b, int p) { return principled(b, p, "Roughness"); })},
      {"strength of emission", false, material([&](B b, int p) { return principled(b, p, "Emission Strength"); })},
      {"two emissions", false,
       material([&](B b, int p) { return mix(b, p, "ShaderNodeEmission", "ShaderNodeEmission"); })},
      {"emission beside a surface", false, material([&](B b, int p) {
         const int diffuse = b.node("ShaderNodeBsdfDiffuse", {}),
                   emission = b.node("ShaderNodeEmission", {linked_input("Strength", p, "Is Camera Ray")});
         return NodeLink{b.node("ShaderNodeAddShader", {shader("Shader", diffuse), shader("Shader_001", emission)}),
                         "Shader"};
       })},
      {"a node that is not used", false, material([](B b, int) {
         return NodeLink{b.node("ShaderNodeBsdfDiffuse", {}), "BSDF"};
       })},
      {"no surface", false, material([](B, int) { return NodeLink{}; })}};
  for (const Case& c : cases) EXPECT_EQ(depends_on_ray_kind(c.material), c.found) << c.what;
}

TEST(PathTracingOnly, transparent_parts_that_cast_shadows_are_found) {
  const auto made = [](float alpha, bool casts) {
    MaterialDescription m = material([&](GraphBuilder& b, int) {
      return NodeLink{b.node("ShaderNodeBsdfPrincipled", {value_input("Alpha", alpha)}), "BSDF"};
    });
    m.transparent_shadow = !casts;
    return m;
  };
  EXPECT_TRUE(depends_on_ray_kind(made(0.5f, true)));
  EXPECT_FALSE(depends_on_ray_kind(made(0.5f, false)));
  EXPECT_FALSE(depends_on_ray_kind(made(1.0f, true)));
}

TEST(PathTracingOnly, a_graph_with_a_cycle_is_searched_once) {
  GraphBuilder b;
  const int mix = b.node("ShaderNodeMixShader", {});
  b.graph.nodes[size_t(mix)].inputs = {shader("Shader", mix), linked_input("Fac", mix, "Shader")};
  b.graph.surface = {mix, "Shader"};
  MaterialDescription m;
  m.graph = b.graph;
  EXPECT_FALSE(depends_on_ray_kind(m));
}

TEST(PathTracingOnly, a_very_long_chain_of_nodes_ends_the_search) {
  const auto chain = [](int length) {
    return material([&](GraphBuilder& b, int) {
      int last = b.node("ShaderNodeValue", {});
      for (int i = 0; i < length; ++i) last = b.node("ShaderNodeMath", {linked_input("Value", last, "Value")});
      return NodeLink{b.node("ShaderNodeBsdfDiffuse", {linked_input("Roughness", last, "Value")}), "BSDF"};
    });
  };
  EXPECT_FALSE(depends_on_ray_kind(chain(1000)));
  EXPECT_TRUE(depends_on_ray_kind(chain(1000000))) << "as if it were one: no stack is long enough";
}

TEST(PathTracingOnly, auto_measures_whether_a_guide_pays) {
  Session session;
  session.start(with(lamp_behind_a_pane(), "auto", 20));
  ASSERT_TRUE(session.wait(kHang));
  EXPECT_NE(session.statistics_json().find("a measurement during the render decides"), std::string::npos);
}

TEST(PathTracingOnly, light_through_panes_is_that_of_path_tracing_in_all_techniques) {
  const std::vector<float> expected = render(lamp_behind_a_pane(), "path", 16, 3);
  for (const char* technique : {"bdpt", "erpt", "photon_map", "auto"}) {
    Session session;
    SceneDescription d = with(lamp_behind_a_pane(), technique, 16);
    d.settings.seed = 3;
    session.start(std::move(d));
    ASSERT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.snapshot("Combined"), expected) << technique;
    const std::string told = session.statistics_json();
    EXPECT_NE(told.find("surfaces that follow the Light Path node"), std::string::npos) << technique;
    // Again with the scene that is built.
    d = with(lamp_behind_a_pane(), technique, 16);
    d.settings.seed = 3;
    session.change_view(d.camera, d.settings);
    ASSERT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.snapshot("Combined"), expected) << technique;
  }
}

}  // namespace

}  // namespace ajar::test_path_tracing_only
