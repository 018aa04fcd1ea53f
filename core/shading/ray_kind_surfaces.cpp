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
    bool visited = false, scatters = false, follows_path = false;
  };

  /// A shader. Emission may follow the path: paths from the eye find all of it.
  Found shader(const NodeLink& link, int depth = 0) {
    if (link.node < 0 || size_t(link.node) >= graph_.nodes.size()) return {};
    if (depth > kMaxDepth) return {true, true, true};
    Found& found = shaders_[size_t(link.node)];
    if (found.visited) return found;
    found.visited = true;
    const Node& node = graph_.nodes[size_t(link.node)];
    if (node.type == "ShaderNodeEmission" || node.type == "ShaderNodeBackground") return found;
    const bool joins = node.type == "ShaderNodeMixShader" || node.type == "ShaderNodeAddShader";
    Found result{true, !joins, false};
    bool by_number = false;
    for (const NodeInput& input : node.inputs) {
      if (joins && input.socket.starts_with("Shader")) {
        const Found part = shader(input.link, depth + 1);
        result.scatters |= part.scatters;
        result.follows_path |= part.follows_path;
      } else if (!input.socket.starts_with("Emission")) {  // of Principled BSDF
        by_number |= value(input.link, depth + 1);
      }
    }
    result.follows_path |= result.scatters && by_number;
    return shaders_[size_t(link.node)] = result;
  }

 private:
  static constexpr int kMaxDepth = 4096;  ///< of nodes one behind the other; behind that, a Light Path is assumed
  /// Whether a number or colour follows the path.
  bool value(const NodeLink& link, int depth) {
    if (link.node < 0 || size_t(link.node) >= graph_.nodes.size()) return false;
    if (depth > kMaxDepth) return true;
    Found& found = values_[size_t(link.node)];
    if (found.visited) return found.follows_path;
    found.visited = true;
    const Node& node = graph_.nodes[size_t(link.node)];
    const bool follows = node.type == "ShaderNodeLightPath" ||
                         std::any_of(node.inputs.begin(), node.inputs.end(),
                                     [&](const NodeInput& input) { return value(input.link, depth + 1); });
    values_[size_t(link.node)].follows_path = follows;
    return follows;
  }

  const NodeGraph& graph_;
  std::vector<Found> shaders_, values_;
};

}  // namespace

bool depends_on_ray_kind(const MaterialDescription& material) {
  const std::vector<Node>& nodes = material.graph.nodes;
  const auto is_transparent = [](const Node& node) {
    if (node.type == "ShaderNodeBsdfTransparent") return true;
    return node.type == "ShaderNodeBsdfPrincipled" &&
           std::any_of(node.inputs.begin(), node.inputs.end(), [](const NodeInput& input) {
             return input.socket == "Alpha" && (input.link.node >= 0 || input.value.x < 1.0f);
           });
  };
  if (!material.transparent_shadow && std::any_of(nodes.begin(), nodes.end(), is_transparent)) return true;
  return LightPathSearch(material.graph).shader(material.graph.surface).follows_path;
}

}  // namespace ajar
