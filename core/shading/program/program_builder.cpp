#include "shading/program/program_builder.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "shading/functions/math_functions.h"

namespace ajar {

namespace {

constexpr int kMaxDepth = 250;  ///< nodes on a path of links that are computed by recursion

float finite_or_zero(float x) { return std::isfinite(x) ? x : 0.0f; }

const NodeProperty* find_property(const Node& node, std::string_view name) {
  for (const NodeProperty& property : node.properties)
    if (property.name == name) return &property;
  return nullptr;
}

const NodeInput* find_input(const Node& node, std::string_view socket) {
  for (const NodeInput& input : node.inputs)
    if (input.socket == socket) return &input;
  return nullptr;
}

}  // namespace

ProgramBuilder::ProgramBuilder(const NodeCatalog& catalog, const NodeGraph& graph, const std::string& owner,
                               TextureStore& textures, Diagnostics& diagnostics, const ShaderContext& context)
    : catalog_(catalog),
      graph_(graph),
      owner_(owner),
      textures_(textures),
      diagnostics_(diagnostics),
      context_(context),
      on_stack_(graph.nodes.size(), false) {
  // Find the outputs that are read by nodes from which a path of links leads to the output.
  std::vector<bool> seen(graph.nodes.size(), false);
  std::vector<int> open;
  const auto visit = [&](const NodeLink& link) {
    if (link.node < 0 || link.node >= int(graph.nodes.size())) return;
    read_[{link.node, link.socket}] = true;
    if (!seen[link.node]) seen[link.node] = true, open.push_back(link.node);
  };
  visit(graph.surface);
  visit(graph.volume);
  visit(graph.displacement);
  while (!open.empty()) {
    const int index = open.back();
    open.pop_back();
    for (const NodeInput& input : graph.nodes[index].inputs) visit(input.link);
  }
}

// ---- Reading the graph ------------------------------------------------------------------

const NodeLink* ProgramBuilder::link(int node, std::string_view socket) const {
  const NodeInput* input = find_input(graph_.nodes[node], socket);
  if (!input || input->link.node < 0 || input->link.node >= int(graph_.nodes.size())) return nullptr;
  return &input->link;
}

bool ProgramBuilder::is_linked(int node, std::string_view socket) const {
  const NodeLink* from = link(node, socket);
  return from && !catalog_.is_closure(graph_.nodes[from->node].type);
}

bool ProgramBuilder::is_read(int node, std::string_view output) const {
  return read_.count({node, std::string(output)}) != 0;
}

std::string_view ProgramBuilder::text(int node, std::string_view property, std::string_view fallback) const {
  const NodeProperty* found = find_property(graph_.nodes[node], property);
  return found ? std::string_view(found->text) : fallback;
}

const std::vector<float>* ProgramBuilder::numbers(int node, std::string_view property) const {
  const NodeProperty* found = find_property(graph_.nodes[node], property);
  return found ? &found->numbers : nullptr;
}

float ProgramBuilder::number(int node, std::string_view property, float fallback) const {
  const std::vector<float>* found = numbers(node, property);
  return found && !found->empty() ? finite_or_zero((*found)[0]) : fallback;
}

int ProgramBuilder::choice(int node, std::string_view property, std::initializer_list<std::string_view> names,
                           int fallback) {
  const std::string_view value = text(node, property);
  if (value.empty()) return fallback;
  int i = 0;
  for (const std::string_view name : names) {
    if (name == value) return i;
    ++i;
  }
  report(node, "unknown " + std::string(property) + " '" + std::string(value) + "', using '" +
                   std::string(names.begin()[fallback]) + "'");
  return fallback;
}

std::optional<int> ProgramBuilder::filter_width(float pixels) {
  pixels = std::clamp(pixels, 1e-3f, 1e3f);
  auto& known = tables.bump.filter_widths;
  int& count = tables.bump.widths;
  const int found = int(std::find(known.begin(), known.begin() + count, pixels) - known.begin());
  if (found == BumpFootprint::kMostWidths) return std::nullopt;
  if (found == count) {
    known[size_t(found)] = pixels;
    ++count;
  }
  return found;
}

void ProgramBuilder::report(int node, const std::string& message) {
  const Node& n = graph_.nodes[node];
  report_once(diagnostics_, {Diagnostic::Severity::Warning, owner_,
                             "node '" + (n.name.empty() ? n.type : n.name) + "' (" + n.type + "): " + message});
}

std::string ProgramBuilder::shown_by() const {
  if (context_.user.empty()) return "'" + owner_ + "'";
  return "material '" + owner_ + "' of object '" + context_.user + "'";
}

// ---- Values -------------------------------------------------------------------------------

Value ProgramBuilder::input(int node, std::string_view socket, SocketType type, Vec4 fallback) {
  const NodeInput* found = find_input(graph_.nodes[node], socket);
  if (found && found->link.node >= 0) {
    if (found->link.node >= int(graph_.nodes.size())) {
      report(node, "input '" + std::string(socket) + "' is linked to a node that does not exist");
    } else if (is_linked(node, socket)) {
      const Value value = value_of(found->link);
      if (value.type != SocketType::Closure) return convert(value, type);
    }
  }
  const Vec4 value = found ? found->value : fallback;
  return type == SocketType::Float ? constant(value.x) : constant(Vec3(value), type);
}

// A Value of type Closure means that there is no usable value; the caller uses its own default.
Value ProgramBuilder::value_of(const NodeLink& link) {
  const Value nothing{SocketType::Closure, 0};
  const auto key = std::make_pair(link.node, link.socket);
  auto& values = values_here();
  if (const auto found = values.find(key); found != values.end()) return found->second;
  if (on_stack_[link.node]) {
    report(link.node, "is linked to itself through other nodes; the loop is cut");
    return nothing;
  }
  if (depth_ >= kMaxDepth) compute_inputs(link);
  return values[key] = compute(link);
}

/// Computes the values that lead to `link`, inputs first, with a stack of its own. The recursion of `compute` then ends
/// at values that are known.
void ProgramBuilder::compute_inputs(const NodeLink& link) {
  struct Visit {
    const NodeLink* link;
    size_t next;  ///< input of the node
  };
  auto& values = values_here();
  std::vector<Visit> open{{&link, 0}};
  on_stack_[link.node] = true;
  while (true) {
    Visit& top = open.back();
    const Node& node = graph_.nodes[top.link->node];
    if (top.next < node.inputs.size()) {
      const NodeLink& from = node.inputs[top.next++].link;
      if (from.node < 0 || from.node >= int(graph_.nodes.size()) || on_stack_[from.node]) continue;
      if (catalog_.is_closure(graph_.nodes[from.node].type) || values.contains({from.node, from.socket})) continue;
      on_stack_[from.node] = true;
      open.push_back({&from, 0});
      continue;
    }
    const NodeLink& done = *top.link;
    open.pop_back();
    if (open.empty()) break;
    values[{done.node, done.socket}] = compute(done);
  }
  on_stack_[link.node] = false;
}

Value ProgramBuilder::compute(const NodeLink& link) {
  const Value nothing{SocketType::Closure, 0};
  on_stack_[link.node] = true;
  ++depth_;
  Value value = nothing;
  if (const NodeFunction function = catalog_.value(graph_.nodes[link.node].type)) {
    if (!function(*this, link.node, link.socket, value)) {
      report(link.node, "has no output '" + link.socket + "'");
      value = nothing;
    }
  } else {
    value = unknown_value(link.node, link.socket);
  }
  --depth_;
  on_stack_[link.node] = false;
  return value;
}

Value ProgramBuilder::unknown_value(int index, std::string_view output) {
  const Node& unknown = graph_.nodes[index];
  if (output == "Normal") {
    report(index, "is not supported yet; the surface's own normal is used");
    return is_linked(index, "Normal") ? input(index, "Normal", SocketType::Vector) : surface_normal();
  }
  for (const NodeInput& in : unknown.inputs) {
    if (!is_linked(index, in.socket)) continue;
    report(index, "is not supported yet; its input '" + in.socket + "' is passed through");
    return value_of(in.link);
  }
  if (find_input(unknown, "Color")) {
    report(index, "is not supported yet; its input 'Color' is used");
    return input(index, "Color", SocketType::Color);
  }
  if (!unknown.inputs.empty() && unknown.inputs[0].link.node < 0 && unknown.inputs[0].socket != "Vector") {
    report(index, "is not supported yet; the value of its input '" + unknown.inputs[0].socket + "' is used");
    return input(index, unknown.inputs[0].socket, SocketType::Float);
  }
  report(index, "is not supported yet; grey is used");
  return constant(0.5f);
}

Value ProgramBuilder::convert(Value value, SocketType type) {
  if (value.type == type) return value;
  if (type == SocketType::Float && value.type == SocketType::Color && !context_.works_in_rec709()) {
    const Color y = kRec709Luminance * glm::inverse(context_.working_from_rec709);
    return emit(Op::VectorMathValue, type, {value, constant(y, SocketType::Color)},
                int(nodes::VectorOperation::DotProduct));
  }
  if (type == SocketType::Float)
    return emit(value.type == SocketType::Color ? Op::Luminance : Op::Average, type, {value});
  if (value.type == SocketType::Float) return emit(Op::Splat, type, {value});
  return {type, value.at};
}

Value ProgramBuilder::spectral(Op op, Value input) {
  if (context_.works_in_rec709()) return emit(op, SocketType::Color, {input});
  return in_working_space(emit(op, SocketType::Color, {input}, 1));
}

Value ProgramBuilder::in_working_space(Value rec709) {
  if (context_.works_in_rec709()) return rec709;
  const Value moved = emit(Op::Affine, SocketType::Color, {rec709}, 0, add_matrix(Mat4(context_.working_from_rec709)));
  const Value zero = constant(Vec3(0.0f), SocketType::Vector);
  return emit(Op::VectorMath, SocketType::Color, {moved, zero, zero, constant(0.0f)},
              int(nodes::VectorOperation::Maximum));
}

// ---- Constants and instructions ----------------------------------------------------------------

Operand ProgramBuilder::add_constant(const float* values, int count) {
  const std::string key(reinterpret_cast<const char*>(values), size_t(count) * sizeof(float));
  if (const auto found = constants_.find(key); found != constants_.end()) return found->second;
  const auto at = Operand(-1 - int(tables.constants.size()));
  tables.constants.insert(tables.constants.end(), values, values + count);
  constants_.emplace(key, at);
  return at;
}

Value ProgramBuilder::constant(float value) {
  value = finite_or_zero(value);
  return {SocketType::Float, add_constant(&value, 1)};
}

Value ProgramBuilder::constant(Vec3 value, SocketType type) {
  const float values[3] = {finite_or_zero(value.x), finite_or_zero(value.y), finite_or_zero(value.z)};
  return {type, add_constant(values, 3)};
}

bool ProgramBuilder::simplify(Op op, std::initializer_list<Value> inputs, Value& result) {
  if (inputs.size() != 2) return false;
  const Value a = inputs.begin()[0], b = inputs.begin()[1];
  const auto is = [this](Value v, float x) { return v.is_constant() && constant_value(v) == x; };
  switch (op) {
    case Op::Product:
      if (is(b, 1.0f)) return result = a, true;
      if (is(a, 1.0f)) return result = b, true;
      if (is(a, 0.0f) || is(b, 0.0f)) return result = constant(0.0f), true;
      return false;
    case Op::ProductInverse:
      if (is(b, 0.0f)) return result = a, true;
      if (is(a, 0.0f) || is(b, 1.0f)) return result = constant(0.0f), true;
      return false;
    case Op::Sum:
      if (is(a, 0.0f)) return result = b, true;
      if (is(b, 0.0f)) return result = a, true;
      return false;
    case Op::Scale:
      if (is(b, 1.0f)) return result = a, true;
      if (is(b, 0.0f)) return result = constant(Vec3(0.0f), a.type), true;
      return false;
    default: return false;
  }
}

Value ProgramBuilder::emit(Op op, SocketType type, std::initializer_list<Value> inputs, int variant, uint32_t data) {
  const OpInfo& op_info = info(op);
  Instruction instruction;
  instruction.op = op;
  instruction.variant = uint8_t(variant);
  instruction.data = data;
  if (can_shift(op)) instruction.shift = shift_;
  bool constant_inputs = true;
  int n = 0;
  for (const Value& value : inputs) {
    instruction.in[n++] = value.at;
    constant_inputs = constant_inputs && value.is_constant();
  }
  Value result{type, 0};
  if (constant_inputs && !op_info.needs_point) {
    float out[kMaxWidth] = {};
    Instruction folded = instruction;
    folded.out = 0;
    run(&folded, 1, tables, ShadingPoint(), out);
    for (float& x : out) x = finite_or_zero(x);
    result.at = add_constant(out, op_info.width);
    return result;
  }
  if (simplify(op, inputs, result)) return {type, result.at};

  std::string key;
  key.push_back(char(op));
  key.push_back(char(variant));
  key.push_back(char(instruction.shift));
  key.append(reinterpret_cast<const char*>(instruction.in.data()), sizeof instruction.in);
  key.append(reinterpret_cast<const char*>(&data), sizeof data);
  if (const auto found = instructions_.find(key); found != instructions_.end()) return {type, found->second};
  instruction.out = result.at = Operand(register_count_);
  register_count_ += op_info.width;
  code.push_back(instruction);
  instructions_.emplace(key, result.at);
  return result;
}

Value ProgramBuilder::object_normal() {
  if (!context_.lamp) return emit(Op::ObjectNormal, SocketType::Vector, {});
  return in_lamp_space(emit(Op::ShadingNormal, SocketType::Vector, {}));
}

Value ProgramBuilder::object_incoming() {
  if (!context_.lamp) return emit(Op::ObjectIncoming, SocketType::Vector, {});
  return in_lamp_space(emit(Op::Incoming, SocketType::Vector, {}));
}

Value ProgramBuilder::coordinates(Op op) {
  const LampSpace* lamp = context_.lamp;
  const bool parametric = op == Op::Parametric, of_object = op == Op::Generated || op == Op::ObjectPosition;
  if (lamp && (lamp->has_uv ? parametric || op == Op::ActiveUv : parametric && lamp->kind == LightKind::Area))
    return lamp_uv();
  if (!lamp || !lamp->own_coordinates || !of_object) return emit(op, SocketType::Vector, {});
  const Mat4 lamp_from_world = glm::affineInverse(to_matrix(lamp->world_from_lamp));
  return emit(Op::TransformPosition, SocketType::Vector, {}, 0, add_matrix(lamp_from_world));
}

Value ProgramBuilder::place(int node, Op unlinked) {
  return is_linked(node, "Vector") ? input(node, "Vector", SocketType::Vector) : coordinates(unlinked);
}

/// The UV coordinates that Cycles gives lamps in 4.2 to 5.2.
Value ProgramBuilder::lamp_uv() {
  const LampSpace& lamp = *context_.lamp;
  const Mat4 lamp_from_world = glm::affineInverse(to_matrix(lamp.world_from_lamp));
  const auto scaled = [](Vec3 scale, Vec3 offset) {
    return Mat4(Vec4(scale.x, 0, 0, 0), Vec4(0, scale.y, 0, 0), Vec4(0, 0, scale.z, 0), Vec4(offset, 1));
  };
  const auto direction = [&](Op op) {  // in the space of the lamp
    return emit(Op::Affine, SocketType::Vector, {emit(op, SocketType::Vector, {})}, 0,
                add_matrix(Mat4(Mat3(lamp_from_world))));
  };
  switch (lamp.kind) {
    case LightKind::Sun: break;
    case LightKind::Area: {
      const Vec2 size = glm::max(lamp.area_size, Vec2(1e-20f));
      const Mat4 to_uv = scaled({1.0f / size.x, 1.0f / size.y, 0.0f}, {0.5f, 0.5f, 0.0f});
      return emit(Op::TransformPosition, SocketType::Vector, {}, 0, add_matrix(to_uv * lamp_from_world));
    }
    case LightKind::Spot: {  // the square around the circle of the cone, at any distance
      const Value d = direction(Op::Incoming);
      const float half_cot = 0.5f / std::tan(0.5f * lamp.spot_angle);
      const Value along = emit(Op::Math, SocketType::Float, {constant(-half_cot), part(d, 2), constant(0.0f)},
                               int(nodes::MathOperation::Divide));
      return emit(Op::Affine, SocketType::Vector, {emit(Op::Scale, SocketType::Vector, {d, along})}, 0,
                  add_matrix(scaled({1.0f, 1.0f, 0.0f}, {0.5f, 0.5f, 0.0f})));
    }
    case LightKind::Point: {  // longitude and latitude; ProjectSphere has the centre (0.5, 0.5, 0.5)
      const Value d = emit(Op::Affine, SocketType::Vector, {direction(Op::ShadingNormal)}, 0,
                           add_matrix(scaled(Vec3(0.5f), Vec3(0.5f))));
      return emit(Op::ProjectSphere, SocketType::Vector, {d});
    }
  }
  return constant(Vec3(0.5f, 0.5f, 0.0f), SocketType::Vector);
}

Value ProgramBuilder::in_lamp_space(Value normal) {
  const Mat4 lamp_from_normal(glm::transpose(Mat3(to_matrix(context_.lamp->world_from_lamp))));
  return emit(Op::Normalize, SocketType::Vector,
              {emit(Op::Affine, SocketType::Vector, {normal}, 0, add_matrix(lamp_from_normal))});
}

void ProgramBuilder::measure_pixels() {
  BumpFootprint& bump = tables.bump;
  if (std::exchange(bump.measured, true)) return;
  const CameraDescription* camera = this->camera();  // records that the program depends on the camera
  if (!camera) return;
  bump.camera = camera->kind == CameraKind::Texels ? CameraKind::Orthographic : camera->kind;
  bump.camera_from_world = glm::affineInverse(to_matrix(camera->world_from_camera));
  const float width = float(std::max(context_.image_width, 1));
  bump.pixel = (camera->kind == CameraKind::Panorama ? 2.0f * kPi : camera->screen_window.y - camera->screen_window.x) /
               width;
}

uint32_t ProgramBuilder::add_name(std::string_view name) {
  for (size_t i = 0; i < tables.names.size(); ++i)
    if (tables.names[i] == name) return uint32_t(i);
  tables.names.emplace_back(name);
  return uint32_t(tables.names.size() - 1);
}

uint32_t ProgramBuilder::add_matrix(const Mat4& matrix) {
  for (size_t i = 0; i < tables.matrices.size(); ++i)
    if (tables.matrices[i] == matrix) return uint32_t(i);
  tables.matrices.push_back(matrix);
  return uint32_t(tables.matrices.size() - 1);
}

}  // namespace ajar
