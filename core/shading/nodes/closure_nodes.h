// Closure nodes: the closures that each shader node contributes, and the sources of their inputs.
#pragma once

#include "shading/nodes/closure.h"

namespace ajar::nodes {

using ClosureFunction = void (*)(ProgramBuilder& builder, int node, Value weight, std::vector<Closure>& closures);

/// Returns null for a type that is not a known closure.
ClosureFunction find_closure_node(std::string_view type);

/// Appends the closures that `node` contributes at a closure socket. A value node emits its `output`. An unknown node
/// becomes diffuse and is reported.
void add_closures(ProgramBuilder& builder, int node, const std::string& output, Value weight,
                  std::vector<Closure>& closures);

}  // namespace ajar::nodes
