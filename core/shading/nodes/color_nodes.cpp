// Colour nodes: mixing, ramps, curves, corrections, separating and combining.
#include "shading/functions/color_functions.h"
#include "shading/nodes/curve_tables.h"
#include "shading/nodes/node_type.h"

namespace ajar::nodes {
namespace {

using enum SocketType;

int blend_mode(ProgramBuilder& b, int node) {
  return b.choice(
      node, "blend_type",
      {"MIX", "DARKEN", "MULTIPLY", "BURN", "LIGHTEN", "SCREEN", "DODGE", "ADD", "OVERLAY", "SOFT_LIGHT",
       "LINEAR_LIGHT", "DIFFERENCE", "EXCLUSION", "SUBTRACT", "DIVIDE", "HUE", "SATURATION", "COLOR", "VALUE"});
}

/// A plain mix whose factor is a constant 0 or 1 uses only one of its inputs.
bool one_side(ProgramBuilder& b, Value t, int& side) {
  if (!t.is_constant()) return false;
  const float constant = b.constant_value(t);
  side = constant == 1.0f ? 1 : 0;
  return constant == 0.0f || constant == 1.0f;
}

bool mix_rgb(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value t = b.clamped(b.input(node, "Fac", Float, Vec4(0.5f)));
  const int mode = blend_mode(b, node);
  const char* sockets[2] = {"Color1", "Color2"};
  int side;
  if (mode == int(Blend::Mix) && one_side(b, t, side))
    value = b.input(node, sockets[side], Color, Vec4(0.5f));
  else
    value = b.emit(Op::MixColor, Color,
                   {t, b.input(node, "Color1", Color, Vec4(0.5f)), b.input(node, "Color2", Color, Vec4(0.5f))}, mode);
  if (b.number(node, "use_clamp") != 0.0f) value = b.clamped(value);
  return output == "Color";
}

bool mix_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const bool clamp_factor = b.number(node, "clamp_factor", 1.0f) != 0.0f;
  const bool non_uniform = output == "Result_Vector" && b.choice(node, "factor_mode", {"UNIFORM", "NON_UNIFORM"}) == 1;
  Value t = non_uniform ? b.input(node, "Factor_Vector", Vector, Vec4(0.5f))
                        : b.input(node, "Factor_Float", Float, Vec4(0.5f));
  if (clamp_factor) t = b.clamped(t);
  const bool is_color = output == "Result_Color";
  const int mode = is_color ? blend_mode(b, node) : int(Blend::Mix);
  const SocketType type = is_color ? Color : output == "Result_Vector" ? Vector : Float;
  const std::string suffix = is_color ? "Color" : type == Vector ? "Vector" : "Float";
  const Vec4 fallback(is_color ? 0.5f : 0.0f);
  const auto side_value = [&](int side) { return b.input(node, (side ? "B_" : "A_") + suffix, type, fallback); };
  int side;
  if (mode == int(Blend::Mix) && !non_uniform && one_side(b, t, side))
    value = side_value(side);
  else if (is_color)
    value = b.emit(Op::MixColor, type, {t, side_value(0), side_value(1)}, mode);
  else
    value = b.emit(type == Float ? Op::MixFloat
                   : non_uniform ? Op::MixVectorNonUniform
                                 : Op::MixVector,
                   type, {t, side_value(0), side_value(1)});
  if (is_color && b.number(node, "clamp_result") != 0.0f) value = b.clamped(value);
  return is_color || output == "Result_Vector" || output == "Result_Float";
}

bool color_ramp(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value t = b.input(node, "Fac", Float, Vec4(0.5f));
  uint32_t table;
  if (!ramp_table(b, node, table)) {
    value = t;
    return true;
  }
  const Value whole = b.emit(Op::Ramp, Color, {t}, 0, table);
  value = output == "Alpha" ? b.part(whole, 3) : whole;
  return output == "Color" || output == "Alpha";
}

bool rgb_curves(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value in = b.input(node, "Color", Color, Vec4(1.0f));
  uint32_t table;
  value = curve_table(b, node, table)
              ? b.emit(Op::Curve, Color, {b.input(node, "Fac", Float, Vec4(1.0f)), in}, 0, table)
              : in;
  return output == "Color";
}

bool invert_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = b.emit(Op::Invert, Color, {b.input(node, "Fac", Float, Vec4(1.0f)), b.input(node, "Color", Color)});
  return output == "Color";
}

