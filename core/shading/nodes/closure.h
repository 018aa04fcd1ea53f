// One closure of a shader graph: its kind and the sources of its inputs.
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
  Metallic,
  Sheen,
  PrincipledHair,
  HairReflection,
  HairTransmission,
  RayPortal,
  Emission,
  CoatedEmission,  ///< emission below the coat and the sheen of a Principled BSDF
  Holdout
};

/// Clamps an input, or a channel of one, to the range in which closures are defined, as Cycles does. Node graphs can
/// compute any value; values that are not finite become 0.
inline float valid_input(float x, float low, float high) { return std::isfinite(x) ? glm::clamp(x, low, high) : 0.0f; }

/// Copies `count` floats from registers into the closure's inputs before use, clamped to the valid range.
struct InputPatch {
  InputPatch(size_t offset, uint8_t count, Operand from);
  uint16_t offset;  ///< bytes into PrincipledInputs
  uint8_t count;
  Operand from;
  float low = -std::numeric_limits<float>::max(), high = std::numeric_limits<float>::max();
};

/// A closure with its constant inputs. All kinds use the inputs of the Principled BSDF. The simple kinds use
/// base_color, roughness, ior, anisotropic, anisotropic_rotation, distribution and the thin film. Emission has its
/// strength in base_color. The closures of hair are listed in hair_closures.cpp. A ray portal has its place in
/// clearcoat_normal and its direction in tangent.
struct Closure {
  ClosureKind kind = ClosureKind::Diffuse;
  Operand weight = 0;
  Operand normal = kNoOperand, coat_normal = kNoOperand, tangent = kNoOperand;  ///< kNoOperand: that of the surface
  closures::PrincipledInputs inputs;
  std::vector<InputPatch> patches;
};

std::string_view name_of(ClosureKind kind);

/// Clamps the constant inputs to the range in which closures are defined.
void make_valid(closures::PrincipledInputs& inputs);

}  // namespace ajar
