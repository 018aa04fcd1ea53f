// One closure of a shader graph: its kind, and where its inputs come from.
#pragma once

#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "shading/bsdf/closures.h"
#include "shading/program/program_builder.h"

namespace ajar {

enum class ClosureKind : uint8_t {
  Diffuse,
  Glossy,
  Glass,
  Refraction,
  Translucent,
  Principled,
  Velvet,
  ToonDiffuse,
  ToonGlossy,
  Subsurface,
  Transparent,
  Emission,
  Holdout
};

/// An input, or a channel of one, in the range in which closures are defined, as Cycles does; what is no finite number
/// is 0. Node graphs can compute anything.
inline float valid_input(float x, float low, float high) { return std::isfinite(x) ? glm::clamp(x, low, high) : 0.0f; }

/// Copy `count` floats from registers into the closure's inputs before use, made valid.
struct InputPatch {
  InputPatch(size_t offset, uint8_t count, Operand from);
  uint16_t offset;  ///< bytes into PrincipledInputs
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

std::string_view name_of(ClosureKind kind);

/// Brings the constant inputs into the range in which closures are defined.
void make_valid(closures::PrincipledInputs& inputs);

}  // namespace ajar
