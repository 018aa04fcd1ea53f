// Converts values of a node graph to instructions, one value at a time, and only the values that are read.
//
// `value_of` follows the links backwards from an output. Constants are folded, equal instructions are shared, and
// conversions between socket types are inserted. Broken graphs never throw. docs/developer/node_contract.md states the
// result of each defect.
#pragma once

#include <map>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "description/diagnostics.h"
#include "shading/program/register_program.h"
#include "shading/program/shader_context.h"

namespace ajar {

enum class SocketType : uint8_t { Float, Vector, Color, Closure };

/// The value of a socket: a constant or registers, and its type.
struct Value {
  SocketType type = SocketType::Float;
  Operand at = 0;
  bool is_constant() const { return at < 0; }
};

class ProgramBuilder;

/// Computes the value of `output` of node `node`. Returns false if the node does not have this output.
using NodeFunction = bool (*)(ProgramBuilder& builder, int node, std::string_view output, Value& value);

/// The node types that the builder knows. `value` returns null for a type that is not a known value node.
struct NodeCatalog {
  NodeFunction (*value)(std::string_view type);
  bool (*is_closure)(std::string_view type);
};

class ProgramBuilder {
 public:
  ProgramBuilder(const NodeCatalog& catalog, const NodeGraph& graph, const std::string& owner, TextureStore& textures,
                 Diagnostics& diagnostics, const ShaderContext& context);

  // ---- For node compilers: the graph ----
  /// The input `socket` of `node`, converted to `type`. The value is `fallback` if the node does not have the socket.
  Value input(int node, std::string_view socket, SocketType type, Vec4 fallback = Vec4(0.0f));
  /// The value of `output` of `node`. Its type is Closure if there is no usable value.
  Value output(int node, const std::string& output) { return value_of({node, output}); }
  /// Returns true if the socket is linked to a node that can be used as a value.
  bool is_linked(int node, std::string_view socket) const;
  /// Returns true if any node reads this output.
  bool is_read(int node, std::string_view output) const;
  const Node& node(int index) const { return graph_.nodes[index]; }
  std::string_view text(int node, std::string_view property, std::string_view fallback = {}) const;
  float number(int node, std::string_view property, float fallback = 0.0f) const;
  const std::vector<float>* numbers(int node, std::string_view property) const;
  /// The index of the property's text in `names`. If the text is not in the list, it is reported and `fallback` is
  /// returned.
  int choice(int node, std::string_view property, std::initializer_list<std::string_view> names, int fallback = 0);

  // ---- For node compilers: instructions ----
  Value constant(float value);
  Value constant(Vec3 value, SocketType type);
  Value emit(Op op, SocketType type, std::initializer_list<Value> inputs, int variant = 0, uint32_t data = 0);
  Value convert(Value value, SocketType type);
  /// Blackbody or Wavelength, in the working space.
  Value spectral(Op op, Value input);
  /// A colour in linear Rec. 709, converted to the working space and clipped there.
  Value in_working_space(Value rec709);
  Value part(Value whole, int i) const { return {SocketType::Float, component(whole.at, i)}; }
  Value clamped(Value value) {
    return value.type == SocketType::Float ? emit(Op::Saturate, value.type, {value})
                                           : emit(Op::SaturateColor, value.type, {value});
  }
  float constant_value(Value value, int i = 0) const { return tables.constants[-1 - component(value.at, i)]; }
  Vec3 constant_vector(Value value) const {
    return {constant_value(value), constant_value(value, 1), constant_value(value, 2)};
  }

  /// The normal of the surface before closures and nodes replace it: the smooth normal, or the normal of the displaced
  /// surface after set_displaced_normal.
  Value surface_normal() {
    return surface_normal_ ? *surface_normal_ : emit(Op::ShadingNormal, SocketType::Vector, {});
  }
  /// The coordinates of `op`: Generated, ObjectPosition, ActiveUv, Parametric or Position; in the nodes of a lamp, its
  /// own.
  Value coordinates(Op op);
  /// The input Vector of a texture; where nothing is linked to it, `coordinates`.
  Value place(int node, Op unlinked);
  /// The smooth normal in the space of the object or of the lamp.
  Value object_normal();
  /// The direction to the eye, transformed like a normal to the space of the object or of the lamp.
  Value object_incoming();
  Operand displaced_normal() const { return surface_normal_ ? surface_normal_->at : kNoOperand; }
  void set_displaced_normal(Value normal) { surface_normal_ = normal; }
  /// A number for `bumped`: the distance of the heights that it compares, in pixels. Nothing if the program has too many
  /// different ones.
  std::optional<int> filter_width(float pixels);
  /// A normal that is tilted by a height field. `height()` is called for the point and for the two points beside it,
  /// which are selected by shift_. `width`: filter_width.
  /// With `keeps_normal` it is not bent towards the eye.
  template <class Height>
  Value bumped(int width, Height&& height, Value strength, Value distance, Value normal, bool keeps_normal) {
    Value h[3];
    at_three_points(width, true, height, h);
    if (h[0].at == h[1].at && h[0].at == h[2].at) return normal;
    measure_pixels();
    tables.bump.used = true;
    return emit(Op::Bump, SocketType::Vector, {h[0], h[1], h[2], strength, distance, normal},
                int(keeps_normal) | width << 1);
  }

