// The functions that compile each node type. A family of nodes is one file in nodes/, which lists its nodes.
//
// To add a node, write its function in the file of similar nodes and add it to the table of that file. If no
// instruction does what the node needs, add an Op with its arithmetic in register_program, and a pure function that it
// calls.
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

/// Returns null for a type that is not a known value node.
NodeFunction find_value_node(std::string_view type);
/// The catalogue of all node types.
const NodeCatalog& node_catalog();

}  // namespace ajar
