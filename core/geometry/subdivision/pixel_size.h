// The size of a pixel of a camera at a place in the scene: the length that adaptive subdivision gives to edges there.
//
// Pixels are those in the middle of the picture, at the distance of the place, so that the size does not depend on the
// direction. Outside the field of view the size grows with the distance from it. Both are as in Cycles.
#pragma once

#include <array>

#include "geometry/camera.h"

namespace ajar {

class PixelSize {
 public:
  PixelSize(const CameraDescription& camera, int width, int height, float offscreen_scale);
  /// In metres; `place` is in world space.
  float at(Vec3 place) const;

 private:
  float outside(Vec3 place) const;
  CameraKind kind_;
  Mat4 camera_from_world_{1.0f};
  Vec4 window_{0.0f};
  float angle_ = 1.0f;              ///< of a pixel; of an orthographic camera its size
  std::array<Vec3, 4> outwards_{};  ///< normals of the sides of the field of view, in the space of the camera
  std::array<Vec3, 4> forwards_{};  ///< directions in the sides, away from the camera
  float offscreen_scale_;
};

}  // namespace ajar