  /// Whether an image has to be the mean over a pixel: images with levels, except in heights and displacements, which
  /// are compared over less than a pixel.
  bool takes_means(const Texture& texture) const {
    return !exact_images_ && context_.takes_means && texture.has_levels();
  }
  /// The value of `coordinates()` at the point and at the two points beside it. Returns false if they are equal.
  template <class Coordinates>
  bool beside(Coordinates&& coordinates, Value (&values)[3]) {
    at_three_points(0, exact_images_, coordinates, values);
    if (values[0].at == values[1].at && values[0].at == values[2].at) return false;
    measure_pixels();
    tables.bump.used = true;
    return true;
  }
  /// Evaluates `value()` with images of level 0 only.
  template <class Evaluated>
  Value with_exact_images(Evaluated&& value) {
    const bool outer = std::exchange(exact_images_, true);
    const Value result = value();
    exact_images_ = outer;
    return result;
  }

  /// Gives instructions access to the width of a camera pixel at a point.
  void measure_pixels();

  uint32_t add_name(std::string_view name);
  uint32_t add_matrix(const Mat4& matrix);
  void report(int node, const std::string& message);
  /// The owner of the graph and an object that shows it, for messages about files.
  std::string shown_by() const;

  /// The link of an input, or null if it does not lead to an existing node.
  const NodeLink* link(int node, std::string_view socket) const;
  const NodeGraph& graph() const { return graph_; }
  const ShaderContext& context() const { return context_; }
  /// The camera, for programs that depend on it. Null if there is none.
  const CameraDescription* camera() const {
    if (context_.sees_camera) *context_.sees_camera = true;
    return context_.camera && context_.camera->present ? context_.camera : nullptr;
  }
  TextureStore& textures() { return textures_; }
  Diagnostics& diagnostics() { return diagnostics_; }
  const std::string& owner() const { return owner_; }
  const NodeCatalog& catalog() const { return catalog_; }
  int register_count() const { return register_count_; }  ///< before registers are used again

  std::vector<Instruction> code;
  ProgramTables tables;
  std::map<int, uint32_t> node_data;  ///< curve or image that a node has already added, for its other outputs

 private:
  template <class Evaluated>
  void at_three_points(int width, bool exact_images, Evaluated&& value, Value (&values)[3]) {
    const Shift outer = shift_;
    const bool outer_exact = std::exchange(exact_images_, exact_images);
    for (const Shift shift : {Shift::None, Shift::X, Shift::Y}) {
      shift_ = at_width(shift, width);
      values[size_t(shift)] = value();
    }
    shift_ = outer;
    exact_images_ = outer_exact;
  }
  auto& values_here() { return values_[exact_images_ ? 1 : 0][size_t(shift_)]; }
  Value in_lamp_space(Value normal);
  Value lamp_uv();
  Value value_of(const NodeLink& link);
  Value compute(const NodeLink& link);
  void compute_inputs(const NodeLink& link);
  Value unknown_value(int node, std::string_view output);
  Operand add_constant(const float* values, int count);
  /// Simplifies a * 1, a * 0, a + 0 and similar expressions to values without an instruction.
  bool simplify(Op op, std::initializer_list<Value> inputs, Value& result);

  const NodeCatalog& catalog_;
  const NodeGraph& graph_;
  const std::string& owner_;
  TextureStore& textures_;
  Diagnostics& diagnostics_;
  const ShaderContext& context_;
  std::map<std::pair<int, std::string>, Value, std::less<>> values_[2][kMostShifts];  // by exact_images_ and shift
  Shift shift_ = Shift::None;
  bool exact_images_ = false;  ///< see takes_means
  std::optional<Value> surface_normal_;
  std::unordered_map<std::string, Operand> constants_, instructions_;  // the keys are their bytes
  std::vector<bool> on_stack_;
  std::map<std::pair<int, std::string>, bool> read_;
  int depth_ = 0, register_count_ = 0;
};

}  // namespace ajar
