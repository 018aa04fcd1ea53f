#include "shading/closure_list.h"

#include <algorithm>
#include <cmath>

#include "shading/node_registry.h"
#include "shading/nodes/closure_nodes.h"
#include "shading/nodes/unsupported_settings.h"
#include "shading/volume_closures.h"

namespace ajar {

std::string_view name_of(ClosureKind kind) {
  static constexpr std::string_view kNames[] = {"Diffuse",    "Glossy",      "Glass",    "Refraction", "Translucent",
                                                "Principled", "Velvet",      "Toon",     "Glossy Toon", "Subsurface",
                                                "Transparent", "Emission",   "Holdout"};
  return kNames[size_t(kind)];
}

namespace {

/// What one input, or each channel of a colour, may be.
struct InputLimits {
  size_t offset;
  float low, high;
  size_t count = 1;
};

#define AJAR_INPUT(name) offsetof(closures::PrincipledInputs, name)
constexpr InputLimits kInputLimits[] = {
    {AJAR_INPUT(metallic), 0.0f, 1.0f}, {AJAR_INPUT(roughness), 0.0f, 1.0f}, {AJAR_INPUT(transmission), 0.0f, 1.0f},
    {AJAR_INPUT(transmission_roughness), 0.0f, 1.0f}, {AJAR_INPUT(sheen_roughness), 0.0f, 1.0f}, {AJAR_INPUT(clearcoat_roughness), 0.0f, 1.0f},
    {AJAR_INPUT(diffuse_roughness), 0.0f, 1.0f}, {AJAR_INPUT(subsurface), 0.0f, 1.0f}, {AJAR_INPUT(subsurface_anisotropy), 0.0f, 1.0f},
    {AJAR_INPUT(specular), 0.0f, 12.0f}, {AJAR_INPUT(specular_ior_level), 0.0f, 12.0f}, {AJAR_INPUT(sheen), 0.0f, 12.0f}, {AJAR_INPUT(clearcoat), 0.0f, 12.0f},
    {AJAR_INPUT(specular_tint), 0.0f, 1.0f}, {AJAR_INPUT(sheen_tint), 0.0f, 1.0f},
    {AJAR_INPUT(anisotropic), -1.0f, 1.0f}, {AJAR_INPUT(anisotropic_rotation), -1e4f, 1e4f},
    {AJAR_INPUT(ior), 1e-5f, 1e4f}, {AJAR_INPUT(coat_ior), 1.0f, 1e4f}, {AJAR_INPUT(subsurface_ior), 1.01f, 3.8f}, {AJAR_INPUT(subsurface_scale), 0.0f, 1e12f},
    {AJAR_INPUT(base_color), 0.0f, 1e12f, 3}, {AJAR_INPUT(specular_tint_color), 0.0f, 1e12f, 3}, {AJAR_INPUT(sheen_tint_color), 0.0f, 1e12f, 3},
    {AJAR_INPUT(coat_tint), 0.0f, 1e12f, 3}, {AJAR_INPUT(subsurface_color), 0.0f, 1e12f, 3}, {AJAR_INPUT(subsurface_radius), 0.0f, 1e12f, 3}};
#undef AJAR_INPUT

/// Of the constant inputs.
void make_valid(closures::PrincipledInputs& inputs) {
  for (const InputLimits& limits : kInputLimits)
    for (size_t i = 0; i < limits.count; ++i) {
      float x;
      char* const at = reinterpret_cast<char*>(&inputs) + limits.offset + i * sizeof(float);
      std::memcpy(&x, at, sizeof(float));
      x = valid_input(x, limits.low, limits.high);
      std::memcpy(at, &x, sizeof(float));
    }
}

}  // namespace

InputPatch::InputPatch(size_t offset, uint8_t count, Operand from) : offset(uint16_t(offset)), count(count), from(from) {
  for (const InputLimits& limits : kInputLimits)
    if (limits.offset == offset) low = limits.low, high = limits.high;
}

namespace {

constexpr std::string_view kMix = "ShaderNodeMixShader", kAdd = "ShaderNodeAddShader";
constexpr const char* kBranches[2] = {"Shader", "Shader_001"};

bool is_branch(std::string_view type) { return type == kMix || type == kAdd; }

/// The mix and add nodes below the output, parents before children, so that one sweep can sum the weights of
/// all ways to a node (their number may grow exponentially; a sweep does not).
class ClosureTree {
 public:
  ClosureTree(ProgramBuilder& builder) : b_(builder), state_(builder.graph().nodes.size(), State::New) {}

