// A tree of mixed closures, flattened: each closure once, with the product of the mix factors above it
// as its weight (summed when several ways lead to it). Closures whose weight is the constant 0 do not appear.
#pragma once

#include <vector>

#include "shading/nodes/closure.h"

namespace ajar {

/// All closures under the graph's surface output.
std::vector<Closure> flatten_closures(ProgramBuilder& builder);

}  // namespace ajar
