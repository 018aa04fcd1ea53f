// Gives the values of a finished program their registers. A register is used again after the last use of its value.
#pragma once

#include <memory>
#include <vector>

#include "shading/program/register_program.h"

namespace ajar {

/// The builder numbers the floats of all values; `code` is in the order of execution. `kept` are values that are read
/// after the end of the code. A part of `code`, in the same order, can use the same registers.
class RegisterAllocation {
 public:
  RegisterAllocation(const std::vector<Instruction>& code, int value_count, const std::vector<Operand>& kept);
  /// The register of a value, or the same operand if it is a constant or none.
  Operand operator()(Operand value) const { return value < 0 || value == kNoOperand ? value : registers_[value]; }
  void apply(std::vector<Instruction>& code) const;
  int register_count() const { return register_count_; }

 private:
  std::vector<Operand> registers_;
  int register_count_ = 0;
};

namespace detail {
template <class Use>
[[gnu::noinline]] auto with_many_registers(int count, Use& use) {
  const std::unique_ptr<float[]> registers(new float[size_t(count)]);
  return use(registers.get());
}
}  // namespace detail

/// Calls `use` with registers for one execution, which are not initialised. Those of nearly all programs fit the stack.
template <class Use>
[[gnu::always_inline]] inline auto with_registers(int count, Use&& use) {
  constexpr int kOnStack = 512;
  if (count > kOnStack) [[unlikely]]
    return detail::with_many_registers(count, use);
  float registers[kOnStack];
  return use(registers);
}

}  // namespace ajar
