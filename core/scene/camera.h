// From a point on the film to a ray, and back.
//
// Film coordinates are pixels of the full frame, y up, pixel (i, j) covering
// [i, i+1) x [j, j+1). Perspective and orthographic with a thin lens (polygonal blades, anamorphic ratio).
#pragma once

#include <optional>

#include "scene/scene_description.h"

namespace ajar {

class Camera {
 public:
  Camera() = default;
  Camera(const CameraDescription& description, int width, int height);

  /// Ray through film point `film`, lens point from `u_lens`. Clipping is in t_min, t_max.
  Ray generate_ray(Vec2 film, Vec2 u_lens, float time) const;

  /// Importance sampling of the lens from a point in the scene, for paths from lights.
  /// Importance is per film pixel: We integrates to one over the pixels' ray space.
  struct LensSample {
    Vec3 position, wi;          ///< on the lens; direction from p to the lens
    float distance;
    Vec2 film;
    float importance;           ///< We(lens -> p), pixels per (area * solid angle)
    float pdf_solid_angle;      ///< of choosing wi, seen from p (1 for a pinhole, see `delta`)
    bool delta;
  };
  std::optional<LensSample> sample_wi(Vec3 p, Vec2 u_lens) const;
  /// Film point seen by a ray from the lens, if inside the frame.
  std::optional<Vec2> film_of(const Ray& ray_from_lens) const;
  /// Density per solid angle of generate_ray's direction for a film point drawn uniformly over the frame.
  float pdf_solid_angle(Vec3 direction) const;

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
