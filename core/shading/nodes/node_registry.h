// Which function compiles which node type. A node family is one file under nodes/, which lists its own.
//
// To add a node: write its function beside its relatives and name it in that file's table; if no instruction does what
// it needs, add an Op with its arithmetic in register_program and a pure function it calls.
#pragma once

#include <span>
#include <string_view>

#include "shading/nodes/node_type.h"

namespace ajar {

namespace nodes {
std::span<const NodeType> input_nodes();
std::span<const NodeType> texture_nodes();
std::span<const NodeType> pattern_nodes();
std::span<const NodeType> math_nodes();
std::span<const NodeType> vector_nodes();
std::span<const NodeType> color_nodes();
std::span<const NodeType> displacement_nodes();
}  // namespace nodes

/// Null for a type that is not a value node we know.
NodeFunction find_value_node(std::string_view type);
/// All node types there are.
const NodeCatalog& node_catalog();

}  // namespace ajar
