// The closures of hair: Principled Hair BSDF and Hair BSDF.
#pragma once

#include "shading/bsdf/shading_point.h"
#include "shading/nodes/closure.h"

namespace ajar::nodes {

void hair(ProgramBuilder& builder, int node, Value weight, std::vector<Closure>& closures);
void principled_hair(ProgramBuilder& builder, int node, Value weight, std::vector<Closure>& closures);

/// Adds the lobes at a point. `has_tangent`: the tangent of the inputs replaces that of the fibre. On a mesh, the fibre
/// runs along an edge of the triangle, as in Cycles.
void add_hair(Bsdf& bsdf, const ShadingPoint& point, bool transmission, Color weight,
              const closures::PrincipledInputs& inputs, bool has_tangent);
void add_principled_hair(Bsdf& bsdf, const ShadingPoint& point, Color weight, const closures::PrincipledInputs& inputs);

}  // namespace ajar::nodes
