// The differences between Embree 3 and 4. Only accel.cpp and the files that make its geometries include this file.
#pragma once

#if AJAR_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace ajar::embree {

#if AJAR_EMBREE_MAJOR >= 4
inline void intersect(RTCScene scene, RTCRayHit& query, bool coherent) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  if (coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect1(scene, &query, &arguments);
}
inline void occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray); }
#else
inline void intersect(RTCScene scene, RTCRayHit& query, bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect1(scene, &context, &query);
}
inline void occluded(RTCScene scene, RTCRay& ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
}
#endif

}  // namespace ajar::embree
