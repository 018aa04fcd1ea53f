// Interprets arbitrary bytes as a shader graph of existing nodes with arbitrary links and numbers. The graph must
// compile, and it must evaluate to valid numbers.
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "graph_fixtures.h"
#include "shading/bsdf/shading_point.h"
#include "shading/nodes/node_registry.h"

using namespace ajar;

namespace {

constexpr const char* kShaders[] = {"ShaderNodeBsdfDiffuse",      "ShaderNodeBsdfGlossy",
                                    "ShaderNodeBsdfGlass",        "ShaderNodeBsdfRefraction",
                                    "ShaderNodeBsdfTranslucent",  "ShaderNodeBsdfTransparent",
                                    "ShaderNodeBsdfPrincipled",   "ShaderNodeBsdfAnisotropic",
                                    "ShaderNodeBsdfMetallic",     "ShaderNodeSubsurfaceScattering",
                                    "ShaderNodeBsdfSheen",        "ShaderNodeEmission",
                                    "ShaderNodeBackground",       "ShaderNodeMixShader",
                                    "ShaderNodeAddShader",        "ShaderNodeHoldout",
                                    "ShaderNodeNotANode",         "ShaderNodeVolumeScatter",
                                    "ShaderNodeVolumeAbsorption", "ShaderNodeVolumePrincipled",
                                    "ShaderNodeBsdfHair",         "ShaderNodeBsdfHairPrincipled",
                                    "ShaderNodeBsdfRayPortal"};
constexpr const char* kSockets[] = {"Color",
                                    "Color1",
                                    "Color2",
                                    "Fac",
                                    "Value",
                                    "Value_001",
                                    "Vector",
                                    "Vector_001",
                                    "Normal",
                                    "Roughness",
                                    "Strength",
                                    "Shader",
                                    "Shader_001",
                                    "BSDF",
                                    "Emission",
                                    "Scale",
                                    "Detail",
                                    "Base Color",
                                    "IOR",
                                    "Offset",
                                    "Melanin",
                                    "Absorption Coefficient",
                                    "Height",
                                    "Result",
                                    "Image",
                                    "A",
                                    "B",
                                    "Factor",
                                    "UV",
                                    "Generated",
                                    "Alpha",
                                    "Metallic",
                                    "Transmission",
                                    "Anisotropic",
                                    "Tangent",
                                    "Distance",
                                    "Volume",
                                    "Density",
                                    "Anisotropy",
                                    "Emission Strength",
                                    "Blackbody Intensity",
                                    "Temperature",
                                    "Position",
                                    "Direction",
                                    "Length",
                                    "Attribute_1",
                                    "Attribute_1_Alpha",
                                    ""};
constexpr const char* kTexts[] = {"GGX",
                                  "BECKMANN",
                                  "MULTI_GGX",
                                  "SHARP",
                                  "ADD",
                                  "DIVIDE",
                                  "POWER",
                                  "MODULO",
                                  "SINE",
                                  "NORMALIZE",
                                  "MIX",
                                  "HUE",
                                  "F1",
                                  "SMOOTH_F1",
                                  "N_SPHERE_RADIUS",
                                  "3D",
                                  "4D",
                                  "1D",
                                  "RGB",
                                  "HSV",
                                  "VECTOR",
                                  "LINEAR",
                                  "HOSEK_WILKIE",
                                  "NISHITA",
                                  "PREETHAM",
                                  "SINGLE_SCATTERING",
                                  "MULTIPLE_SCATTERING",
                                  "TILT=NONE\n1 1 1 2 1 1 1 1 1 1 1 1 1 0 90 0 5 7"};
constexpr const char* kProperties[] = {"operation",
                                       "distribution",
                                       "blend_type",
                                       "data_type",
                                       "feature",
                                       "dimensions",
                                       "noise_dimensions",
                                       "voronoi_dimensions",
                                       "mode",
                                       "sky_type",
                                       "curves",
                                       "color_ramp",
                                       "image",
                                       "attribute",
                                       "uv_map",
                                       "value",
                                       "invert",
                                       "samples",
                                       "ies"};

struct Bytes {
  const uint8_t *at, *end;
  uint8_t byte() { return at < end ? *at++ : uint8_t(0); }
  template <size_t N>
  const char* one_of(const char* const (&list)[N]) {
    return list[byte() % N];
  }
  float number() {
    constexpr float kOdd[] = {0.0f, 1.0f, -1.0f, 0.5f, 1e-30f, 1e30f, -1e30f, NAN, INFINITY, 1e-7f, 3.0f, 100.0f};
    const uint8_t kind = byte();
    if (kind < 200) return kOdd[kind % std::size(kOdd)];
    uint32_t bits = 0;
    for (int i = 0; i < 4; ++i) bits = bits << 8 | byte();
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
};

std::vector<std::string> value_nodes() {
  std::vector<std::string> names;
  for (const auto list : {nodes::input_nodes(), nodes::texture_nodes(), nodes::pattern_nodes(), nodes::math_nodes(),
                          nodes::vector_nodes(), nodes::color_nodes(), nodes::displacement_nodes()})
    for (const NodeType& type : list) names.emplace_back(type.name);
  return names;
}

void check(bool fine) {
  if (!fine) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::vector<std::string> kValueNodes = value_nodes();
  Bytes in{data, data + size};
  NodeGraph graph;
  const int count = 1 + in.byte() % 16;
  for (int i = 0; i < count; ++i) {
    Node node;
    const uint8_t type = in.byte();
    node.type = type < 80 ? std::string(kShaders[type % std::size(kShaders)]) : kValueNodes[type % kValueNodes.size()];
    node.name = "Node " + std::to_string(i);
    for (int k = in.byte() % 6; k > 0; --k) {
      NodeInput input;
      input.socket = in.one_of(kSockets);
      const uint8_t link = in.byte();
      if (link > 100)
        input.link = {int(link % (count + 2)) - 1,
                      in.one_of(kSockets)};  // can be a link to itself, a cycle, or an invalid link
      input.value = Vec4(in.number(), in.number(), in.number(), in.number());
      node.inputs.push_back(input);
    }
    for (int k = in.byte() % 4; k > 0; --k) {
      NodeProperty property{in.one_of(kProperties), in.one_of(kTexts), {}};
      for (int n = in.byte() % 12; n > 0; --n) property.numbers.push_back(in.number());
      node.properties.push_back(property);
    }
    graph.nodes.push_back(node);
  }
  graph.surface = {int(in.byte() % (count + 1)), in.one_of(kSockets)};
  graph.displacement = {int(in.byte() % (count + 2)) - 1, in.one_of(kSockets)};
  graph.volume = {int(in.byte() % (count + 2)) - 1, in.one_of(kSockets)};
  const ShaderProgram program = fixtures::compile(graph);
  ShadingPoint point;
  SurfaceShading shading;
  program.evaluate_surface(point, shading);
  const Color emission = program.evaluate_emission(point), transparency = program.evaluate_transparency(point);
  (void)emission, (void)transparency;  // NaN inputs may give NaN, which the film refuses and counts
  if (!shading.bsdf.empty()) {
    const auto sample = shading.bsdf.sample(Vec3(0, 0, 1), 0.3f, Vec2(0.4f, 0.7f));
    if (sample) check(!(sample->pdf_solid_angle < 0.0f));
  }
  point.primitive = kInsideVolume;
  MediumPoint medium;
  program.add_medium(point, medium);
  for (int c = 0; c < 3; ++c)
    check(std::isfinite(medium.extinction[c]) && std::isfinite(medium.emission[c]) && medium.emission[c] >= 0.0f &&
          medium.scattering[c] >= 0.0f && medium.extinction[c] >= medium.scattering[c]);
  check(program.instruction_count() >= 0);
  program.listing();
  return 0;
}
