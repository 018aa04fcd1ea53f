// Inputs and settings of nodes that the compiler does not follow although it knows the node: what the artist is told
// where one asks for something.
#pragma once

#include "shading/program/program_builder.h"

namespace ajar::nodes {

/// Reports each unsupported input or setting of `node` that is linked or is not at the value that asks for nothing.
void report_unsupported_settings(ProgramBuilder& builder, int node);

}  // namespace ajar::nodes
