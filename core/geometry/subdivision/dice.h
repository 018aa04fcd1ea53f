// Adaptive subdivision: a mesh of faces becomes a mesh of triangles.
#pragma once

#include <atomic>

#include "geometry/subdivision/dicing_plan.h"

namespace ajar {

struct DicingReport {
  bool is_damaged = false;  ///< the faces could not be smoothed
  float coarser = 1.0f;     ///< factor of the lengths of edges, because there would be too many triangles
};

/// The triangles of `mesh`, whose subdivision is not empty. Attributes of vertices, corners and faces are interpolated:
/// positions and UV maps with the surface, others linearly. Stops early if `stop` becomes true; the result is then
/// undefined.
MeshDescription dice(const MeshDescription& mesh, const DicingRate& rate, DicingReport& report,
                     const std::atomic<bool>* stop = nullptr);

/// About the number of triangles that `dice` makes, from the areas of the faces.
double estimate_diced_triangles(const MeshDescription& mesh, const DicingRate& rate);

}  // namespace ajar
