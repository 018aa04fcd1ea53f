// From a point on the film to a ray.
//
// Film coordinates are pixels of the full frame, y up, pixel (i, j) covering
// [i, i+1) x [j, j+1). Perspective and orthographic with a thin lens (polygonal blades, anamorphic ratio).
#pragma once

#include "scene/scene_description.h"

namespace ajar {

class Camera {
 public:
  Camera() = default;
  Camera(const CameraDescription& description, int width, int height);

  /// Ray through film point `film`, lens point from `u_lens`. Clipping is in t_min, t_max.
  Ray generate_ray(Vec2 film, Vec2 u_lens, float time) const;

  bool has_lens() const { return lens_radius_ > 0.0f; }
  const Mat4& world_from_camera() const { return world_from_camera_; }
  Vec3 position() const { return Vec3(world_from_camera_[3]); }
  Vec3 forward() const { return -Vec3(world_from_camera_[2]); }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  Vec2 sample_lens(Vec2 u) const;

  CameraKind kind_ = CameraKind::Perspective;
  Mat4 world_from_camera_{1.0f}, camera_from_world_{1.0f};
  int width_ = 1, height_ = 1;
  Vec4 window_{-1, 1, -1, 1};
  float clip_start_ = 0.0f, clip_end_ = kInfinity;
  float lens_radius_ = 0.0f, focus_distance_ = 1.0f;
  int blades_ = 0;
  float blade_rotation_ = 0.0f, aperture_ratio_ = 1.0f;
};

}  // namespace ajar
