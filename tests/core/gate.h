// Which of many similar tests the gate leaves out.
#pragma once

#include <cstddef>
#include <cstdlib>

namespace ajar::fixtures {

/// What a test that is left out says.
inline constexpr const char* kLeftOut = "left out by the gate: make test-all";

/// `make test-all` runs the tests that the gate has no time for.
inline bool gate_only() { return !std::getenv("AJAR_ALL_TESTS"); }

/// The gate tests one of `of` pairs of a scene and a technique. With 2: each technique in half of the scenes, and each
/// scene with half of the techniques. Pairs of scenes alternate, so that the gate's two processes, which take tests in
/// turn, get equal shares.
inline bool is_left_out(size_t scene, size_t technique, size_t of = 2) {
  return (scene / 2 + technique) % of != 0 && gate_only();
}

}  // namespace ajar::fixtures
