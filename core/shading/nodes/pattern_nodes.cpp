// Procedural textures: Noise, Musgrave, White Noise, Voronoi, Wave, Magic, Brick, Gabor. Their scalar inputs are packed three
// to a vector, so that each of them can be linked without more operands per instruction.
#include "shading/functions/noise.h"
#include "shading/functions/patterns.h"
#include "shading/functions/voronoi.h"
#include "shading/nodes/node_type.h"

namespace ajar::nodes {
namespace {

using enum SocketType;

/// Inputs shared by the texture nodes: the position (generated coordinates unless linked) and W, both multiplied by
/// Scale.
class TextureInputs {
 public:
  TextureInputs(ProgramBuilder& builder, int node) : b_(builder), node_(node) {}

  Value number(const char* socket, float fallback) { return b_.input(node_, socket, Float, Vec4(fallback)); }
  Value scale() { return number("Scale", 5.0f); }
  Value place() {
    const Value p = b_.place(node_, Op::Generated);
    return b_.emit(Op::Scale, Vector, {p, scale()});
  }
  Value w() { return b_.emit(Op::Product, Float, {number("W", 0.0f), scale()}); }
  Value three(Value x, Value y, Value z) { return b_.emit(Op::Combine, Vector, {x, y, z}); }
  bool has(std::string_view socket) const {
    for (const NodeInput& input : b_.node(node_).inputs)
      if (input.socket == socket) return true;
    return false;
  }

 private:
  ProgramBuilder& b_;
  int node_;
};

int dimensions(ProgramBuilder& b, int node, std::string_view property) {
  return b.choice(node, property, {"1D", "2D", "3D", "4D"}, 2);
}

int fractal(ProgramBuilder& b, int node, std::string_view property) {
  return b.choice(node, property,
                  {"MULTIFRACTAL", "FBM", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN"}, 1);
}

bool noise_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  TextureInputs in(b, node);
  const bool first = !in.has("Lacunarity");  // Blender before 4.0
  const bool normalize = first || b.number(node, "normalize", 1.0f) != 0.0f;
  const int variant = dimensions(b, node, "noise_dimensions") | fractal(b, node, "noise_type") << 2 |
                      int(normalize) << 5;
  const bool has_color = b.is_read(node, "Color");
  value = b.emit(has_color ? Op::NoiseColor : Op::Noise, has_color ? Color : Float,
                 {in.place(), in.w(),
                  in.three(in.number("Detail", 2.0f), in.number("Roughness", 0.5f), in.number("Lacunarity", 2.0f)),
                  in.three(in.number("Offset", 0.0f), in.number("Gain", 1.0f), in.number("Distortion", 0.0f))},
                 variant, uint32_t(first ? NoiseGeneration::First : NoiseGeneration::Second));
  if (has_color && output == "Fac") value = b.part(value, 0);
  return output == "Fac" || output == "Color";
}

bool musgrave_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  TextureInputs in(b, node);
  value = b.emit(Op::Noise, Float,
                 {in.place(), in.w(),
                  in.three(in.number("Detail", 2.0f), in.number("Dimension", 2.0f), in.number("Lacunarity", 2.0f)),
                  in.three(in.number("Offset", 0.0f), in.number("Gain", 1.0f), b.constant(0.0f))},
                 dimensions(b, node, "musgrave_dimensions") | fractal(b, node, "musgrave_type") << 2,
                 uint32_t(NoiseGeneration::Musgrave));
  return output == "Fac";
}

bool white_noise_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  TextureInputs in(b, node);
  value = b.emit(Op::WhiteNoise, Color, {b.input(node, "Vector", Vector), in.number("W", 0.0f)},
                 dimensions(b, node, "noise_dimensions") + 1);
  if (output == "Value") value = b.part(value, 0);
  return output == "Value" || output == "Color";
}

bool voronoi_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  TextureInputs in(b, node);
  const int feature = b.choice(node, "feature", {"F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"});
  const int metric = b.choice(node, "distance", {"EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI"});
  const bool first = !in.has("Lacunarity");  // Blender before 4.0
  const VoronoiGeneration generation = first                            ? VoronoiGeneration::First
                                       : b.text(node, "cells") == "PCG" ? VoronoiGeneration::Third
                                                                        : VoronoiGeneration::Second;
  const int normalize = !first && b.number(node, "normalize") != 0.0f ? 1 : 0;
  const Value whole = b.emit(
      Op::Voronoi, Vector,
      {in.place(), in.w(), in.scale(),
       in.three(in.number("Smoothness", 1.0f), in.number("Exponent", 0.5f), in.number("Randomness", 1.0f)),
       in.three(in.number("Detail", 0.0f), in.number("Roughness", 0.5f), in.number("Lacunarity", 2.0f))},
      dimensions(b, node, "voronoi_dimensions") | feature << 2 | metric << 5 | normalize << 7, uint32_t(generation));
  if (output == "Distance" || output == "Radius")
    value = b.part(whole, 0);
  else if (output == "Color")
    value = {Color, component(whole.at, 1)};
  else if (output == "Position")
    value = {Vector, component(whole.at, 4)};
  else if (output == "W")
    value = b.part(whole, 7);
  else
    return false;
  return true;
}

