#include "scene/lamp_geometry.h"

#include <bit>
#include <cstring>

#include "lights/sources/lamp.h"

namespace ajar {

namespace {

Vec3 origin_of(RTCRayN* ray, unsigned n, unsigned i) {
  return {RTCRayN_org_x(ray, n, i), RTCRayN_org_y(ray, n, i), RTCRayN_org_z(ray, n, i)};
}
Vec3 direction_of(RTCRayN* ray, unsigned n, unsigned i) {
  return {RTCRayN_dir_x(ray, n, i), RTCRayN_dir_y(ray, n, i), RTCRayN_dir_z(ray, n, i)};
}

/// Ellipses are quads without their corners.
void reject_outside_ellipse(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    const float u = 2.0f * RTCHitN_u(args->hit, args->N, i) - 1.0f, v = 2.0f * RTCHitN_v(args->hit, args->N, i) - 1.0f;
    if (u * u + v * v > 1.0f) args->valid[i] = 0;
  }
}

/// A ray sees a sphere once: where it enters or, with an origin inside, where it leaves.
void accept_one_side_of_sphere(const RTCFilterFunctionNArguments* args) {
  const Light& sphere = *static_cast<const Light*>(args->geometryUserPtr);
  const unsigned n = args->N;
  for (unsigned i = 0; i < n; ++i) {
    if (args->valid[i] != -1) continue;
    const Vec3 direction = direction_of(args->ray, n, i), from_center = origin_of(args->ray, n, i) - sphere.position;
    const Vec3 ng(RTCHitN_Ng_x(args->hit, n, i), RTCHitN_Ng_y(args->hit, n, i), RTCHitN_Ng_z(args->hit, n, i));
    const bool inside = length_squared(from_center) <= sqr(sphere.radius), leaves = glm::dot(ng, direction) > 0.0f;
    if (inside != leaves) args->valid[i] = 0;
  }
}

void bounds_of_soft(const RTCBoundsFunctionArguments* args) {
  const Light& lamp = *static_cast<const Light*>(args->geometryUserPtr);
  const Vec3 lower = lamp.position - lamp.radius, upper = lamp.position + lamp.radius;
  args->bounds_o->lower_x = lower.x;
  args->bounds_o->lower_y = lower.y;
  args->bounds_o->lower_z = lower.z;
  args->bounds_o->upper_x = upper.x;
  args->bounds_o->upper_y = upper.y;
  args->bounds_o->upper_z = upper.z;
}

void intersect_soft(const RTCIntersectFunctionNArguments* args) {
  const unsigned n = args->N;
  RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, n);
  RTCHitN* hits = RTCRayHitN_HitN(args->rayhit, n);
  for (unsigned i = 0; i < n; ++i) {
    if (args->valid[i] != -1) continue;
    Ray ray;
    ray.origin = origin_of(rays, n, i);
    ray.direction = direction_of(rays, n, i);
    ray.t_min = RTCRayN_tnear(rays, n, i);
    ray.t_max = RTCRayN_tfar(rays, n, i);
    ray.travelled = std::bit_cast<float>(RTCRayN_id(rays, n, i));
    const auto crossing = intersect_lamp_shape(*static_cast<const Light*>(args->geometryUserPtr), ray);
    if (!crossing) continue;
    RTCRayN_tfar(rays, n, i) = crossing->t;
    RTCHitN_Ng_x(hits, n, i) = crossing->normal.x;
    RTCHitN_Ng_y(hits, n, i) = crossing->normal.y;
    RTCHitN_Ng_z(hits, n, i) = crossing->normal.z;
    RTCHitN_primID(hits, n, i) = args->primID;
    RTCHitN_geomID(hits, n, i) = args->geomID;
    RTCHitN_instID(hits, n, i, 0) = RTC_INVALID_GEOMETRY_ID;
  }
}

}  // namespace

bool has_shape(const Light& light) {
  return is_sphere(light.type) || light.type == LightType::Rectangle || light.type == LightType::Ellipse;
}

RTCGeometry lamp_geometry(RTCDevice device, const Light& light) {
  RTCGeometry geometry;
  if (light.soft) {
    geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, 1);
    rtcSetGeometryBoundsFunction(geometry, bounds_of_soft, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect_soft);
  } else if (is_sphere(light.type)) {
    geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    auto* point = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 16, 1));
    std::memcpy(point, &light.position, 12);
    point[3] = light.radius;
    rtcSetGeometryIntersectFilterFunction(geometry, accept_one_side_of_sphere);
  } else {
    geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
    auto* corners = static_cast<Vec3*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 4));
    auto* index = static_cast<uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 16, 1));
    corners[0] = light.position - light.edge1 - light.edge2;
    corners[1] = light.position + light.edge1 - light.edge2;
    corners[2] = light.position + light.edge1 + light.edge2;
    corners[3] = light.position - light.edge1 + light.edge2;
    for (uint32_t k = 0; k < 4; ++k) index[k] = k;
    if (light.type == LightType::Ellipse) rtcSetGeometryIntersectFilterFunction(geometry, reject_outside_ellipse);
  }
  rtcSetGeometryUserData(geometry, const_cast<Light*>(&light));
  rtcSetGeometryMask(geometry, light.visibility);
  return geometry;
}

}  // namespace ajar
