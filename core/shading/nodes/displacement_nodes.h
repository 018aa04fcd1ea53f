// Displacement, shown as bump: the surface stays where it is and its normal is that of the displaced one.
#pragma once

#include "shading/program/program_builder.h"

namespace ajar::nodes {

/// Make the graph's displacement, if any, the surface's normal. Before anything else asks for normals.
void add_displacement(ProgramBuilder& builder);

}  // namespace ajar::nodes
