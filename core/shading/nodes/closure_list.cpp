#include "shading/nodes/closure_list.h"

#include "shading/nodes/closure_nodes.h"
#include "shading/nodes/closure_tree.h"

namespace ajar {

std::vector<Closure> flatten_closures(ProgramBuilder& b) {
  std::vector<Closure> closures;
  for_each_closure(b, b.graph().surface, "surface", [&](int node, const std::string& output, Value weight) {
    nodes::add_closures(b, node, output, weight, closures);
  });
  for (Closure& closure : closures) make_valid(closure.inputs);
  return closures;
}

}  // namespace ajar
