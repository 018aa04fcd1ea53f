// The closures of a tree of mixes, as a list. Each closure occurs once; its weight is the product of the mix factors
// above it, summed over all paths of links that lead to it. Closures with a constant weight of 0 are left out.
#pragma once

#include <vector>

#include "shading/nodes/closure.h"

namespace ajar {

/// All closures below the graph's surface output.
std::vector<Closure> flatten_closures(ProgramBuilder& builder);

}  // namespace ajar
