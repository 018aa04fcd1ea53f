// Panoramic projections between directions and the unit square of the film.
//
// Directions are in camera space: the camera looks along -z, y is up, x is to the right. (u, v) are in [0, 1], v up.
// The definitions are those of Cycles (intern/cycles/kernel/camera/projection.h), so that images match. `density` is
// needed to connect paths to the film: |d(u, v) / d(solid angle)|. For a radial projection r(theta) it is r (dr/dtheta)
// / sin(theta).
#pragma once

#include <optional>

#include "description/scene_description.h"

namespace ajar {

class Panorama {
 public:
  Panorama() = default;
  explicit Panorama(const PanoramaDescription& description) : d_(description) {}

  bool is_mirror_ball() const { return d_.kind == PanoramaKind::MirrorBall; }
  /// Unit direction that a point of the film sees; empty outside the projection.
  std::optional<Vec3> direction_of(Vec2 uv) const;
  /// Film point that sees a unit direction; empty if there is none. Always empty for kinds without `has_inverse`.
  std::optional<Vec2> film_of(Vec3 direction) const;
  /// Area of (u, v) per steradian.
  float density(Vec3 direction) const;
  /// Whether every direction is seen at no more than one point of the film, enlarged by `margin` (in u, v) on each
  /// side, and film_of finds that point.
  bool has_inverse(Vec2 margin) const;

 private:
  PanoramaDescription d_;
};

}  // namespace ajar
