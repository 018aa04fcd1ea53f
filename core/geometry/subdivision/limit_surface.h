// The surface that adaptive subdivision divides: that of Catmull and Clark with creases, evaluated by OpenSubdiv at any
// point, or the faces as they are.
//
// The surface consists of patches over the unit square. A face with four corners is one patch, with its corners at
// (0, 0), (1, 0), (1, 1), (0, 1). Any other face has one patch for each corner: from the corner over the middle of the
// next edge and the middle of the face to the middle of the previous edge.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

struct SurfacePatch {
  uint32_t face = 0;
  uint32_t first_corner = 0;  ///< of the face
  uint32_t corner = 0;        ///< within the face; 0 for the patch of a whole face
  uint32_t size = 4;          ///< corners of the face
  bool whole() const { return size == 4; }
};

/// A point of the surface, by its patch.
struct PatchPoint {
  uint32_t patch = 0;
  Vec2 uv{0.0f};
};

/// The patches of a mesh, in the order of its faces.
std::vector<SurfacePatch> patches_of(const SubdivisionDescription& subdivision);

/// The weights of the corners of a face at a point of one of its patches, without smoothing. Returns the sum of
/// `value(corner of the mesh)` by these weights.
template <class Function>
auto interpolate_face(const SurfacePatch& patch, Vec2 uv, const Function& value) {
  const auto corner = [&](uint32_t k) { return value(patch.first_corner + k % patch.size); };
  const float u = uv.x, v = uv.y;
  if (patch.whole())
    return (corner(0) * (1.0f - u) + corner(1) * u) * (1.0f - v) + (corner(3) * (1.0f - u) + corner(2) * u) * v;
  auto centre = corner(0);
  for (uint32_t k = 1; k < patch.size; ++k) centre = centre + corner(k);
  const auto own = corner(patch.corner);
  const auto next = (own + corner(patch.corner + 1)) * 0.5f;
  const auto previous = (own + corner(patch.corner + patch.size - 1)) * 0.5f;
  return (own * (1.0f - u) + next * u) * (1.0f - v) + (previous * (1.0f - u) + centre * (u / float(patch.size))) * v;
}

class LimitSurface {
 public:
  virtual ~LimitSurface() = default;
  /// Position and normal, which has any length. The normal of a surface without smoothing is 0.
  virtual Vec3 position(PatchPoint point) const = 0;
  virtual void evaluate(PatchPoint point, Vec3& position, Vec3& normal) const = 0;
  /// Values of attributes that are smooth with the surface: attributes of vertices that are positions, and UV maps.
  /// `is_smooth` tells which attributes these are; the others follow `interpolate_face`.
  virtual bool is_smooth(size_t attribute) const = 0;
  virtual Vec3 smooth_value(size_t attribute, PatchPoint point) const = 0;
};

/// The surface of a mesh that outlives it. Sets `is_damaged` if the faces cannot be smoothed; they are then as they are.
std::unique_ptr<const LimitSurface> make_limit_surface(const MeshDescription& mesh,
                                                       std::span<const SurfacePatch> patches, bool& is_damaged);

}  // namespace ajar
