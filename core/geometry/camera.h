// A camera: the ray for each point of the film.
//
// Film coordinates are pixels of the full frame, y up; pixel (i, j) covers [i, i+1) x [j, j+1). Cameras are
// perspective, orthographic or panoramic (panorama.h), with a thin lens (polygonal blades, anamorphic ratio). For baking,
// each pixel sees its own place on a surface (Texel); its ray starts just above it.
//
// For paths from lights, a measurement is the integral of radiance over the film (in pixels^2) and the mean over the
// lens (Veach 1997, section 8.3.2.2, with the pixel as the unit of area). `film_density` converts densities between
// film and directions. If all rays through one lens point are parallel (orthographic), it converts between the film and
// the area perpendicular to them.
#pragma once

#include <optional>

#include "geometry/motion.h"
#include "geometry/panorama.h"

namespace ajar {

/// Whether the camera sees nothing at a film point, such as outside the circle of a fisheye. The image is black there.
inline bool sees_nothing(const Ray& ray) { return ray.t_max < 0.0f; }

class Camera {
 public:
  Camera() = default;
  Camera(const CameraDescription& description, int width, int height);

  /// Ray through film point `film` and the lens point of `u_lens`. t_min and t_max are the clipping distances; see also
  /// sees_nothing.
  Ray generate_ray(Vec2 film, Vec2 u_lens, float time) const;

  /// Point of the lens in the lens's own plane in metres, uniform over its area; 0 for a pinhole.
  Vec2 sample_lens(Vec2 u_lens) const;
  /// That point in world space at `time`. Where the lens turns (lens_turns), the centre of the lens.
  Vec3 lens_point(Vec2 lens, float time) const;
  /// 1 / area of the lens; 1 for a pinhole.
  float pdf_lens_area() const { return pdf_lens_area_; }
  /// All rays through one lens point are parallel.
  bool is_orthographic() const { return kind_ == CameraKind::Orthographic; }
  /// Direction of the rays through a lens point of an orthographic camera.
  Vec3 orthographic_direction(Vec2 lens, float time) const;
  /// Whether film_of and film_density are valid for everything that is seen within `margin` pixels around the frame.
  /// Only then can paths be connected to the camera. It is false if a direction is seen twice (at the seam of a full
  /// panorama) or if the lens turns with the direction, as with spherical stereoscopy.
  bool finds_film(float margin) const;
  /// Whether the camera sees anything at a point of the film.
  bool sees(Vec2 film) const {
    if (sees_texels()) return !sees_nothing(texel_ray(film, 0.0f));
    return kind_ != CameraKind::Panorama || panorama_.direction_of(on_window(film, window_)).has_value();
  }
  /// Film point of the ray from lens point `lens` to p; it can be outside the frame. Empty if p is behind the camera or
  /// clipped.
  std::optional<Vec2> film_of(Vec2 lens, Vec3 p, float time) const;
  /// Pixels^2 per steradian at the unit direction (away from the lens); pixels^2 per m^2 perpendicular to it for an
  /// orthographic camera.
  float film_density(Vec3 direction, float time) const;
  /// Distance along `direction` from the lens to the near clipping plane.
  float clip_distance(Vec3 direction, float time) const {
    return kind_ == CameraKind::Panorama ? clip_start_
                                         : (clip_start_ - lens_depth_) / std::abs(glm::dot(direction, forward(time)));
  }
  /// The depth pass: distance along the camera's axis, or from the centre of a panorama.
  float depth_of(Vec3 p) const {
    return kind_ == CameraKind::Panorama ? glm::length(p - position()) : glm::dot(p - position(), forward());
  }

  /// Ray through a film point and this point of the lens.
  Ray ray_through(Vec2 film, Vec2 lens, float time) const;

  /// Film points of p one frame before and one after, through the centre of the lens; that of now if the camera does
  /// not move. Empty if it is not in front of the camera.
  std::optional<Vec2> film_at_frame(Vec3 p, int frame) const;

