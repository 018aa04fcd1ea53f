#include "geometry/camera.h"

#include <algorithm>

#include "geometry/deformation.h"
#include "math/warps.h"

namespace ajar {

namespace {

/// Removes the scale: the scale of a camera does not change its image.
Mat4 without_scale(Mat4 matrix) {
  for (int axis = 0; axis < 3; ++axis) {
    const float len = glm::length(Vec3(matrix[axis]));
    if (len > 0.0f) matrix[axis] /= len;
  }
  return matrix;
}

/// x, reflected at 0 and at `end` until it is between them.
float mirrored(float x, float end) {
  if (!(end > 0.0f)) return 0.0f;
  const float period = std::fmod(std::abs(x), 2.0f * end);
  return period > end ? 2.0f * end - period : period;
}

}  // namespace

Camera::Camera(const CameraDescription& description, int width, int height)
    : kind_(description.kind),
      panorama_(description.panorama),
      texels_(description.texels),
      world_from_camera_(without_scale(to_matrix(description.world_from_camera))),
      shutter_(description.shutter),
      width_(width),
      height_(height),
      window_(description.screen_window),
      row_exposure_(glm::clamp(description.row_exposure, 0.0f, 1.0f)),
      stereo_(description.stereo),
      clip_start_(description.clip_start),
      clip_end_(description.clip_end),
      lens_radius_(description.aperture_radius),
      focus_distance_(description.focus_distance),
      blades_(description.blades),
      blade_rotation_(description.blade_rotation),
      aperture_ratio_(description.aperture_ratio) {
  // A curve with a time outside the shutter interval, or with NaN, is ignored.
  if (!std::all_of(shutter_.begin(), shutter_.end(), [](float t) { return t >= 0.0f && t <= 1.0f; })) shutter_.clear();
  if (description.motion.size() > 1)
    for (const auto& rows : description.motion) motion_.push_back(split(without_scale(to_matrix(rows))));
  if (description.frames.size() == 2)
    for (const auto& rows : description.frames) frames_.push_back(glm::affineInverse(without_scale(to_matrix(rows))));
  camera_from_world_ = glm::inverse(world_from_camera_);
  pixel_area_ = pixel_area(window_);
  if (description.window_motion.size() > 1 && kind_ != CameraKind::Panorama) windows_ = description.window_motion;
  if (lens_radius_ > 0.0f && kind_ == CameraKind::Orthographic) lens_depth_ = clip_start_;
  if (lens_radius_ > 0.0f) {
    const float unit = blades_ < 3 ? kPi : 0.5f * float(blades_) * std::sin(2.0f * kPi / float(blades_));
    pdf_lens_area_ = aperture_ratio_ / (unit * sqr(lens_radius_));
  }
}

float Camera::time_of(float u) const {
  if (shutter_.size() < 2) return u;
  const float place = u * float(shutter_.size() - 1);
  const size_t first = std::min(size_t(place), shutter_.size() - 2);
  return shutter_[first] + (place - float(first)) * (shutter_[first + 1] - shutter_[first]);
}

Vec4 Camera::window(float time) const {
  if (!zooms()) return window_;
  const KeyPair at = keys_at(time, windows_.size());
  return (1.0f - at.share) * windows_[at.first] + at.share * windows_[at.first + 1];
}

/// Transforms a ray from camera space at the time of the ray.
Ray Camera::to_world(Ray ray) const {
  Mat4 moved;
  if (is_carried()) moved = pose(ray.time);
  const Mat4& frame = is_carried() ? moved : world_from_camera_;
  ray.origin = transform_point(frame, ray.origin);
  ray.direction = glm::normalize(transform_vector(frame, ray.direction));
  return ray;
}

/// Moves a ray of spherical stereoscopy from the centre to its eye, and turns it to the point where the rays of both eyes
/// meet. `up`: the axis around which the eyes turn.
Ray Camera::from_eye(Ray ray, Vec3 up) const {
  float offset = stereo_.offset;
  if (stereo_.merge_to > 0.0f) {
    const float altitude = std::abs(std::asin(glm::clamp(glm::dot(ray.direction, up), -1.0f, 1.0f)));
    if (altitude > stereo_.merge_to)
      offset = 0.0f;
    else if (altitude > stereo_.merge_from)
      offset *= std::cos(0.5f * kPi * (altitude - stereo_.merge_from) / (stereo_.merge_to - stereo_.merge_from));
  }
  const Vec3 right = glm::cross(ray.direction, up);
  const float len = glm::length(right);
  if (offset == 0.0f || !(len > 0.0f)) return ray;
  const Vec3 moved = right * (offset / len);
  ray.origin += moved;
  if (stereo_.convergence > 0.0f) ray.direction = glm::normalize(stereo_.convergence * ray.direction - moved);
  return ray;
}

Vec2 Camera::sample_lens(Vec2 u) const {
  if (!has_lens()) return Vec2(0.0f);
  Vec2 p;
  if (blades_ < 3) {
    p = warp::square_to_disk(u);
  } else {
    // A regular polygon: choose the triangle of a blade, then a uniform point in it. The rotation is the angle of the
    // first blade, as in Cycles.
    const float scaled = u.x * float(blades_);
    const int blade = std::min(int(scaled), blades_ - 1);
    const Vec2 b = warp::square_to_triangle({std::min(scaled - float(blade), kOneMinusEpsilon), u.y});
    const float step = 2.0f * kPi / float(blades_), a0 = (float(blade) - 0.5f) * step + blade_rotation_, a1 = a0 + step;
    p = b.x * Vec2(std::cos(a0), std::sin(a0)) + b.y * Vec2(std::cos(a1), std::sin(a1));
  }
  return {lens_radius_ * p.x / aperture_ratio_, lens_radius_ * p.y};
}

Vec3 Camera::lens_point(Vec2 lens, float time) const {
  if (!has_lens() || lens_turns()) return is_carried() ? Vec3(pose(time)[3]) : position();
  return transform_point(pose(time), Vec3(lens, -lens_depth_));
}

Vec3 Camera::orthographic_direction(Vec2 lens, float time) const {
  if (!has_lens()) return forward(time);
  return glm::normalize(transform_vector(pose(time), Vec3(-lens, -focus_distance_)));
}

std::optional<Vec2> Camera::film_of(Vec2 lens, Vec3 p, float time) const {
  const Vec3 local = transform_point(inverse_pose(time), p);
  if (kind_ == CameraKind::Panorama) {
    const float distance = glm::length(local);
    if (!(distance >= clip_start_ && distance <= clip_end_ && distance > 0.0f)) return std::nullopt;
    const auto found = panorama_.film_of(local / distance);
    return found ? std::optional(on_film(*found, window_)) : std::nullopt;
  }
  const float depth = -local.z;
  if (!(depth >= clip_start_ && depth <= clip_end_ && depth > 0.0f)) return std::nullopt;
  Vec2 window(local);
  if (has_lens()) {
    // The ray passes through the point in focus, whose position on the window is the same for all lens points.
    window = lens + (window - lens) * (focus_distance_ / depth);
    if (is_orthographic())
      window = Vec2(local) - lens * (1.0f - (depth - lens_depth_) / focus_distance_);
    else
      window /= focus_distance_;
  } else if (!is_orthographic()) {
    window /= depth;
  }
  return on_film(window, this->window(time));
}

std::optional<Vec2> Camera::film_at_frame(Vec3 p, int frame) const {
  const bool other = frame != 0 && !frames_.empty();
  const Vec3 local = transform_point(other ? frames_[frame > 0 ? 1 : 0] : camera_from_world_, p);
  if (kind_ == CameraKind::Panorama) {
    const float distance = glm::length(local);
    const auto found = distance > 0.0f ? panorama_.film_of(local / distance) : std::nullopt;
    return found ? std::optional(on_film(*found, window_)) : std::nullopt;
  }
  if (is_orthographic()) return on_film(Vec2(local), window_);
  if (!(-local.z > 0.0f)) return std::nullopt;
  return on_film(Vec2(local) / -local.z, window_);
}

bool Camera::finds_film(float margin) const {
  if (stereo_.offset != 0.0f) return false;
  if (kind_ != CameraKind::Panorama) return !sees_texels();
  const Vec2 beyond = margin * Vec2(window_.y - window_.x, window_.w - window_.z) / Vec2(float(width_), float(height_));
  return !has_lens() && panorama_.has_inverse(beyond);
}

float Camera::film_density(Vec3 direction, float time) const {
  if (kind_ == CameraKind::Panorama)
    return panorama_.density(transform_vector(inverse_pose(time), direction)) / pixel_area_;
  const float cos_theta = glm::dot(direction, forward(time));
  if (!(cos_theta > 0.0f)) return 0.0f;
  const float area = zooms() ? pixel_area(window(time)) : pixel_area_;
  return is_orthographic() ? 1.0f / (area * cos_theta) : 1.0f / (area * cos_theta * cos_theta * cos_theta);
}

Ray Camera::generate_ray(Vec2 film, Vec2 u_lens, float time) const {
  return ray_through(film, sample_lens(u_lens), time);
}

/// The lens is perpendicular to each direction. Its first axis is the projection of the camera's axis on it, or that of
/// x for mirror balls, as in Cycles.
Ray Camera::panoramic_ray(Vec2 film, Vec2 lens, float time) const {
  Ray ray;
  ray.time = time;
  ray.origin = position();
  ray.direction = forward();
  ray.t_max = -1.0f;
  const auto seen = panorama_.direction_of(on_window(film, window_));
  if (!seen) return ray;
  Vec3 origin(0.0f), direction = *seen;
  if (has_lens()) {
    const Vec3 axis = panorama_.is_mirror_ball() ? Vec3(1.0f, 0.0f, 0.0f) : Vec3(0.0f, 0.0f, -1.0f);
    Vec3 u = axis - glm::dot(axis, direction) * direction;
    const float len = glm::length(u);
    u = len > 1e-6f ? u / len : Vec3(0.0f, 1.0f, 0.0f);
    const Vec3 v = glm::cross(direction, u);
    const Vec3 focus = direction * focus_distance_;
    origin = u * lens.x + v * lens.y;
    direction = glm::normalize(focus - origin);
  }
  ray.origin = origin;
  ray.direction = direction;
  ray.t_min = clip_start_;
  ray.travelled = -ray.t_min;  // lengths of rays start at the clipping plane, as in Cycles
  ray.t_max = clip_end_;
  if (stereo_.offset != 0.0f) [[unlikely]]
    ray = from_eye(ray, Vec3(0.0f, 1.0f, 0.0f));
  return to_world(ray);
}

/// A point of the film that is outside the triangle of its pixel is reflected at its edges, as in Cycles.
Ray Camera::texel_ray(Vec2 film, float time) const {
  Ray ray;
  ray.time = time;
  ray.direction = Vec3(0.0f, 0.0f, -1.0f);
  ray.t_max = -1.0f;
  const int x = glm::clamp(int(std::floor(film.x)), 0, width_ - 1),
            y = glm::clamp(int(std::floor(film.y)), 0, height_ - 1);
  const Texel& texel = texels_[size_t(y) * size_t(width_) + size_t(x)];
  if (!texel.shown) return ray;
  const Vec2 offset = film - Vec2(float(x) + 0.5f, float(y) + 0.5f);
  Vec2 b = texel.barycentric + offset.x * texel.dx + offset.y * texel.dy;
  b.x = mirrored(b.x, 1.0f);
  b.y = mirrored(b.y, 1.0f - b.x);
  const auto at = [&](const std::array<Vec3, 3>& corners) {
    return b.x * corners[0] + b.y * corners[1] + (1.0f - b.x - b.y) * corners[2];
  };
  const auto& [p, q, r] = texel.corners;
  const Vec3 place = at(texel.corners), to_eye = glm::normalize(at(texel.eye));
  // Above the rounding errors of positions, and near enough that other surfaces do not come between.
  const float size = std::max({glm::length(p - q), glm::length(q - r), glm::length(r - p)});
  const float distance = 4e-6f * std::max({std::abs(place.x), std::abs(place.y), std::abs(place.z)}) + 1e-5f * size;
  ray.origin = place + distance * to_eye;
  ray.direction = -to_eye;
  ray.t_min = 0.0f;
  ray.t_max = 2.0f * distance;
  return ray;
}

Ray Camera::ray_through(Vec2 film, Vec2 lens, float time) const {
  if (kind_ == CameraKind::Panorama) return panoramic_ray(film, lens, time);
  if (sees_texels()) return texel_ray(film, time);
  const Vec2 window = on_window(film, zooms() ? this->window(time) : window_);
  Vec3 origin(0.0f), direction(window, -1.0f);
  if (kind_ == CameraKind::Orthographic) {
    origin = Vec3(window, -lens_depth_);
    direction = Vec3(0.0f, 0.0f, -1.0f);
  }
  if (lens_radius_ > 0.0f) {
    const Vec3 focus = origin + direction * focus_distance_;
    origin += Vec3(lens, 0.0f);
    direction = focus - origin;
  }
  const float len = glm::length(direction);
  Ray ray;
  ray.origin = origin;
  ray.direction = direction;
  // Clipping planes are perpendicular to the view axis.
  const float along = len / std::abs(direction.z);
  ray.t_min = (clip_start_ - lens_depth_) * along;
  ray.travelled = -ray.t_min;
  ray.t_max = (clip_end_ - lens_depth_) * along;
  ray.time = time;
  ray = to_world(ray);
  // The eyes of other cameras than panoramas turn around the vertical of the world, as in Cycles.
  const bool turns = stereo_.offset != 0.0f && kind_ == CameraKind::Perspective;
  return turns ? from_eye(ray, Vec3(0.0f, 0.0f, 1.0f)) : ray;
}

}  // namespace ajar
