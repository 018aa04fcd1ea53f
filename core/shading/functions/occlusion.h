// How much of the surroundings a point sees: the Ambient Occlusion node (Zhukov et al. 1998).
#pragma once

#include "shading/bsdf/shading_point.h"

namespace ajar::nodes {

struct OcclusionParameters {
  float distance;  ///< metres that the rays go
  int samples;
  bool inside, only_local;  ///< below the surface; only the object itself is in the way
};

/// Share of so many rays, by the cosine around `normal`, that meet nothing. Which rays, the place alone decides: paths
/// that find it from either end agree, and every place has its own. 1 where there is no scene.
float openness(const ShadingPoint& point, const OcclusionParameters& parameters, Vec3 normal);

}  // namespace ajar::nodes
