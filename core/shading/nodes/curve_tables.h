// The baked ramps and curves of a node, as tables of the program.
#pragma once

#include "shading/program/program_builder.h"

namespace ajar::nodes {

/// Index of the node's `ramp` or `curve`. Returns false, with a report, if the node has none.
bool ramp_table(ProgramBuilder& builder, int node, uint32_t& table);
bool curve_table(ProgramBuilder& builder, int node, uint32_t& table);

}  // namespace ajar::nodes