bool gamma_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = b.emit(Op::Gamma, Color,
                 {b.input(node, "Color", Color, Vec4(1.0f)), b.input(node, "Gamma", Float, Vec4(1.0f))});
  return output == "Color";
}

bool bright_contrast_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = b.emit(
      Op::BrightContrast, Color,
      {b.input(node, "Color", Color, Vec4(1.0f)), b.input(node, "Bright", Float), b.input(node, "Contrast", Float)});
  return output == "Color";
}

bool hue_saturation_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const auto in = [&](const char* socket, float fallback) { return b.input(node, socket, Float, Vec4(fallback)); };
  value = b.emit(Op::HueSaturation, Color,
                 {in("Hue", 0.5f), in("Saturation", 1.0f), in("Value", 1.0f), in("Fac", 1.0f),
                  b.input(node, "Color", Color, Vec4(0.8f))});
  return output == "Color";
}

Value combined(ProgramBuilder& b, int node, ColorModel model, const char* x, const char* y, const char* z) {
  const Value c = b.emit(Op::Combine, Color,
                         {b.input(node, x, Float), b.input(node, y, Float), b.input(node, z, Float)});
  return model == ColorModel::Rgb ? c : b.emit(Op::CombineColor, Color, {c}, int(model));
}

bool separated(ProgramBuilder& b, int node, ColorModel model, const char* socket, std::string_view output,
               std::array<std::string_view, 3> outputs, Value& value) {
  for (int i = 0; i < 3; ++i) {
    if (output != outputs[i]) continue;
    Value c = b.input(node, socket, Color, Vec4(0.8f));
    if (model != ColorModel::Rgb) c = b.emit(Op::SeparateColor, Color, {c}, int(model));
    value = b.part(c, i);
    return true;
  }
  return false;
}

ColorModel color_model(ProgramBuilder& b, int node) {
  return ColorModel(b.choice(node, "mode", {"RGB", "HSV", "HSL"}));
}

bool combine_color(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = combined(b, node, color_model(b, node), "Red", "Green", "Blue");
  return output == "Color";
}
bool combine_rgb(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = combined(b, node, ColorModel::Rgb, "R", "G", "B");
  return output == "Image";
}
bool combine_hsv(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = combined(b, node, ColorModel::Hsv, "H", "S", "V");
  return output == "Color";
}
bool separate_color(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  return separated(b, node, color_model(b, node), "Color", output, {"Red", "Green", "Blue"}, value);
}
bool separate_rgb(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  return separated(b, node, ColorModel::Rgb, "Image", output, {"R", "G", "B"}, value);
}
bool separate_hsv(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  return separated(b, node, ColorModel::Hsv, "Color", output, {"H", "S", "V"}, value);
}

bool rgb_to_bw(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = b.convert(b.input(node, "Color", Color, Vec4(0.5f)), Float);
  return output == "Val";
}

bool blackbody_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = b.spectral(Op::Blackbody, b.input(node, "Temperature", Float, Vec4(1500.0f)));
  return output == "Color";
}

bool wavelength_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = b.spectral(Op::Wavelength, b.input(node, "Wavelength", Float, Vec4(500.0f)));
  return output == "Color";
}

constexpr NodeType kNodes[] = {
    {"ShaderNodeMixRGB", mix_rgb},
    {"ShaderNodeMix", mix_node},
    {"ShaderNodeValToRGB", color_ramp},
    {"ShaderNodeRGBCurve", rgb_curves},
    {"ShaderNodeInvert", invert_node},
    {"ShaderNodeGamma", gamma_node},
    {"ShaderNodeBrightContrast", bright_contrast_node},
    {"ShaderNodeHueSaturation", hue_saturation_node},
    {"ShaderNodeCombineColor", combine_color},
    {"ShaderNodeCombineRGB", combine_rgb},
    {"ShaderNodeCombineHSV", combine_hsv},
    {"ShaderNodeSeparateColor", separate_color},
    {"ShaderNodeSeparateRGB", separate_rgb},
    {"ShaderNodeSeparateHSV", separate_hsv},
    {"ShaderNodeRGBToBW", rgb_to_bw},
    {"ShaderNodeBlackbody", blackbody_node},
    {"ShaderNodeWavelength", wavelength_node},
};

}  // namespace

std::span<const NodeType> color_nodes() { return kNodes; }

}  // namespace ajar::nodes
