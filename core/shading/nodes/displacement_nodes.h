// The displacement of a material: a vector by which vertices move, or a normal that shows it as bump.
#pragma once

#include "shading/program/program_builder.h"

namespace ajar::nodes {

/// The displacement in world space. Its type is Closure, and its operand kNoOperand, if the graph has none.
Value displacement_vector(ProgramBuilder& builder);
/// The normal that the displaced surface would have, or the normal of the surface if there is no displacement. Call it
/// before any other code uses normals.
Value displaced_normal(ProgramBuilder& builder);

}  // namespace ajar::nodes
