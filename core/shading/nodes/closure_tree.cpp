#include "shading/nodes/closure_tree.h"

#include <algorithm>
#include <map>

namespace ajar {

namespace {

constexpr std::string_view kMix = "ShaderNodeMixShader", kAdd = "ShaderNodeAddShader";
constexpr const char* kBranches[2] = {"Shader", "Shader_001"};

}  // namespace

bool is_branch(std::string_view type) { return type == kMix || type == kAdd; }

namespace {

/// The mix and add nodes below the output, parents before children. So one pass over them can sum the weights of all
/// paths of links to a node. The number of such paths can be exponential; the cost of the pass is linear.
class ClosureTree {
 public:
  ClosureTree(ProgramBuilder& builder) : b_(builder), state_(builder.graph().nodes.size(), State::New) {}

  std::vector<int> parents_first(int root) {
    struct Visit {
      int node, branch;
    };
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
        b_.report(parent, "is linked to itself through other nodes; the loop is cut");
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

void for_each_closure(ProgramBuilder& b, const NodeLink& root, const char* what, const ClosureVisitor& visit) {
  if (root.node < 0) return;
  if (root.node >= int(b.graph().nodes.size())) {
    report_once(b.diagnostics(), {Diagnostic::Severity::Warning, b.owner(),
                                  std::string("the ") + what + " output is linked to a node that does not exist"});
    return;
  }

  // A node that is linked as a value emits. Its outputs differ, so the socket is part of the key.
  const auto key = [&](const NodeLink& link) {
    return std::pair{link.node, b.catalog().value(b.node(link.node).type) ? link.socket : std::string()};
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
    for (auto entry = weights.lower_bound({node, std::string()}); entry != weights.end() && entry->first.first == node;
         ++entry) {
      const Value weight = entry->second;
      if (weight.is_constant() && b.constant_value(weight) == 0.0f) continue;
      if (!is_branch(type)) {
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

}  // namespace ajar
