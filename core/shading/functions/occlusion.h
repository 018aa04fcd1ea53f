// The unoccluded fraction of the directions around a point: the Ambient Occlusion node (Zhukov et al. 1998).
#pragma once

#include "shading/bsdf/shading_point.h"

namespace ajar::nodes {

struct OcclusionParameters {
  float distance;  ///< length of the rays in metres
  int samples;
  bool inside, only_local;  ///< inside: the rays start below the surface; only_local: only the object itself occludes
};

/// The fraction of `samples` cosine-distributed rays around `normal` that hit nothing. The rays depend only on the
/// position, so that paths from the eye and from lights get the same value, and every position has its own rays. 1 if
/// there is no scene.
float openness(const ShadingPoint& point, const OcclusionParameters& parameters, Vec3 normal);

}  // namespace ajar::nodes
