#include "shading/ray_kind_surfaces.h"

#include <algorithm>
#include <vector>

namespace ajar {

namespace {

/// Which nodes of a graph need a Light Path node, and which of its shaders scatter light. Each node is visited once;
/// an exporter of broken files may write a cycle.
class LightPathSearch {
 public:
  explicit LightPathSearch(const NodeGraph& graph)
      : graph_(graph), shaders_(graph.nodes.size()), values_(graph.nodes.size()) {}

  struct Found {
    bool visited = false, scatters = false;
    RayKinds kinds = RayKinds::None;
  };

  /// A shader. Emission may follow the path: paths from the eye find all of it.
  Found shader(const NodeLink& link, int depth = 0) {
    if (link.node < 0 || size_t(link.node) >= graph_.nodes.size()) return {};
    if (depth > kMaxDepth) return {true, true, RayKinds::All};
    Found& found = shaders_[size_t(link.node)];
    if (found.visited) return found;
    found.visited = true;
    const Node& node = graph_.nodes[size_t(link.node)];
    if (node.type == "ShaderNodeEmission" || node.type == "ShaderNodeBackground") return found;
    const bool joins = node.type == "ShaderNodeMixShader" || node.type == "ShaderNodeAddShader";
    Found result{true, !joins, RayKinds::None};
    RayKinds of_values = RayKinds::None;
    for (const NodeInput& input : node.inputs) {
      if (joins && input.socket.starts_with("Shader")) {
        const Found part = shader(input.link, depth + 1);
        result.scatters |= part.scatters;
        result.kinds = std::max(result.kinds, part.kinds);
      } else if (!input.socket.starts_with("Emission")) {  // of Principled BSDF
        of_values = std::max(of_values, value(input.link, depth + 1));
      }
    }
    if (result.scatters) result.kinds = std::max(result.kinds, of_values);
    return shaders_[size_t(link.node)] = result;
  }

 private:
  static constexpr int kMaxDepth = 4096;  ///< of nodes one behind the other; behind that, a Light Path is assumed
  /// Of a number or colour.
  RayKinds value(const NodeLink& link, int depth) {
    if (link.node < 0 || size_t(link.node) >= graph_.nodes.size()) return RayKinds::None;
    if (depth > kMaxDepth) return RayKinds::All;
    const Node& node = graph_.nodes[size_t(link.node)];
    if (node.type == "ShaderNodeLightPath") return link.socket == "Is Shadow Ray" ? RayKinds::Shadow : RayKinds::All;
    Found& found = values_[size_t(link.node)];
    if (found.visited) return found.kinds;
    found.visited = true;
    RayKinds kinds = RayKinds::None;
    for (const NodeInput& input : node.inputs) kinds = std::max(kinds, value(input.link, depth + 1));
    return values_[size_t(link.node)].kinds = kinds;
  }

  const NodeGraph& graph_;
  std::vector<Found> shaders_, values_;
};

}  // namespace

RayKinds ray_kinds_of(const MaterialDescription& material) {
  const std::vector<Node>& nodes = material.graph.nodes;
  const auto is_transparent = [](const Node& node) {
    if (node.type == "ShaderNodeBsdfTransparent") return true;
    return node.type == "ShaderNodeBsdfPrincipled" &&
           std::any_of(node.inputs.begin(), node.inputs.end(), [](const NodeInput& input) {
             return input.socket == "Alpha" && (input.link.node >= 0 || input.value.x < 1.0f);
           });
  };
  const bool blocks = !material.transparent_shadow && std::any_of(nodes.begin(), nodes.end(), is_transparent);
  return std::max(blocks ? RayKinds::Shadow : RayKinds::None,
                  LightPathSearch(material.graph).shader(material.graph.surface).kinds);
}

}  // namespace ajar
