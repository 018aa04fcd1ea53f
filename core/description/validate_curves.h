// The validation of strands and point clouds, and what it shares with that of meshes. Only validate.cpp and
// validate_curves.cpp include this file.
#pragma once

#include <string>

#include "description/validate.h"

namespace ajar {

inline std::string count_of(uint64_t n, const char* what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}
/// Removes attributes whose length does not match the mesh. Returns the number of replaced values in the others.
uint64_t validate_attributes(MeshDescription& mesh, Diagnostics& diagnostics);
void validate_strands(MeshDescription& mesh, ValidationCounts& counts, Diagnostics& diagnostics);
void validate_points(MeshDescription& mesh, ValidationCounts& counts, Diagnostics& diagnostics);

}  // namespace ajar
