// From a point on the film to a ray.
//
// Film coordinates are pixels of the full frame, y up, pixel (i, j) covering
// [i, i+1) x [j, j+1). Perspective, orthographic and panoramic (panorama.h) with a thin lens (polygonal blades,
// anamorphic ratio).
//
// For paths that arrive from lights: a measurement is the integral of radiance over the film (in pixels^2) and the mean
// over the lens (Veach 1997, section 8.3.2.2, with the pixel as the unit of area). `film_density` converts densities
// between film and directions; where all rays through one lens point are parallel (orthographic), between the film and
// the area perpendicular to them.
#pragma once

#include <optional>

#include "geometry/motion.h"
#include "geometry/panorama.h"

namespace ajar {

/// Of a film point where the camera sees nothing, outside the circle of a fisheye: the picture is black there.
inline bool sees_nothing(const Ray& ray) { return ray.t_max < 0.0f; }

class Camera {
 public:
  Camera() = default;
  Camera(const CameraDescription& description, int width, int height);

  /// Ray through film point `film`, lens point from `u_lens`. Clipping is in t_min, t_max; see also sees_nothing.
  Ray generate_ray(Vec2 film, Vec2 u_lens, float time) const;

  /// Point of the lens in world space, uniform over its area. Of a pinhole: where it is.
  Vec3 sample_lens_point(Vec2 u_lens) const;
  /// 1 / area of the lens; 1 for a pinhole.
  float pdf_lens_area() const { return pdf_lens_area_; }
  /// All rays through one lens point are parallel.
  bool is_orthographic() const { return kind_ == CameraKind::Orthographic; }
  /// Direction of the rays through a lens point of an orthographic camera.
  Vec3 orthographic_direction(Vec3 lens_point) const;
  /// Whether film_of and film_density answer for all that is seen within `margin` pixels around the frame: only then
  /// can paths be joined to the camera. Not so where a direction is seen twice (at the seam of a full panorama) nor
  /// where the lens turns with the view.
  bool finds_film(float margin) const;
  /// Whether a point of the film sees anything.
  bool sees(Vec2 film) const {
    return kind_ != CameraKind::Panorama || panorama_.direction_of(on_window(film)).has_value();
  }
  /// Film point through which the ray from `lens_point` to p goes, perhaps outside the frame. Empty for what is behind
  /// the camera or clipped.
  std::optional<Vec2> film_of(Vec3 lens_point, Vec3 p) const;
  /// Pixels^2 per steradian of the unit direction (away from the lens); per m^2 across it for an orthographic camera.
  float film_density(Vec3 direction) const;
  /// Distance along `direction` from the lens to the near clipping plane.
  float clip_distance(Vec3 direction) const {
    return kind_ == CameraKind::Panorama ? clip_start_
                                         : (clip_start_ - lens_depth_) / std::abs(glm::dot(direction, forward()));
  }
  /// The depth pass: along the axis; from the centre of a panorama.
  float depth_of(Vec3 p) const {
    return kind_ == CameraKind::Panorama ? glm::length(p - position()) : glm::dot(p - position(), forward());
  }

  /// Ray through a film point and this point of the lens.
  Ray ray_through(Vec2 film, Vec3 lens_point, float time) const;

  bool moves() const { return motion_.size() > 1; }
  /// Time in [0, 1] of the shutter interval for a number uniform in [0, 1).
  float time_of(float u) const;
  bool has_lens() const { return lens_radius_ > 0.0f; }
  const Mat4& world_from_camera() const { return world_from_camera_; }
  Vec3 position() const { return Vec3(world_from_camera_[3]); }
  Vec3 forward() const { return -Vec3(world_from_camera_[2]); }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  Vec2 sample_lens(Vec2 u) const;
  Ray ray_from_lens(Vec2 film, Vec2 lens, float time) const;
  Ray panoramic_ray(Vec2 film, Vec2 lens, float time) const;
  Ray to_world(Ray ray) const;
  Vec2 on_window(Vec2 film) const {
    return {window_.x + (window_.y - window_.x) * film.x / float(width_),
            window_.z + (window_.w - window_.z) * film.y / float(height_)};
  }
  Vec2 on_film(Vec2 window) const {
    return {(window.x - window_.x) / (window_.y - window_.x) * float(width_),
            (window.y - window_.z) / (window_.w - window_.z) * float(height_)};
  }

  CameraKind kind_ = CameraKind::Perspective;
  Panorama panorama_;
  Mat4 world_from_camera_{1.0f}, camera_from_world_{1.0f};
  std::vector<SplitTransform> motion_;  ///< of world_from_camera_ while the shutter is open; none: still
  std::vector<float> shutter_;
  int width_ = 1, height_ = 1;
  Vec4 window_{-1, 1, -1, 1};
  float clip_start_ = 0.0f, clip_end_ = kInfinity;
  float lens_radius_ = 0.0f, focus_distance_ = 1.0f;
  /// of the lens before the camera: that of orthographic ones is at the near clipping plane, as in Cycles
  float lens_depth_ = 0.0f;
  int blades_ = 0;
  float blade_rotation_ = 0.0f, aperture_ratio_ = 1.0f;
  float pdf_lens_area_ = 1.0f;
  float pixel_area_ = 1.0f;  ///< on the plane z = -1; in m^2 for orthographic; of the unit square for panoramas
};

}  // namespace ajar
