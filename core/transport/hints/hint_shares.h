// The hints that could have proposed a given path, and their densities.
#pragma once

#include <vector>

#include "transport/hints/hints.h"
#include "transport/paths/path.h"

namespace ajar {

/// Density with which `hint` proposes vertices 0 to end - 1 of `path`, per area at each vertex; 0 when the hint cannot
/// propose them.
double pdf_of_hint(const LightSet& lights, const Hints::Hint& hint, const Path& path, int end);

/// Adds `weight` to the hints that could have proposed `path`, in equal parts.
void add_hint_shares(const LightSet& lights, const Hints& hints, const Path& path, double weight,
                     std::vector<double>& sums);

}  // namespace ajar
