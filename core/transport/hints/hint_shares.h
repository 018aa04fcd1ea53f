// Which hints could have made a whole path, and with what density.
#pragma once

#include <vector>

#include "transport/hints/hints.h"
#include "transport/paths/path.h"

namespace ajar {

/// Density with which `hint` proposes vertices 0 to end - 1 of `path`: per area at each vertex. 0 when the hint could
/// not have made them.
double pdf_of_hint(const LightSet& lights, const Hints::Hint& hint, const Path& path, int end);

/// Credit `weight` to the hints that could have made `path`, in equal parts.
void add_hint_shares(const LightSet& lights, const Hints& hints, const Path& path, double weight,
                     std::vector<double>& sums);

}  // namespace ajar
