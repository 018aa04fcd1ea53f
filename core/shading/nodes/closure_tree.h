// The mix and add nodes between the output of a shader graph and its closures.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "shading/program/program_builder.h"

namespace ajar {

/// Returns true for a Mix Shader or an Add Shader.
bool is_branch(std::string_view node_type);

/// Calls `visit` for every node below `root` that is neither a mix nor an add node. If the node is a value, `output` is
/// its output socket. `what` is the name of the root output, for messages.
using ClosureVisitor = std::function<void(int node, const std::string& output, Value weight)>;
void for_each_closure(ProgramBuilder& builder, const NodeLink& root, const char* what, const ClosureVisitor& visit);

}  // namespace ajar
