// Bump mapping (Blinn 1978; Mikkelsen 2010) by finite differences. The instructions of the height are executed at the
// point and at two points beside it, in the plane of the triangle.
#pragma once

#include <array>

#include "description/scene_description.h"
#include "shading/bsdf/shading_point.h"

namespace ajar {

/// The step of the finite differences: the width of a camera pixel times the socket Filter Width, as in Cycles. It
/// depends only on the position, so that paths from the eye and from lights get the same normal. Cycles measures the
/// pixel along the path.
struct BumpFootprint {
  bool used = false, measured = false;
  CameraKind camera = CameraKind::Perspective;
  Mat4 camera_from_world{1.0f};
  float pixel = 1e-3f;  ///< width of a pixel: at distance 1, or everywhere for an orthographic camera
  static constexpr int kMostWidths = 4;
  std::array<float, kMostWidths> filter_widths{1.0f, 1.0f, 1.0f, 1.0f};  ///< different values of Filter Width
  int widths = 0;  ///< their number; without any, images are filtered by the first
};

}  // namespace ajar

namespace ajar::nodes {

enum class DisplacementSpace : uint8_t { World, Object, Tangent };

struct BumpOffsets {
  Vec3 x, y;  ///< perpendicular to each other and to the geometric normal; their length is the step
};
/// The width of a camera pixel at the point: the mean over both directions of the image.
float pixel_width(const ShadingPoint& point, const BumpFootprint& footprint);
BumpOffsets bump_offsets(const ShadingPoint& point, const BumpFootprint& footprint, float filter_width);
/// The point, moved in its plane. Position and barycentric coordinates change; normals do not.
ShadingPoint shifted(const ShadingPoint& point, Vec3 offset);

/// Heights at a point and at both offsets. Heights times a distance are in metres.
struct BumpHeights {
  float here, x, y;
};
/// The point on the surface before its displacement (BuiltMesh::undisplaced).
ShadingPoint undisplaced(const ShadingPoint& point);
/// `normal`, tilted against the slope of the heights, with length 1.
Vec3 bump(const BumpOffsets& offsets, const BumpHeights& heights, float strength, float distance, Vec3 normal);

/// The displacement of the surface in world space: along the normal, or as a vector in a given space.
Vec3 displacement(const ShadingPoint& point, DisplacementSpace space, float amount, Vec3 normal);
Vec3 vector_displacement(const ShadingPoint& point, DisplacementSpace space, Vec3 vector);

}  // namespace ajar::nodes
