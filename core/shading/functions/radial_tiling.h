// The tiling of the plane by the sectors of a polygon around the origin, with rounded corners, as in Blender's Radial
// Tiling.
#pragma once

#include "math/types.h"

namespace ajar::nodes {

struct RadialTile {
  Vec2 place{0.0f};     ///< along the side of the polygon through the point, and the size of this polygon
  float sector = 0.0f;  ///< number of the sector, from the x axis on
  float width = 0.0f;   ///< half of the length of a side of the polygon of size 1
  float turn = 0.0f;    ///< direction of the middle of the side
};

/// `sides` of at least 2 need not be whole: the last sector is then smaller. With `normalize`, places are in [0, 1]
/// along a side; otherwise the polygon of size 1 is at 0.
RadialTile radial_tile(float sides, float roundness, bool normalize, Vec2 p);

}  // namespace ajar::nodes
