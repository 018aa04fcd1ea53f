// Small node graphs for tests, in the form in which the exporter sends them.
#pragma once

#include <initializer_list>

#include "description/scene_description.h"
#include "shading/images/texture.h"
#include "shading/shader_program.h"

namespace ajar::fixtures {

struct GraphBuilder {
  NodeGraph graph;

  int node(const std::string& type, std::initializer_list<NodeInput> inputs = {},
           std::initializer_list<NodeProperty> properties = {}) {
    Node n;
    n.type = type;
    n.name = type.substr(std::min<size_t>(type.size(), 10)) + " " + std::to_string(graph.nodes.size());
    n.inputs = inputs;
    n.properties = properties;
    graph.nodes.push_back(n);
    return int(graph.nodes.size()) - 1;
  }
  /// Makes the surface emit the value of this socket, so that a test can read it as radiance.
  void emit(int from, const std::string& socket) {
    const int emission = node("ShaderNodeEmission",
                              {{"Color", {from, socket}, Vec4(0.0f)}, {"Strength", {}, Vec4(1.0f)}});
    graph.surface = {emission, "Emission"};
  }
};

inline NodeInput value_input(const std::string& socket, Vec4 value) { return {socket, {}, value}; }
inline NodeInput value_input(const std::string& socket, float value) { return {socket, {}, Vec4(value)}; }
inline NodeInput linked_input(const std::string& socket, int node, const std::string& output) {
  return {socket, {node, output}, Vec4(0.0f)};
}
inline NodeProperty text_property(const std::string& name, const std::string& text) { return {name, text, {}}; }
inline NodeProperty number_property(const std::string& name, std::vector<float> numbers) { return {name, "", numbers}; }

inline ShaderProgram compile(const NodeGraph& graph, Diagnostics* diagnostics = nullptr,
                             TextureStore* textures = nullptr, const ShaderContext& context = {}) {
  static TextureStore none({});  // must outlive the program, which can refer to its magenta image
  Diagnostics ignored;
  return ShaderProgram::compile(graph, "Material", textures ? *textures : none, diagnostics ? *diagnostics : ignored,
                                context);
}

}  // namespace ajar::fixtures
