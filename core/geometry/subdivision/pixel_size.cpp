#include "geometry/subdivision/pixel_size.h"

#include <algorithm>
#include <cmath>

namespace ajar {

PixelSize::PixelSize(const CameraDescription& camera, int width, int height, float offscreen_scale)
    : kind_(camera.kind),
      camera_from_world_(glm::affineInverse(to_matrix(camera.world_from_camera))),
      window_(camera.screen_window),
      offscreen_scale_(offscreen_scale) {
  const float dx = (window_.y - window_.x) / float(width), dy = (window_.w - window_.z) / float(height);
  const Vec3 step = dx < dy ? Vec3(dx, 0.0f, 0.0f) : Vec3(0.0f, dy, 0.0f);
  if (kind_ == CameraKind::Orthographic) {
    angle_ = std::min(dx, dy);
  } else if (kind_ == CameraKind::Perspective) {
    const Vec3 middle(0.5f * (window_.x + window_.y), 0.5f * (window_.z + window_.w), -1.0f);
    angle_ = glm::length(glm::cross(glm::normalize(middle), glm::normalize(middle + step)));
    outwards_ = {glm::normalize(Vec3(-1.0f, 0.0f, window_.x * -1.0f)), glm::normalize(Vec3(1.0f, 0.0f, window_.y)),
                 glm::normalize(Vec3(0.0f, -1.0f, window_.z * -1.0f)), glm::normalize(Vec3(0.0f, 1.0f, window_.w))};
    forwards_ = {Vec3(window_.x, 0.0f, -1.0f), Vec3(window_.y, 0.0f, -1.0f), Vec3(0.0f, window_.z, -1.0f),
                 Vec3(0.0f, window_.w, -1.0f)};
  } else {
    const Camera panorama(camera, width, height);
    const Vec2 middle(0.5f * float(width), 0.5f * float(height));
    const Vec3 ahead = panorama.ray_through(middle, Vec2(0.0f), 0.0f).direction;
    angle_ = kInfinity;
    for (const Vec2 beside : {Vec2(1.0f, 0.0f), Vec2(0.0f, 1.0f)})
      angle_ = std::min(angle_, glm::length(panorama.ray_through(middle + beside, Vec2(0.0f), 0.0f).direction - ahead));
  }
  constexpr float kSmallest = 1e-9f;
  if (!(angle_ > kSmallest) || !(angle_ < kInfinity)) angle_ = kSmallest;
}

float PixelSize::at(Vec3 place) const {
  const Vec3 p = transform_point(camera_from_world_, place);
  const float size = kind_ == CameraKind::Orthographic ? angle_ : angle_ * glm::length(p);
  const float more = offscreen_scale_ > 1.0f ? outside(p) * (offscreen_scale_ - 1.0f) * angle_ : 0.0f;
  return std::max(size + more, 1e-20f);
}

/// Distance from the field of view, in units of the picture for an orthographic camera. Panoramas have none.
float PixelSize::outside(Vec3 p) const {
  if (kind_ == CameraKind::Panorama) return 0.0f;
  if (kind_ == CameraKind::Orthographic) {
    const Vec3 nearest(glm::clamp(p.x, window_.x, window_.y), glm::clamp(p.y, window_.z, window_.w),
                       std::min(p.z, 0.0f));
    return glm::length(p - nearest) / std::sqrt(0.5f * (sqr(window_.y) + sqr(window_.w)) + 1e-12f);
  }
  float beside = 0.0f;
  bool behind = false;
  int outside_of = 0;
  for (size_t side = 0; side < outwards_.size(); ++side) {
    const float distance = glm::dot(p, outwards_[side]);
    if (distance <= 0.0f) continue;
    ++outside_of;
    if (glm::dot(p, forwards_[side]) >= 0.0f)
      beside = std::max(beside, distance);
    else
      behind = true;
  }
  if (outside_of == 4) return glm::length(p);
  if (behind) return beside > 0.0f ? std::min(beside, glm::length(p)) : glm::length(p);
  return beside;
}

}  // namespace ajar
