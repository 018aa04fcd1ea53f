// AOV Output nodes: values of a graph that passes show.
#pragma once

#include "shading/program/program_builder.h"

namespace ajar {

struct AovOutput {
  uint32_t name;  ///< hash of the name of the output
  Operand color, value;
};

/// The AOV Output nodes of the graph. All of them are outputs, whether or not a pass shows them.
std::vector<AovOutput> compile_aovs(ProgramBuilder& builder);

/// The code that these outputs need, with registers of its own. Replaces the operands. `register_count` grows if needed.
std::vector<Instruction> aov_code(const std::vector<Instruction>& needed, int value_count,
                                  std::vector<AovOutput>& outputs, int& register_count);

}  // namespace ajar
