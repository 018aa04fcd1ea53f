// Converter nodes for numbers: Math, Clamp, Map Range, Float Curve.
#include "shading/functions/math_functions.h"
#include "shading/nodes/curve_tables.h"
#include "shading/nodes/node_type.h"

namespace ajar::nodes {
namespace {

using enum SocketType;

bool math_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int operation = b.choice(
      node, "operation",
      {"ADD",          "SUBTRACT",     "MULTIPLY", "DIVIDE",     "MULTIPLY_ADD",   "POWER",     "LOGARITHM",
       "SQRT",         "INVERSE_SQRT", "ABSOLUTE", "EXPONENT",   "MINIMUM",        "MAXIMUM",   "LESS_THAN",
       "GREATER_THAN", "SIGN",         "COMPARE",  "SMOOTH_MIN", "SMOOTH_MAX",     "ROUND",     "FLOOR",
       "CEIL",         "TRUNC",        "FRACT",    "MODULO",     "FLOORED_MODULO", "WRAP",      "SNAP",
       "PINGPONG",     "SINE",         "COSINE",   "TANGENT",    "ARCSINE",        "ARCCOSINE", "ARCTANGENT",
       "ARCTAN2",      "SINH",         "COSH",     "TANH",       "RADIANS",        "DEGREES"});
  const auto in = [&](const char* socket) { return b.input(node, socket, Float, Vec4(0.5f)); };
  value = b.emit(Op::Math, Float, {in("Value"), in("Value_001"), in("Value_002")}, operation);
  if (b.number(node, "use_clamp") != 0.0f) value = b.clamped(value);
  return output == "Value";
}

bool clamp_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = b.emit(
      Op::Clamp, Float,
      {b.input(node, "Value", Float, Vec4(1.0f)), b.input(node, "Min", Float), b.input(node, "Max", Float, Vec4(1.0f))},
      b.choice(node, "clamp_type", {"MINMAX", "RANGE"}));
  return output == "Result";
}

bool map_range_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int kind = b.choice(node, "interpolation_type", {"LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"});
  const bool clamp = b.number(node, "clamp", 1.0f) != 0.0f && kind < 2;  // the smooth interpolations need no clamping
  if (output == "Result") {
    const auto in = [&](const char* socket, float fallback) { return b.input(node, socket, Float, Vec4(fallback)); };
    const Value to_min = in("To Min", 0.0f), to_max = in("To Max", 1.0f);
    value = b.emit(Op::MapRange, Float,
                   {in("Value", 1.0f), in("From Min", 0.0f), in("From Max", 1.0f), to_min, to_max, in("Steps", 4.0f)},
                   kind);
    if (clamp) value = b.emit(Op::Clamp, Float, {value, to_min, to_max}, 1);
    return true;
  }
  const auto in = [&](const char* socket, float fallback) { return b.input(node, socket, Vector, Vec4(fallback)); };
  const Value to_min = in("To_Min_FLOAT3", 0.0f), to_max = in("To_Max_FLOAT3", 1.0f);
  value = b.emit(Op::MapRangeVector, Vector,
                 {in("Vector", 0.0f), in("From_Min_FLOAT3", 0.0f), in("From_Max_FLOAT3", 1.0f), to_min, to_max,
                  in("Steps_FLOAT3", 4.0f)},
                 kind);
  if (clamp) {
    const auto part = [&](int i) {
      return b.emit(Op::Clamp, Float, {b.part(value, i), b.part(to_min, i), b.part(to_max, i)}, 1);
    };
    value = b.emit(Op::Combine, Vector, {part(0), part(1), part(2)});
  }
  return output == "Vector";
}

bool float_curve(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value in = b.input(node, "Value", Float, Vec4(1.0f));
  uint32_t table;
  value = curve_table(b, node, table)
              ? b.emit(Op::FloatCurve, Float, {b.input(node, "Factor", Float, Vec4(1.0f)), in}, 0, table)
              : in;
  return output == "Value";
}

constexpr NodeType kNodes[] = {
    {"ShaderNodeMath", math_node},
    {"ShaderNodeClamp", clamp_node},
    {"ShaderNodeMapRange", map_range_node},
    {"ShaderNodeFloatCurve", float_curve},
};

}  // namespace

std::span<const NodeType> math_nodes() { return kNodes; }

}  // namespace ajar::nodes