bool wave_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  TextureInputs in(b, node);
  const int rings = b.choice(node, "wave_type", {"BANDS", "RINGS"});
  const int axis = rings ? b.choice(node, "rings_direction", {"X", "Y", "Z", "SPHERICAL"})
                         : b.choice(node, "bands_direction", {"X", "Y", "Z", "DIAGONAL"});
  value = b.emit(
      Op::Wave, Float,
      {in.place(), in.three(in.number("Distortion", 0.0f), in.number("Detail", 2.0f), in.number("Detail Scale", 1.0f)),
       in.three(in.number("Detail Roughness", 0.5f), in.number("Phase Offset", 0.0f), b.constant(0.0f))},
      rings | axis << 1 | b.choice(node, "wave_profile", {"SIN", "SAW", "TRI"}) << 3);
  return output == "Fac" || output == "Color";
}

bool magic_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  TextureInputs in(b, node);
  const Value p = b.place(node, Op::Generated);
  value = b.emit(Op::Magic, Color, {p, in.scale(), in.number("Distortion", 1.0f)},
                 int(glm::clamp(b.number(node, "turbulence_depth", 2.0f), 0.0f, 10.0f)));
  if (output == "Fac") value = b.convert({Vector, value.at}, Float);
  return output == "Fac" || output == "Color";
}

bool brick_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  TextureInputs in(b, node);
  const auto frequency = [&](const char* property) {
    return uint32_t(glm::clamp(b.number(node, property, 2.0f), 0.0f, 99.0f));
  };
  const Value whole = b.emit(
      Op::Brick, Vector,
      {in.place(), in.three(in.number("Mortar Size", 0.02f), in.number("Mortar Smooth", 0.1f), in.number("Bias", 0.0f)),
       in.three(in.number("Brick Width", 0.5f), in.number("Row Height", 0.25f), b.constant(0.0f)),
       b.constant(Vec3(b.number(node, "offset", 0.5f), b.number(node, "squash", 1.0f), 0.0f), Vector)},
      0, frequency("offset_frequency") | frequency("squash_frequency") << 16);
  const Value tint = b.part(whole, 0), mortar = b.part(whole, 1);
  value = mortar;
  if (output == "Color") {
    const auto color = [&](const char* socket, float fallback) { return b.input(node, socket, Color, Vec4(fallback)); };
    const Value stone = b.emit(Op::MixVector, Color, {tint, color("Color1", 0.8f), color("Color2", 0.2f)});
    value = b.emit(Op::MixVector, Color, {mortar, stone, color("Mortar", 0.0f)});
  }
  return output == "Fac" || output == "Color";
}

bool gabor_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  TextureInputs in(b, node);
  const Value direction = b.input(node, "Orientation 3D", Vector, Vec4(1.414214f, 1.414214f, 0.0f, 0.0f));
  const Value whole = b.emit(
      Op::Gabor, Vector,
      {in.place(),
       in.three(in.number("Frequency", 2.0f), in.number("Anisotropy", 1.0f), in.number("Orientation 2D", 0.25f * kPi)),
       direction},
      b.choice(node, "gabor_type", {"2D", "3D"}) + 2);
  const int part = output == "Value" ? 0 : output == "Phase" ? 1 : output == "Intensity" ? 2 : -1;
  if (part >= 0) value = b.part(whole, part);
  return part >= 0;
}

constexpr NodeType kNodes[] = {
    {"ShaderNodeTexNoise", noise_texture},
    {"ShaderNodeTexMusgrave", musgrave_texture},
    {"ShaderNodeTexWhiteNoise", white_noise_texture},
    {"ShaderNodeTexVoronoi", voronoi_texture},
    {"ShaderNodeTexWave", wave_texture},
    {"ShaderNodeTexMagic", magic_texture},
    {"ShaderNodeTexBrick", brick_texture},
    {"ShaderNodeTexGabor", gabor_texture},
};

}  // namespace

std::span<const NodeType> pattern_nodes() { return kNodes; }

}  // namespace ajar::nodes
