// Closure nodes: which closures a shader node stands for and where their inputs come from.
#pragma once

#include "shading/nodes/closure.h"

namespace ajar::nodes {

using ClosureFunction = void (*)(ProgramBuilder& builder, int node, Value weight, std::vector<Closure>& closures);

/// Null for a type that is not a closure we know.
ClosureFunction find_closure_node(std::string_view type);

/// Append what `node` contributes at a closure socket. A value node emits its `output`; an unknown one
/// becomes diffuse and is reported.
void add_closures(ProgramBuilder& builder, int node, const std::string& output, Value weight,
                  std::vector<Closure>& closures);

}  // namespace ajar::nodes