  std::vector<int> parents_first(int root) {
    struct Visit { int node, branch; };
    std::vector<int> order;
    std::vector<Visit> stack{{root, 0}};
    state_[root] = State::Open;
    while (!stack.empty()) {
      Visit& top = stack.back();
      if (top.branch == 2 || !is_branch(b_.node(top.node).type)) {
        state_[top.node] = State::Done;
        order.push_back(top.node);
        stack.pop_back();
        continue;
      }
      const int parent = top.node, branch = top.branch++;
      const NodeLink* link = b_.link(parent, kBranches[branch]);
      if (!link) continue;
      if (state_[link->node] == State::Open) {
        b_.report(parent, "feeds itself; the loop is cut");
        cut_.push_back({parent, branch});
      } else if (state_[link->node] == State::New) {
        state_[link->node] = State::Open;
        stack.push_back({link->node, 0});
      }
    }
    std::reverse(order.begin(), order.end());
    return order;
  }
  bool is_cut(int node, int branch) const {
    return std::find(cut_.begin(), cut_.end(), std::pair{node, branch}) != cut_.end();
  }

 private:
  enum class State : uint8_t { New, Open, Done };
  ProgramBuilder& b_;
  std::vector<State> state_;
  std::vector<std::pair<int, int>> cut_;
};

}  // namespace

bool is_closure_type(std::string_view type) { return is_branch(type) || is_volume_node(type) || nodes::find_closure_node(type) != nullptr; }

void for_each_closure(ProgramBuilder& b, const NodeLink& root, const char* what, const ClosureVisitor& visit) {
  if (root.node < 0) return;
  if (root.node >= int(b.graph().nodes.size())) {
    report_once(b.diagnostics(), {Diagnostic::Severity::Warning, b.owner(),
                                  std::string("the ") + what + " output is linked to a node that does not exist"});
    return;
  }

  // A node reached as a value emits; its outputs differ, so the socket is part of the key.
  const auto key = [&](const NodeLink& link) {
    return std::pair{link.node, find_value_node(b.node(link.node).type) ? link.socket : std::string()};
  };
  std::map<std::pair<int, std::string>, Value> weights;
  weights[key(root)] = b.constant(1.0f);
  const auto give = [&](const NodeLink& link, Value weight) {
    const auto [entry, is_new] = weights.emplace(key(link), weight);
    if (!is_new) entry->second = b.emit(Op::Sum, SocketType::Float, {entry->second, weight});
  };

  ClosureTree tree(b);
  for (const int node : tree.parents_first(root.node)) {
    const std::string_view type = b.node(node).type;
    for (auto entry = weights.lower_bound({node, std::string()}); entry != weights.end() && entry->first.first == node; ++entry) {
      const Value weight = entry->second;
      if (weight.is_constant() && b.constant_value(weight) == 0.0f) continue;
      if (!is_branch(type)) {
        nodes::report_unsupported_settings(b, node);
        visit(node, entry->first.second, weight);
        continue;
      }
      const auto child = [&](int branch) -> const NodeLink* {
        return tree.is_cut(node, branch) ? nullptr : b.link(node, kBranches[branch]);
      };
      Value first = weight, second = weight;
      if (type == kMix) {
        const Value t = b.clamped(b.input(node, "Fac", SocketType::Float, Vec4(0.5f)));
        first = b.emit(Op::ProductInverse, SocketType::Float, {weight, t});
        second = b.emit(Op::Product, SocketType::Float, {weight, t});
      }
      if (const NodeLink* link = child(0)) give(*link, first);
      if (const NodeLink* link = child(1)) give(*link, second);
    }
  }
}

std::vector<Closure> flatten_closures(ProgramBuilder& b) {
  std::vector<Closure> closures;
  for_each_closure(b, b.graph().surface, "surface",
                   [&](int node, const std::string& output, Value weight) { nodes::add_closures(b, node, output, weight, closures); });
  for (Closure& closure : closures) make_valid(closure.inputs);
  return closures;
}

}  // namespace ajar
