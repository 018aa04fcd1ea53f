#include "shading/aov_outputs.h"

#include "math/name_hash.h"
#include "shading/program/register_allocation.h"

namespace ajar {

std::vector<AovOutput> compile_aovs(ProgramBuilder& builder) {
  std::vector<AovOutput> outputs;
  const std::vector<Node>& nodes = builder.graph().nodes;
  for (int node = 0; node < int(nodes.size()); ++node) {
    if (nodes[size_t(node)].type != "ShaderNodeOutputAOV") continue;
    outputs.push_back({murmur_hash3(builder.text(node, "aov_name")), builder.input(node, "Color", SocketType::Color).at,
                       builder.input(node, "Value", SocketType::Float).at});
  }
  return outputs;
}

std::vector<Instruction> aov_code(const std::vector<Instruction>& needed, int value_count,
                                  std::vector<AovOutput>& outputs, int& register_count) {
  std::vector<Operand> kept;
  for (const AovOutput& output : outputs) kept.insert(kept.end(), {output.color, output.value});
  std::vector<Instruction> code = needed;
  const RegisterAllocation registers(code, value_count, kept);
  register_count = std::max(register_count, registers.register_count());
  registers.apply(code);
  for (AovOutput& output : outputs) output = {output.name, registers(output.color), registers(output.value)};
  return code;
}

}  // namespace ajar
