// Errors of a scene that stop a render, and messages for the artist that do not.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace ajar {

/// A scene that cannot be rendered. The text names the object by the artist's name.
class SceneError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Thrown from long computations after the stop flag was set.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

/// A message for the artist. `object` is the name of a material, an object, an image or another part of the scene.
struct Diagnostic {
  enum class Severity : uint8_t { Info, Warning, Error } severity = Severity::Warning;
  std::string object;
  std::string message;
};
using Diagnostics = std::vector<Diagnostic>;
/// Adds the message unless it is already there.
void report_once(Diagnostics& diagnostics, Diagnostic diagnostic);

}  // namespace ajar
