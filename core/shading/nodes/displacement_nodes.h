// Displacement, rendered as bump: the surface does not move; its normal is that of the displaced surface.
#pragma once

#include "shading/program/program_builder.h"

namespace ajar::nodes {

/// Sets the normal of the surface to that of the graph's displacement, if there is one. Call it before any other code
/// uses normals.
void add_displacement(ProgramBuilder& builder);

}  // namespace ajar::nodes