  bool sees_texels() const { return kind_ == CameraKind::Texels; }
  /// Whether the camera moves or zooms while the shutter is open.
  bool moves() const { return is_carried() || zooms(); }
  /// Time in [0, 1] of the shutter interval for a uniform number in [0, 1).
  float time_of(float u) const;
  /// The same for a row of the film, counted from the bottom. With a rolling shutter, rows have times of their own.
  float time_of(float u, int row) const {
    const float time = time_of(u);
    if (row_exposure_ >= 1.0f) return time;
    return row_exposure_ * time + (1.0f - row_exposure_) * (1.0f - float(row) / float(height_));
  }
  /// Whether rows of the film have times of their own.
  bool has_rolling_shutter() const { return row_exposure_ < 1.0f; }
  bool has_lens() const { return lens_radius_ > 0.0f; }
  /// The lens of a panorama is perpendicular to each direction, so that its points depend on the film point.
  bool lens_turns() const { return has_lens() && kind_ == CameraKind::Panorama; }
  const Mat4& world_from_camera() const { return world_from_camera_; }
  Vec3 position() const { return Vec3(world_from_camera_[3]); }
  Vec3 forward() const { return -Vec3(world_from_camera_[2]); }
  Vec3 forward(float time) const { return is_carried() ? -Vec3(pose(time)[2]) : forward(); }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  bool is_carried() const { return motion_.size() > 1; }
  bool zooms() const { return windows_.size() > 1; }
  /// world_from_camera at a time.
  Mat4 pose(float time) const { return is_carried() ? interpolate(motion_, time) : world_from_camera_; }
  Mat4 inverse_pose(float time) const { return is_carried() ? glm::affineInverse(pose(time)) : camera_from_world_; }
  /// screen_window at a time.
  Vec4 window(float time) const;
  float pixel_area(const Vec4& window) const {
    return std::abs((window.y - window.x) * (window.w - window.z)) / (float(width_) * float(height_));
  }
  Ray panoramic_ray(Vec2 film, Vec2 lens, float time) const;
  Ray texel_ray(Vec2 film, float time) const;
  Ray to_world(Ray ray) const;
  Ray from_eye(Ray ray, Vec3 up) const;
  Vec2 on_window(Vec2 film, const Vec4& window) const {
    return {window.x + (window.y - window.x) * film.x / float(width_),
            window.z + (window.w - window.z) * film.y / float(height_)};
  }
  Vec2 on_film(Vec2 place, const Vec4& window) const {
    return {(place.x - window.x) / (window.y - window.x) * float(width_),
            (place.y - window.z) / (window.w - window.z) * float(height_)};
  }

  CameraKind kind_ = CameraKind::Perspective;
  Panorama panorama_;
  std::vector<Texel> texels_;
  Mat4 world_from_camera_{1.0f}, camera_from_world_{1.0f};
  std::vector<SplitTransform> motion_;  ///< world_from_camera_ while the shutter is open; empty: no motion
  std::vector<float> shutter_;
  std::vector<Mat4> frames_;  ///< camera_from_world one frame before and one after; empty: no motion
  int width_ = 1, height_ = 1;
  Vec4 window_{-1, 1, -1, 1};
  std::vector<Vec4> windows_;  ///< window_ at evenly spaced times while the shutter is open; empty: it stays
  float row_exposure_ = 1.0f;
  StereoDescription stereo_;
  float clip_start_ = 0.0f, clip_end_ = kInfinity;
  float lens_radius_ = 0.0f, focus_distance_ = 1.0f;
  /// distance of the lens in front of the camera; an orthographic lens is at the near clipping plane, as in Cycles
  float lens_depth_ = 0.0f;
  int blades_ = 0;
  float blade_rotation_ = 0.0f, aperture_ratio_ = 1.0f;
  float pdf_lens_area_ = 1.0f;
  float pixel_area_ = 1.0f;  ///< on the plane z = -1; in m^2 for orthographic cameras; of the unit square for panoramas
};

}  // namespace ajar
