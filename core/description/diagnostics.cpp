#include "description/diagnostics.h"

namespace ajar {

void report_once(Diagnostics& diagnostics, Diagnostic diagnostic) {
  for (const Diagnostic& known : diagnostics)
    if (known.object == diagnostic.object && known.message == diagnostic.message) return;
  diagnostics.push_back(std::move(diagnostic));
}

}  // namespace ajar
