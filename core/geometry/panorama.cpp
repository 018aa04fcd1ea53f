#include "geometry/panorama.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

/// Direction at angle `theta` from the axis, on the side of the film that `offset` points to.
Vec3 at_angle(float theta, Vec2 offset) {
  const float r = glm::length(offset);
  const Vec2 side = r > 0.0f ? offset / r : Vec2(1.0f, 0.0f);
  return Vec3(side * std::sin(theta), -std::cos(theta));
}

float angle_of(Vec3 direction) { return std::atan2(glm::length(Vec2(direction)), -direction.z); }

Vec2 side_of(Vec3 direction) {
  const float len = glm::length(Vec2(direction));
  return len > 0.0f ? Vec2(direction) / len : Vec2(1.0f, 0.0f);
}

constexpr float kQuarter = 0.25f * kPi;

}  // namespace

std::optional<Vec3> Panorama::direction_of(Vec2 uv) const {
  switch (d_.kind) {
    case PanoramaKind::Equirectangular: {
      const float longitude = d_.limits.x + uv.x * (d_.limits.y - d_.limits.x),
                  latitude = d_.limits.z + uv.y * (d_.limits.w - d_.limits.z);
      return Vec3(std::cos(latitude) * std::sin(longitude), std::sin(latitude),
                  -std::cos(latitude) * std::cos(longitude));
    }
    case PanoramaKind::FisheyeEquidistant: {
      const Vec2 offset = 2.0f * uv - 1.0f;
      const float r = glm::length(offset);
      if (r > 1.0f) return std::nullopt;
      return at_angle(0.5f * d_.fisheye_fov * r, offset);
    }
    case PanoramaKind::FisheyeEquisolid: {
      const Vec2 offset = (uv - 0.5f) * d_.sensor;
      const float r = glm::length(offset);
      if (r > 2.0f * d_.fisheye_lens * std::sin(0.25f * d_.fisheye_fov)) return std::nullopt;
      return at_angle(2.0f * std::asin(r / (2.0f * d_.fisheye_lens)), offset);
    }
    case PanoramaKind::FisheyePolynomial: {
      const Vec2 offset = (uv - 0.5f) * d_.sensor;
      const float r = glm::length(offset);
      float theta = 0.0f;
      for (size_t i = d_.polynomial.size(); i-- > 0;) theta = theta * r - d_.polynomial[i];
      if (!(std::abs(theta) <= 0.5f * d_.fisheye_fov)) return std::nullopt;
      return at_angle(theta, offset);
    }
    case PanoramaKind::MirrorBall: {
      // The direction -z reflected by a unit sphere.
      const Vec2 n = 2.0f * uv - 1.0f;
      const float square = glm::dot(n, n);
      if (square > 1.0f) return std::nullopt;
      const float nz = -std::sqrt(1.0f - square);
      return Vec3(-2.0f * nz * n, 1.0f - 2.0f * nz * nz);
    }
    case PanoramaKind::CubemapFace: {
      const Vec2 angle = uv * (2.0f * kQuarter) - kQuarter;
      return glm::normalize(Vec3(std::tan(angle.x), std::tan(angle.y), -1.0f));
    }
  }
  return std::nullopt;
}

std::optional<Vec2> Panorama::film_of(Vec3 direction) const {
  const float theta = angle_of(direction);
  switch (d_.kind) {
    case PanoramaKind::Equirectangular: {
      const float span_u = d_.limits.y - d_.limits.x, span_v = d_.limits.w - d_.limits.z;
      const float middle = 0.5f * (d_.limits.x + d_.limits.y);
      const float longitude = middle + std::remainder(std::atan2(direction.x, -direction.z) - middle, 2.0f * kPi);
      return Vec2((longitude - d_.limits.x) / span_u,
                  (std::asin(std::clamp(direction.y, -1.0f, 1.0f)) - d_.limits.z) / span_v);
    }
    case PanoramaKind::FisheyeEquidistant:
      if (theta > 0.5f * d_.fisheye_fov) return std::nullopt;
      return 0.5f + (theta / d_.fisheye_fov) * side_of(direction);
    case PanoramaKind::FisheyeEquisolid:
      if (theta > 0.5f * d_.fisheye_fov) return std::nullopt;
      return 0.5f + 2.0f * d_.fisheye_lens * std::sin(0.5f * theta) * side_of(direction) / d_.sensor;
    case PanoramaKind::FisheyePolynomial: return std::nullopt;
    case PanoramaKind::MirrorBall: {
      const Vec3 n = direction - Vec3(0.0f, 0.0f, 1.0f);
      const float len = glm::length(n);
      return len > 0.0f ? 0.5f + 0.5f * Vec2(n) / len : Vec2(1.0f, 0.5f);
    }
    case PanoramaKind::CubemapFace:
      if (!(direction.z < 0.0f)) return std::nullopt;
      return Vec2(std::atan(direction.x / -direction.z) + kQuarter, std::atan(direction.y / -direction.z) + kQuarter) /
             (2.0f * kQuarter);
  }
  return std::nullopt;
}

float Panorama::density(Vec3 direction) const {
  switch (d_.kind) {
    case PanoramaKind::Equirectangular: {
      const float cos_latitude = glm::length(Vec2(direction.x, direction.z));
      const float area = std::abs((d_.limits.y - d_.limits.x) * (d_.limits.w - d_.limits.z)) * cos_latitude;
      return area > 0.0f ? 1.0f / area : 0.0f;
    }
    case PanoramaKind::FisheyeEquidistant: {
      const float theta = angle_of(direction), sin_theta = glm::length(Vec2(direction));
      return sin_theta > 1e-4f ? theta / (sin_theta * sqr(d_.fisheye_fov)) : 1.0f / sqr(d_.fisheye_fov);
    }
    case PanoramaKind::FisheyeEquisolid: return sqr(d_.fisheye_lens) / (d_.sensor.x * d_.sensor.y);
    case PanoramaKind::FisheyePolynomial: {
      // Without an inverse, no path is connected to the camera.
      return 0.0f;
    }
    case PanoramaKind::MirrorBall: return 1.0f / 16.0f;
    case PanoramaKind::CubemapFace: {
      const float a = direction.x / direction.z, b = direction.y / direction.z, square = 1.0f + a * a + b * b;
      return square * std::sqrt(square) / ((1.0f + a * a) * (1.0f + b * b) * sqr(2.0f * kQuarter));
    }
  }
  return 0.0f;
}

bool Panorama::has_inverse(Vec2 margin) const {
  switch (d_.kind) {
    case PanoramaKind::Equirectangular: {
      const float span_u = d_.limits.y - d_.limits.x, span_v = d_.limits.w - d_.limits.z;
      return std::abs(span_u) * (1.0f + 2.0f * margin.x) <= 2.0f * kPi &&
             std::abs(0.5f * (d_.limits.z + d_.limits.w)) + std::abs(span_v) * (0.5f + margin.y) <= 0.5f * kPi;
    }
    case PanoramaKind::FisheyeEquidistant:
    case PanoramaKind::FisheyeEquisolid: return d_.fisheye_fov <= 2.0f * kPi;
    case PanoramaKind::FisheyePolynomial: return false;
    case PanoramaKind::MirrorBall: return true;
    case PanoramaKind::CubemapFace: return std::max(margin.x, margin.y) < 0.5f;
  }
  return false;
}

}  // namespace ajar
