// Inputs and settings that the compiler ignores although it knows the node, with the messages that the artist gets if
// one of them is used.
#pragma once

#include "shading/program/program_builder.h"

namespace ajar::nodes {

/// Reports each unsupported input or setting of `node` that is linked or does not have its neutral value.
void report_unsupported_settings(ProgramBuilder& builder, int node);

}  // namespace ajar::nodes
