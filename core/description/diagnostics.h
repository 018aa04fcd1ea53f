// What goes wrong with a scene: errors that stop a render, and messages for the artist that do not.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace ajar {

/// A scene that cannot be rendered; the text names the artist's object.
class SceneError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Thrown out of long work when the stop flag was raised.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

/// Messages for the artist, each once. `object` is the name of a material, object, image, ...
struct Diagnostic {
  enum class Severity : uint8_t { Info, Warning, Error } severity = Severity::Warning;
  std::string object;
  std::string message;
};
using Diagnostics = std::vector<Diagnostic>;
void report_once(Diagnostics& diagnostics, Diagnostic diagnostic);

}  // namespace ajar
