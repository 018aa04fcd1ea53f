#include "shading/program/register_allocation.h"

#include <array>
#include <limits>

namespace ajar {

RegisterAllocation::RegisterAllocation(const std::vector<Instruction>& code, int value_count,
                                       const std::vector<Operand>& kept)
    : registers_(size_t(value_count), 0) {
  // The instruction that writes each value, and the last one that reads it.
  std::vector<int> writer(size_t(value_count), -1), last_reader(code.size());
  const auto read_by = [&](Operand value, int reader) {
    if (value >= 0 && value != kNoOperand) last_reader[size_t(writer[size_t(value)])] = reader;
  };
  for (int i = 0; i < int(code.size()); ++i) {
    last_reader[size_t(i)] = i;
    for (int k = 0; k < info(code[size_t(i)].op).width; ++k) writer[size_t(code[size_t(i)].out + k)] = i;
    for (const Operand value : code[size_t(i)].in) read_by(value, i);
  }
  for (const Operand value : kept) read_by(value, std::numeric_limits<int>::max());

  std::array<std::vector<Operand>, kMaxWidth + 1> unused;  // the first registers of free blocks of each width
  std::vector<bool> is_free(code.size(), false);
  const auto release = [&](int i, int reader) {
    if (last_reader[size_t(i)] != reader || is_free[size_t(i)]) return;
    is_free[size_t(i)] = true;
    unused[info(code[size_t(i)].op).width].push_back(registers_[size_t(code[size_t(i)].out)]);
  };
  for (int i = 0; i < int(code.size()); ++i) {
    const Instruction& instruction = code[size_t(i)];
    const int width = info(instruction.op).width;
    Operand first = register_count_;
    if (unused[size_t(width)].empty()) {
      register_count_ += width;
    } else {
      first = unused[size_t(width)].back();
      unused[size_t(width)].pop_back();
    }
    for (int k = 0; k < width; ++k) registers_[size_t(instruction.out + k)] = first + k;
    // After the result has its registers, so that an instruction never overwrites its own inputs.
    for (const Operand value : instruction.in)
      if (value >= 0 && value != kNoOperand) release(writer[size_t(value)], i);
    release(i, i);
  }
}

void RegisterAllocation::apply(std::vector<Instruction>& code) const {
  for (Instruction& instruction : code) {
    instruction.out = registers_[size_t(instruction.out)];
    for (Operand& value : instruction.in) value = (*this)(value);
  }
}

}  // namespace ajar
