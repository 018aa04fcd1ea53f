// A tree of mixed closures, flattened: each closure once, with the product of the mix factors above it
// as its weight (summed when several ways lead to it). Closures whose weight is the constant 0 do not appear.
#pragma once

#include <cmath>
#include <functional>
#include <limits>

#include "shading/closures.h"
#include "shading/program_builder.h"

namespace ajar {

enum class ClosureKind : uint8_t {
  Diffuse, Glossy, Glass, Refraction, Translucent, Principled, Velvet, ToonDiffuse, ToonGlossy, Subsurface, Transparent, Emission, Holdout
};

/// An input, or a channel of one, in the range in which closures are defined, as Cycles does; what is no finite number is 0. Node graphs can
/// compute anything.
inline float valid_input(float x, float low, float high) { return std::isfinite(x) ? glm::clamp(x, low, high) : 0.0f; }

/// Copy `count` floats from registers into the closure's inputs before use, made valid.
struct InputPatch {
  InputPatch(size_t offset, uint8_t count, Operand from);
  uint16_t offset;   ///< bytes into PrincipledInputs
  uint8_t count;
  Operand from;
  float low = -std::numeric_limits<float>::max(), high = std::numeric_limits<float>::max();
};

/// A closure with its constant inputs filled in. All kinds share the Principled inputs: the simple ones use base_color,
/// roughness, ior, anisotropic, anisotropic_rotation and distribution; emission has its strength in base_color.
struct Closure {
  ClosureKind kind = ClosureKind::Diffuse;
  Operand weight = 0;
  Operand normal = kNoOperand, coat_normal = kNoOperand, tangent = kNoOperand;  ///< none: the surface's own
  closures::PrincipledInputs inputs;
  std::vector<InputPatch> patches;
};

bool is_closure_type(std::string_view node_type);

/// Calls `visit` for every node below `root` (the `what` output) that is neither a mix nor a sum, with the output socket if it is a value.
using ClosureVisitor = std::function<void(int node, const std::string& output, Value weight)>;
void for_each_closure(ProgramBuilder& builder, const NodeLink& root, const char* what, const ClosureVisitor& visit);

/// All closures under the graph's surface output.
std::vector<Closure> flatten_closures(ProgramBuilder& builder);

std::string_view name_of(ClosureKind kind);

}  // namespace ajar
