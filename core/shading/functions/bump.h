// Bump mapping (Blinn 1978; Mikkelsen 2010) by finite differences: the height's instructions run at the point and at
// two places beside it in the plane of the triangle.
#pragma once

#include "description/scene_description.h"
#include "shading/bsdf/shading_point.h"

namespace ajar {

/// How far beside a point bump mapping looks: about a pixel of the camera, as in Cycles, but a function of the place
/// alone, so that paths found from either end agree. Cycles measures along the path.
struct BumpFootprint {
  bool used = false, measured = false;
  CameraKind camera = CameraKind::Perspective;
  Mat4 camera_from_world{1.0f};
  float pixel = 1e-3f;  ///< width of a pixel: at distance 1, or anywhere when orthographic
};

}  // namespace ajar

namespace ajar::nodes {

enum class DisplacementSpace : uint8_t { World, Object, Tangent };

struct BumpOffsets {
  Vec3 x, y;  ///< at right angles to each other and to the geometric normal, as long as the footprint
};
/// Width of a camera's pixel at the point, half the sum over both directions of the image.
float pixel_width(const ShadingPoint& point, const BumpFootprint& footprint);
BumpOffsets bump_offsets(const ShadingPoint& point, const BumpFootprint& footprint);
/// The point moved in its plane: position and barycentric coordinates follow, normals stay.
ShadingPoint shifted(const ShadingPoint& point, Vec3 offset);

/// `normal` turned against the slope of the heights, which are in metres once multiplied by `distance`.
Vec3 bump(const ShadingPoint& point, const BumpFootprint& footprint, float height, float height_x, float height_y,
          float strength, float distance, Vec3 normal);

/// World-space vector by which the surface is moved: along the normal, or as given in a space.
Vec3 displacement(const ShadingPoint& point, DisplacementSpace space, float amount, Vec3 normal);
Vec3 vector_displacement(const ShadingPoint& point, DisplacementSpace space, Vec3 vector);

}  // namespace ajar::nodes
