// Builds one closure from the sockets of its node.
#pragma once

#include <cstring>
#include <utility>

#include "shading/functions/point_functions.h"
#include "shading/nodes/closure.h"

namespace ajar::nodes {

/// Whether a number is a constant above 0, or computed at each point.
inline bool may_be_positive(const ProgramBuilder& builder, Value value) {
  return !value.is_constant() || builder.constant_value(value) > 0.0f;
}

/// Sets a closure's inputs: constants directly, all others by patches.
class ClosureWriter {
 public:
  ClosureWriter(ProgramBuilder& builder, int node, ClosureKind kind, Value weight) : b_(builder), node_(node) {
    closure.kind = kind;
    closure.weight = weight.at;
  }

  void set(size_t offset, Value value, int count) {
    if (value.is_constant()) {
      for (int i = 0; i < count; ++i) {
        const float x = b_.constant_value(value, i);
        std::memcpy(reinterpret_cast<char*>(&closure.inputs) + offset + i * sizeof(float), &x, sizeof x);
      }
    } else {
      closure.patches.push_back({offset, uint8_t(count), value.at});
    }
  }
  /// Reads a number or colour from the socket. If the socket is missing, the input becomes `fallback`.
  Value number(size_t offset, const char* socket, float fallback) {
    const Value value = b_.input(node_, socket, SocketType::Float, Vec4(fallback));
    set(offset, value, 1);
    return value;
  }
  Value color(size_t offset, const char* socket, Color fallback) {
    const Value value = b_.input(node_, socket, SocketType::Color, Vec4(fallback, 1.0f));
    set(offset, value, 3);
    return value;
  }
  void normal(const char* socket, Operand& target) {
    if (b_.is_linked(node_, socket)) target = b_.input(node_, socket, SocketType::Vector).at;
  }
  /// Only anisotropic closures need a tangent.
  void tangent(Value anisotropy) {
    if (anisotropy.is_constant() && b_.constant_value(anisotropy) == 0.0f) return;
    closure.tangent = b_.is_linked(node_, "Tangent")
                          ? b_.input(node_, "Tangent", SocketType::Vector).at
                          : b_.emit(Op::RadialTangent, SocketType::Vector, {}, int(Axis::Z)).at;
  }

  Closure closure;

 private:
  ProgramBuilder& b_;
  int node_;
};

}  // namespace ajar::nodes
