// What nodes find out with rays of their own. The rays depend only on the position, so that paths from the eye and from
// lights get the same value, and every position has its own rays.
#pragma once

#include <string>

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

struct RaycastHit {
  bool found = false, own = false;  ///< own: the ray hit the point's object
  float distance = 0.0f;            ///< in lengths of the direction; without a hit, the length of the ray
  Vec3 normal{0.0f};                ///< smooth, towards the origin of the ray; zero without a hit
};

struct RaycastParameters {
  Vec3 origin, direction;
  float length;     ///< in lengths of the direction
  bool only_local;  ///< only the point's own object is hit
};

/// Raycast of Blender 5.2: the nearest object on the ray from the origin, whatever its visibility. A ray from the point itself
/// does not hit the surface of the point. Nothing is found if there is no scene.
RaycastHit raycast(const ShadingPoint& point, const RaycastParameters& parameters);
/// The value of an attribute where the ray hits; zero without a hit. Without the attribute it is that of the node Attribute.
Vec4 attribute_at_hit(const ShadingPoint& point, const RaycastParameters& parameters, const std::string& name);

}  // namespace ajar::nodes
