#include "shading/nodes/displacement_nodes.h"

#include "shading/functions/bump.h"
#include "shading/functions/math_functions.h"
#include "shading/nodes/node_type.h"

namespace ajar::nodes {
namespace {

using enum SocketType;

Value normal_input(ProgramBuilder& b, int node) {
  return b.is_linked(node, "Normal") ? b.input(node, "Normal", Vector) : b.surface_normal();
}

int filter_width(ProgramBuilder& b, int node, float pixels) {
  const std::optional<int> width = b.filter_width(pixels);
  if (!width)
    b.report(node, "its material has too many different values of Filter Width: that of another bump is used");
  return width.value_or(0);
}

bool bump_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  // As in Cycles, the value of the socket counts even if it is linked. Blender before 4.3 compares heights a pixel apart.
  float pixels = 1.0f;
  for (const NodeInput& input : b.node(node).inputs)
    if (input.socket == "Filter Width") pixels = input.value.x;
  const int width = filter_width(b, node, pixels);
  Value distance = b.input(node, "Distance", Float, Vec4(1.0f));
  if (b.number(node, "invert") != 0.0f) distance = b.emit(Op::Product, Float, {distance, b.constant(-1.0f)});
  value = b.bumped(
      width, [&] { return b.input(node, "Height", Float, Vec4(1.0f)); }, b.input(node, "Strength", Float, Vec4(1.0f)),
      distance, normal_input(b, node), b.number(node, "keeps_normal") != 0.0f);
  return output == "Normal";
}

Value less(ProgramBuilder& b, Value height, Value midlevel) {
  return b.emit(Op::Math, Float, {height, midlevel, b.constant(0.0f)}, int(MathOperation::Subtract));
}

bool displacement_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value height = less(b, b.input(node, "Height", Float), b.input(node, "Midlevel", Float, Vec4(0.5f)));
  const Value amount = b.emit(Op::Product, Float, {height, b.input(node, "Scale", Float, Vec4(1.0f))});
  const bool object = b.choice(node, "space", {"OBJECT", "WORLD"}) == 0;
  value = b.emit(Op::Displacement, Vector, {amount, normal_input(b, node)},
                 int(object ? DisplacementSpace::Object : DisplacementSpace::World));
  return output == "Displacement";
}

bool vector_displacement_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  static constexpr DisplacementSpace kSpaces[] = {DisplacementSpace::Tangent, DisplacementSpace::Object,
                                                  DisplacementSpace::World};
  const Value vector = b.input(node, "Vector", Vector), middle = b.input(node, "Midlevel", Float);
  const auto part = [&](int i) { return less(b, b.part(vector, i), middle); };
  const Value centred = b.emit(Op::Combine, Vector, {part(0), part(1), part(2)});
  value = b.emit(Op::VectorDisplacement, Vector,
                 {b.emit(Op::Scale, Vector, {centred, b.input(node, "Scale", Float, Vec4(1.0f))})},
                 int(kSpaces[b.choice(node, "space", {"TANGENT", "OBJECT", "WORLD"})]));
  return output == "Displacement";
}

constexpr NodeType kNodes[] = {
    {"ShaderNodeBump", bump_node},
    {"ShaderNodeDisplacement", displacement_node},
    {"ShaderNodeVectorDisplacement", vector_displacement_node},
};

}  // namespace

std::span<const NodeType> displacement_nodes() { return kNodes; }

Value displacement_vector(ProgramBuilder& b) {
  const NodeLink& link = b.graph().displacement;
  if (link.node < 0 || link.node >= int(b.graph().nodes.size())) return {Closure, kNoOperand};
  if (b.catalog().is_closure(b.node(link.node).type)) return {Closure, kNoOperand};
  const Value moved = b.output(link.node, link.socket);
  return moved.type == Closure ? Value{Closure, kNoOperand} : b.convert(moved, Vector);
}

Value displaced_normal(ProgramBuilder& b) {
  const NodeLink& link = b.graph().displacement;
  const Value normal = b.surface_normal();
  if (link.node < 0 || link.node >= int(b.graph().nodes.size())) return normal;
  if (b.catalog().is_closure(b.node(link.node).type)) return normal;
  const auto height = [&] {
    const Value moved = displacement_vector(b);
    if (moved.type == Closure) return b.constant(0.0f);
    return b.emit(Op::VectorMathValue, Float, {moved, normal}, int(VectorOperation::DotProduct));
  };
  const int width = filter_width(b, link.node, b.number(link.node, "filter_width", 1.0f));
  const bool keeps_normal = b.number(link.node, "keeps_normal") != 0.0f;
  const Value one = b.constant(1.0f);
  return b.bumped(width, height, one, one, normal, keeps_normal);
}

}  // namespace ajar::nodes
