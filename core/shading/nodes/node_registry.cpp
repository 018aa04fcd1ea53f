#include "shading/nodes/node_registry.h"

#include <unordered_map>

#include "shading/nodes/closure_nodes.h"
#include "shading/nodes/closure_tree.h"
#include "shading/nodes/volume_closures.h"

namespace ajar {

NodeFunction find_value_node(std::string_view type) {
  static const std::unordered_map<std::string_view, NodeFunction> all = [] {
    std::unordered_map<std::string_view, NodeFunction> map;
    for (const auto family : {nodes::input_nodes(), nodes::texture_nodes(), nodes::pattern_nodes(), nodes::math_nodes(),
                              nodes::vector_nodes(), nodes::color_nodes(), nodes::displacement_nodes()})
      for (const NodeType& node : family) map.emplace(node.name, node.function);
    return map;
  }();
  const auto found = all.find(type);
  return found == all.end() ? nullptr : found->second;
}

const NodeCatalog& node_catalog() {
  static constexpr NodeCatalog kCatalog{find_value_node, [](std::string_view type) {
                                          return is_branch(type) || is_volume_node(type) ||
                                                 nodes::find_closure_node(type) != nullptr;
                                        }};
  return kCatalog;
}

}  // namespace ajar
