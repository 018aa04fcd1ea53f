// A shader as a list of instructions over a file of float registers.
//
// An operand is an integer. If it is >= 0, it is the index of a register. If it is < 0, it is a constant with the index
// -1 - operand. Vectors and colours are three consecutive floats, results of textures four. So component i has the
// operand of the whole plus i (minus i for constants).
//
// While a program is built, each value has registers of its own, and operands are ready before they are read.
// register_allocation.h then assigns registers that several values use one after the other.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "description/scene_description.h"
#include "math/types.h"
#include "shading/bsdf/shading_point.h"
#include "shading/functions/bump.h"
#include "shading/functions/color_functions.h"
#include "shading/functions/ies.h"
#include "shading/functions/patterns.h"
#include "shading/images/texture.h"
#include "shading/skies/sky.h"

namespace ajar {

using Operand = int32_t;
constexpr Operand kNoOperand = INT32_MAX;
constexpr int kMaxWidth = 8;  ///< maximum number of floats that one instruction writes

/// The operand of component `i` of a vector operand.
constexpr Operand component(Operand vector, int i) { return Operand(vector >= 0 ? vector + i : vector - i); }

// Name, number of floats written, depends on the shading point. Instructions that do not depend on the point are folded
// if their operands are constant.
// clang-format off
#define AJAR_SHADER_OPS(OP)                                                                                           \
  OP(Splat, 3, false) OP(Luminance, 1, false) OP(Average, 1, false) OP(Combine, 3, false)                             \
  OP(Saturate, 1, false) OP(SaturateColor, 3, false) OP(Product, 1, false) OP(ProductInverse, 1, false)               \
  OP(Sum, 1, false) OP(Scale, 3, false)                                                                               \
  OP(Math, 1, false) OP(VectorMath, 3, false) OP(VectorMathValue, 1, false)                                           \
  OP(MixFloat, 1, false) OP(MixVector, 3, false) OP(MixVectorNonUniform, 3, false) OP(MixColor, 3, false)             \
  OP(Clamp, 1, false) OP(MapRange, 1, false) OP(MapRangeVector, 3, false)                                             \
  OP(Mapping, 3, false) OP(Affine, 3, false) OP(VectorRotate, 3, false) OP(Normalize, 3, false)                       \
  OP(Invert, 3, false) OP(Gamma, 3, false) OP(BrightContrast, 3, false) OP(HueSaturation, 3, false)                   \
  OP(CombineColor, 3, false) OP(SeparateColor, 3, false) OP(Blackbody, 3, false)                                      \
  OP(Ramp, 4, false) OP(Curve, 3, false) OP(FloatCurve, 1, false)                                                     \
  OP(Checker, 1, false) OP(SelectColor, 3, false) OP(Gradient, 1, false)                                              \
  OP(Noise, 1, false) OP(NoiseColor, 3, false) OP(WhiteNoise, 3, false) OP(Voronoi, 8, false)                         \
  OP(Wave, 1, false) OP(Magic, 3, false) OP(Brick, 2, false) OP(Wavelength, 3, false) OP(Sky, 3, false)               \
  OP(Ies, 1, false) OP(Gabor, 3, false) OP(RadialTiling, 6, false)                                                    \
  OP(Image, 4, false) OP(ImageBox, 4, true) OP(Environment, 4, false) OP(ImageOver, 4, true) OP(ImageBoxOver, 4, true)  \
  OP(ProjectSphere, 3, false) OP(ProjectTube, 3, false)                                                               \
  OP(Position, 3, true) OP(ShadingNormal, 3, true) OP(TrueNormal, 3, true) OP(Incoming, 3, true)                      \
  OP(Parametric, 3, true) OP(Backfacing, 1, true) OP(RadialTangent, 3, true) OP(UvTangent, 3, true)                   \
  OP(Generated, 3, true) OP(ObjectPosition, 3, true) OP(TransformPosition, 3, true) OP(ObjectNormal, 3, true)         \
  OP(CameraPosition, 3, true) OP(WindowPosition, 3, true) OP(Reflection, 3, true)                                     \
  OP(ActiveUv, 3, true) OP(NamedUv, 3, true) OP(NamedAttribute, 4, true)                                              \
  OP(ObjectLocation, 3, true) OP(ObjectColor, 4, true) OP(ObjectIndex, 1, true) OP(ObjectRandom, 1, true)             \
  OP(ObjectProperty, 4, true) OP(FromInstancer, 3, true) OP(ObjectIncoming, 3, true)                                      \
  OP(LightPath, 1, true) OP(LightFalloff, 1, true) OP(Fresnel, 1, true) OP(LayerWeight, 1, true)                      \
  OP(NormalMap, 3, true) OP(VectorTransform, 3, true) OP(Wireframe, 1, true) OP(HairInfo, 1, true)                    \
  OP(HairTangentNormal, 3, true) OP(PointInfo, 3, true) OP(AmbientOcclusion, 1, true) OP(Bevel, 3, true) OP(Raycast, 6, true)                \
  OP(RaycastAttribute, 4, true)                                                                                       \
  OP(Bump, 3, true) OP(Displacement, 3, true) OP(VectorDisplacement, 3, true)
// clang-format on

enum class Op : uint8_t {
#define AJAR_OP(name, width, needs_point) name,
  AJAR_SHADER_OPS(AJAR_OP)
#undef AJAR_OP
};

struct OpInfo {
  const char* name;
  uint8_t width;
  bool needs_point;
};
const OpInfo& info(Op op);
/// Returns true if the instruction reads a position on the surface, so that it can also be evaluated beside the point.
bool can_shift(Op op);

/// Where an instruction is evaluated. Bump mapping compares the height at the point with the heights beside it, at
/// a distance for each Filter Width.
enum class Shift : uint8_t { None, X, Y };
inline constexpr size_t kMostShifts = 1 + 2 * BumpFootprint::kMostWidths;
/// The same place at the distance of another Filter Width.
constexpr Shift at_width(Shift shift, int width) {
  return shift == Shift::None ? shift : Shift(int(shift) + 2 * width);
}

/// One step. `variant` selects an operation within the family (a blend type, an output of Light Path). `data` is an
/// index into the lists of tables, textures, names or matrices, or holds packed flags.
struct Instruction {
  Op op = Op::Splat;
  uint8_t variant = 0;
  Shift shift = Shift::None;
  Operand out = 0;
  std::array<Operand, 6> in{kNoOperand, kNoOperand, kNoOperand, kNoOperand, kNoOperand, kNoOperand};
  uint32_t data = 0;
};

/// Added to the variant of NamedAttribute: a surface has no attribute of this name.
inline constexpr int kOfVolumesAlone = 4;

/// All data to which instructions refer.
struct ProgramTables {
  std::vector<float> constants;
  std::vector<CurveTable> curves;
  std::vector<ImageLookup> images;
  std::vector<nodes::Sky> skies;
  std::vector<nodes::IesProfile> ies_profiles;
  std::vector<std::string> names;
  std::vector<Mat4> matrices;
  BumpFootprint bump;
};

/// Executes `count` instructions. `registers` need not be initialised.
void run(const Instruction* code, size_t count, const ProgramTables& tables, const ShadingPoint& point,
         float* registers);

/// The same for a point inside a volume. There is no surface beside it, so there is no bump mapping.
void run_inside(const Instruction* code, size_t count, const ProgramTables& tables, const ShadingPoint& point,
                float* registers);

inline const float* operand(Operand o, const float* registers, const float* constants) {
  return o >= 0 ? registers + o : constants + (-1 - o);
}
inline Vec3 load3(const float* p) { return {p[0], p[1], p[2]}; }

}  // namespace ajar
