// The buffers of Embree for strands and points.
#pragma once

#include <vector>

#include "geometry/strands.h"
#include "scene/embree.h"

namespace ajar {

/// Positions and radii, without the first `skipped`; `motion` has them at several times.
void set_keys(RTCGeometry geometry, const std::vector<Vec4>& still, const std::vector<std::vector<Vec4>>& motion,
              size_t skipped = 0);

/// Tells Embree at which ends of its straight pieces a strand goes on.
void mark_joints(RTCGeometry geometry, const Strands& strands);

}  // namespace ajar
