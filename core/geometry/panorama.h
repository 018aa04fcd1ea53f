// Panoramic projections: where on the unit square of the film a direction lies, and back.
//
// Directions are the camera's own: it looks along -z, y is up, x to the right; (u, v) are in [0, 1], v up. The
// definitions are Cycles' (intern/cycles/kernel/camera/projection.h), so that pictures lie on each other. `density` is
// what joins paths to the film: |d(u, v) / d(solid angle)|. Radial projections r(theta) have r (dr/dtheta) /
// sin(theta).
#pragma once

#include <optional>

#include "description/scene_description.h"

namespace ajar {

class Panorama {
 public:
  Panorama() = default;
  explicit Panorama(const PanoramaDescription& description) : d_(description) {}

  bool is_mirror_ball() const { return d_.kind == PanoramaKind::MirrorBall; }
  /// Unit direction seen at a point of the film; empty where the projection ends.
  std::optional<Vec3> direction_of(Vec2 uv) const;
  /// Where a unit direction is seen; empty where nowhere. Of kinds without `has_inverse`, empty always.
  std::optional<Vec2> film_of(Vec3 direction) const;
  /// Area of (u, v) per steradian.
  float density(Vec3 direction) const;
  /// Is every direction seen at no more than one point of the film, enlarged by `margin` (in u, v) on each side, and
  /// does film_of find it?
  bool has_inverse(Vec2 margin) const;

 private:
  PanoramaDescription d_;
};

}  // namespace ajar
