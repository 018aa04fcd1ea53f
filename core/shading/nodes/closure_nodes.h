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

/// All closures below the graph's surface output. Each closure occurs once; its weight is the product of the mix factors
/// above it, summed over all paths of links that lead to it. Closures with a constant weight of 0 are left out.
std::vector<Closure> flatten_closures(ProgramBuilder& builder);

}  // namespace ajar::nodes
