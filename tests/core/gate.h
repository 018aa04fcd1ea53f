// Which of many similar tests the gate leaves out.
#pragma once

#include <cstddef>
#include <cstdlib>

namespace ajar::fixtures {

/// What a test that is left out says.
inline constexpr const char* kLeftOut = "left out by the gate: make test-all";

/// `make test-all` runs the tests that the gate has no time for.
inline bool gate_only() { return !std::getenv("AJAR_ALL_TESTS"); }

/// Of each `of` pairs of a scene and a technique, the gate tests one: each technique in half (or a third) of the scenes,
/// and each scene with half (or a third) of the techniques. Pairs of scenes alternate, so that the gate's two processes,
/// which take tests in turn, get equal shares.
inline bool is_left_out(size_t scene, size_t technique, size_t of = 2) {
  return (scene / 2 + technique) % of != 0 && gate_only();
}

}  // namespace ajar::fixtures
