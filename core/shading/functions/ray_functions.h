// What nodes find out with rays of their own. The rays depend only on the position, so that paths from the eye and from
// lights get the same value, and every position has its own rays.
#pragma once

#include "shading/bsdf/shading_point.h"

namespace ajar::nodes {

struct OcclusionParameters {
  float distance;  ///< length of the rays in metres
  int samples;
  bool inside, only_local;  ///< inside: the rays start below the surface; only_local: only the object itself occludes
};

/// Ambient Occlusion (Zhukov et al. 1998): the fraction of `samples` cosine-distributed rays around `normal` that hit
/// nothing. 1 if there is no scene.
float openness(const ShadingPoint& point, const OcclusionParameters& parameters, Vec3 normal);

/// Bevel: the mean of the smooth normals of the point's own object within `radius` metres, weighted as in Cycles by
/// (radius - distance)^3, estimated with `samples` lines through the surface. The point's own normal if there is no
/// scene.
Vec3 bevelled_normal(const ShadingPoint& point, float radius, int samples);

}  // namespace ajar::nodes
