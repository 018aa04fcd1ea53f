// The mix and add nodes between a shader graph's output and its closures.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "shading/program/program_builder.h"

namespace ajar {

/// Is it a Mix Shader or an Add Shader?
bool is_branch(std::string_view node_type);

/// Calls `visit` for every node below `root` (the `what` output) that is neither a mix nor a sum, with the output
/// socket if it is a value.
using ClosureVisitor = std::function<void(int node, const std::string& output, Value weight)>;
void for_each_closure(ProgramBuilder& builder, const NodeLink& root, const char* what, const ClosureVisitor& visit);

}  // namespace ajar
