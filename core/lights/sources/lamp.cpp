#include "lights/sources/lamp.h"

#include <algorithm>

#include "lights/sources/spherical_rectangle.h"
#include "math/warps.h"

namespace ajar {

namespace {

/// A smooth step inside the cone, times the cosine for the spots of Cycles 3.4.
float spot_profile(const Light& light, Vec3 wo) {
  const float along = glm::dot(wo, light.frame.n);
  float cos_theta = along;  // in the space of the lamp
  if (light.even_spot)
    cos_theta /= std::sqrt(sqr(glm::dot(wo, light.edge1)) + sqr(glm::dot(wo, light.edge2)) + sqr(along));
  if (!(cos_theta > light.cos_outer)) return 0.0f;
  const float x = cos_theta - light.cos_outer, scale = light.even_spot ? 1.0f : along;
  if (x >= light.spot_smooth) return scale;
  const float t = x / light.spot_smooth;
  return scale * t * t * (3.0f - 2.0f * t);
}

/// Soft-box grid in front of an area lamp: the fraction of the light that passes its slats.
float spread_profile(const Light& light, float cos_theta) {
  if (!(cos_theta > 0.0f)) return 0.0f;
  if (light.spread_tan == 0.0f) return 1.0f;
  const float tan_theta = safe_sqrt(1.0f - cos_theta * cos_theta) / cos_theta;
  return std::max(0.0f, (1.0f - light.spread_tan * tan_theta) * light.spread_norm);
}

/// 1 - cos of the cone of a sphere that is seen from the squared distance `d2` > r2.
float sphere_one_minus_cos(float r2, float d2) {
  const float sin2 = std::min(1.0f, r2 / d2);
  return sin2 / (1.0f + safe_sqrt(1.0f - sin2));
}

/// The part of a rectangle that can illuminate p: all of it, or the part from which the beam of the spread reaches p.
struct LitRectangle {
  Vec3 corner;
  float length_x, length_y;
  bool empty() const { return !(length_x > 0.0f && length_y > 0.0f); }
};
LitRectangle lit_part(const Light& light, Vec3 p) {
  const float hx = glm::dot(light.edge1, light.frame.s), hy = glm::dot(light.edge2, light.frame.t);
  Vec2 low(-hx, -hy), high(hx, hy);
  if (light.spread_tan > 0.0f) {
    const Vec3 local = light.frame.to_local(p - light.position);
    const float reach = local.z / light.spread_tan * 1.0001f;
    low = glm::max(low, Vec2(local) - reach);
    high = glm::min(high, Vec2(local) + reach);
  }
  return {light.position + low.x * light.frame.s + low.y * light.frame.t, high.x - low.x, high.y - low.y};
}

/// Whether the rectangle is so small and distant that its area is sampled instead of its solid angle. Cosine and
/// distance then vary little over it, and the map of a spherical rectangle costs more than it saves.
bool looks_small(const LitRectangle& lit, const Light& light, Vec3 p) {
  return sqr(lit.length_x) + sqr(lit.length_y) < 0.1f * length_squared(light.position - p);
}

LightSample towards(const Light& light, Vec3 p, Vec3 position, Vec3 normal) {
  LightSample s;
  const Vec3 d = position - p;
  s.distance = glm::length(d);
  s.wi = d / s.distance;
  s.position = position;
  s.normal = normal;
  s.delta = false;
  s.radiance = light.radiance * lamp_profile(light, -s.wi);
  s.pdf_solid_angle = 1.0f;
  return s;
}

std::optional<LightSample> sample_soft(const Light& light, Vec3 p, Vec2 u) {
  const Vec3 to_center = light.position - p;
  const float d = glm::length(to_center), size = sphere_one_minus_cos(sqr(light.radius), sqr(d) + sqr(light.radius));
  if (!(d > 0.0f)) return std::nullopt;
  LightSample s;
  s.delta = false;
  s.normal = to_center / -d;
  const Vec3 local = warp::square_to_cone(u, size);
  s.wi = Frame(-s.normal).to_world(local);
  s.distance = d / local.z;
  s.pdf_solid_angle = warp::cone_pdf_solid_angle(size);
  if (!std::isfinite(s.pdf_solid_angle) || !std::isfinite(s.distance)) return std::nullopt;
  s.position = p + s.wi * s.distance;
  s.radiance = light.radiance * lamp_profile(light, -s.wi);
  return s;
}

std::optional<LightSample> sample_sphere(const Light& light, Vec3 p, Vec2 u) {
  if (light.soft) return sample_soft(light, p, u);
  const Vec3 to_center = light.position - p;
  const float d2 = length_squared(to_center), r2 = sqr(light.radius);
  LightSample s;
  s.delta = false;
  bool inside = false;
  if (d2 > r2) {
    const float d = std::sqrt(d2), size = sphere_one_minus_cos(r2, d2);
    const Vec3 local = warp::square_to_cone(u, size);
    s.wi = Frame(to_center / d).to_world(local);
    // The ray enters the sphere here. sin^2 from the sampled sine keeps small cones accurate.
    const float sin2 = local.x * local.x + local.y * local.y;
    s.distance = d * local.z - safe_sqrt(r2 - d2 * sin2);
    s.pdf_solid_angle = warp::cone_pdf_solid_angle(size);
  } else {
    s.wi = warp::square_to_sphere(u);
    const float b = glm::dot(to_center, s.wi);
    s.distance = b + safe_sqrt(b * b - d2 + r2);
    s.pdf_solid_angle = warp::sphere_pdf_solid_angle();
    inside = true;
  }
  if (!std::isfinite(s.pdf_solid_angle)) return std::nullopt;  // the solid angle is too small for floats
  s.position = p + s.wi * s.distance;
  s.normal = glm::normalize(s.position - light.position);
  s.radiance = light.radiance * (inside && light.even_spot ? 1.0f : lamp_profile(light, -s.wi));
  return s;
}

std::optional<LightSample> sample_flat(const Light& light, Vec3 p, Vec2 u) {
  const float height = glm::dot(p - light.position, light.frame.n);
  if (!(height > 0.0f) || !(light.area > 0.0f)) return std::nullopt;
  if (light.type == LightType::Ellipse) {
    const Vec2 d = warp::square_to_disk(u);
    LightSample s = towards(light, p, light.position + d.x * light.edge1 + d.y * light.edge2, light.frame.n);
    s.pdf_solid_angle = sqr(s.distance) / (light.area * abs_dot(light.frame.n, s.wi));
    if (!std::isfinite(s.pdf_solid_angle)) return std::nullopt;
    return s;
  }
  const LitRectangle lit = lit_part(light, p);
  if (lit.empty()) return std::nullopt;
  if (!looks_small(lit, light, p)) {
    const SphericalRectangle rectangle(p, lit.corner, light.frame.s, light.frame.t, lit.length_x, lit.length_y);
    if (rectangle.usable()) {
      LightSample s = towards(light, p, p + rectangle.sample(u), light.frame.n);
      s.pdf_solid_angle = 1.0f / rectangle.solid_angle();
      return s;
    }
  }
  const Vec3 position = lit.corner + u.x * lit.length_x * light.frame.s + u.y * lit.length_y * light.frame.t;
  LightSample s = towards(light, p, position, light.frame.n);
  s.pdf_solid_angle = sqr(s.distance) / (lit.length_x * lit.length_y * abs_dot(light.frame.n, s.wi));
  if (!std::isfinite(s.pdf_solid_angle)) return std::nullopt;
  return s;
}

float pdf_flat(const Light& light, Vec3 p, Vec3 wi, float distance) {
  const float cos_light = -glm::dot(light.frame.n, wi);
  if (!(cos_light > 0.0f) || !(light.area > 0.0f)) return 0.0f;
  if (light.type == LightType::Ellipse) return sqr(distance) / (light.area * cos_light);
  const LitRectangle lit = lit_part(light, p);
  if (lit.empty()) return 0.0f;
  if (light.spread_tan > 0.0f) {
    const Vec3 local = p + wi * distance - lit.corner;
    const float x = glm::dot(local, light.frame.s), y = glm::dot(local, light.frame.t);
    if (x < 0.0f || y < 0.0f || x > lit.length_x || y > lit.length_y) return 0.0f;
  }
  if (!looks_small(lit, light, p)) {
    const SphericalRectangle rectangle(p, lit.corner, light.frame.s, light.frame.t, lit.length_x, lit.length_y);
    if (rectangle.usable()) return 1.0f / rectangle.solid_angle();
  }
  return sqr(distance) / (lit.length_x * lit.length_y * cos_light);
}

/// A direction to a sun with extent.
Vec3 sample_sun(const Light& light, Vec2 u) {
  if (light.sun_one_minus_cos > 0.0f) return -light.frame.to_world(warp::square_to_cone(u, light.sun_one_minus_cos));
  const Vec2 d = light.radius * warp::square_to_disk(u);
  return glm::normalize(-light.frame.n + d.x * light.frame.s + d.y * light.frame.t);
}

/// The cone of a spot in the space of its lamp, whose axes have these lengths.
void set_scaled_cone(Light& light, Vec3 scale) {
  const auto ratio = [](float a, float b) { return a > 0.0f && b > 0.0f ? a / b : 1.0f; };
  const Vec2 shrink(ratio(scale.z, scale.x), ratio(scale.z, scale.y));
  light.even_spot = true;
  light.edge1 = light.frame.s * shrink.x;
  light.edge2 = light.frame.t * shrink.y;
  const float cosine = std::max(light.cos_outer, 0.0f), widest = 1.0f / std::min(shrink.x, shrink.y);
  light.cos_widest = cosine > 0.0f ? cosine / std::sqrt(sqr(cosine) + (1.0f - sqr(cosine)) * sqr(widest)) : 0.0f;
}

}  // namespace

float sun_pdf(const Light& light, Vec3 wo) {
  if (light.sun_one_minus_cos > 0.0f) return warp::cone_pdf_solid_angle(light.sun_one_minus_cos);
  return lamp_profile(light, wo);
}

Light make_lamp(const LightDescription& d) {
  const Mat4 m = to_matrix(d.world_from_light);
  const Vec3 x(m[0]), y(m[1]), z(m[2]);
  const auto safe_normalize = [](Vec3 v, Vec3 fallback) {
    const float length = glm::length(v);
    return length > 0.0f ? v / length : fallback;
  };
  Light light;
  light.visibility = d.visibility;
  light.cast_shadow = d.cast_shadow;
  light.position = Vec3(m[3]);
  light.frame = Frame(-safe_normalize(z, Vec3(0, 0, 1)), x);
  const Color power = d.color * d.energy;
  switch (d.kind) {
    case LightKind::Point:
    case LightKind::Spot: {
      const bool spot = d.kind == LightKind::Spot;
      light.radius = std::max(0.0f, d.radius);
      if (light.radius > 0.0f) {
        light.type = spot ? LightType::SpotSphere : LightType::Sphere;
        light.area = 4.0f * kPi * sqr(light.radius);
        light.radiance = power / (kPi * light.area);
        light.soft = d.soft_falloff;
      } else {
        light.type = spot ? LightType::Spot : LightType::Point;
        light.radiance = power / (4.0f * kPi);
      }
      if (spot) {
        light.cos_outer = std::cos(0.5f * d.spot_angle);
        light.spot_smooth = (1.0f - light.cos_outer) * d.spot_blend;
        light.cos_widest = light.cos_outer;
        if (d.even_spot) set_scaled_cone(light, Vec3(glm::length(x), glm::length(y), glm::length(z)));
      }
      break;
    }
    case LightKind::Sun: {
      const float half_angle = std::clamp(0.5f * d.sun_angle, 0.0f, d.even_sun ? 1.5707f : 1.55f);
      light.type = half_angle > 0.0f ? LightType::DistantDisk : LightType::DistantDelta;
      light.radius = std::tan(half_angle);
      light.area = kPi * sqr(d.even_sun ? std::sin(half_angle) : light.radius);
      if (d.even_sun) light.sun_one_minus_cos = 2.0f * sqr(std::sin(0.5f * half_angle));
      light.radiance = power;
      break;
    }
    case LightKind::Area: {
      const bool ellipse = d.area_shape == AreaShape::Ellipse;
      light.type = ellipse ? LightType::Ellipse : LightType::Rectangle;
      // Orthogonal axes in the plane of the lamp: Blender has no sheared lamps.
      const float half_x = 0.5f * std::abs(d.area_size.x) * glm::length(x),
                  half_y = 0.5f * std::abs(d.area_size.y) * glm::length(y);
      if (glm::dot(light.frame.t, y) < 0.0f) {
        light.frame.s = -light.frame.s;
        light.frame.t = -light.frame.t;
      }
      light.edge1 = half_x * light.frame.s;
      light.edge2 = half_y * light.frame.t;
      light.area = (ellipse ? kPi : 4.0f) * half_x * half_y;
      light.radiance = light.area > 0.0f ? power / (4.0f * light.area) : Color(0.0f);
      // A spread below one degree is one degree, as in Cycles. The norm is half the integral of cos(x) (1 - tan(x)
      // tan(slats)).
      const double slats = 0.5 * (M_PI - std::clamp(double(d.spread), M_PI / 180.0, M_PI));
      if (slats > 1e-6) {
        light.spread_tan = float(std::tan(slats));
        light.spread_norm = float(2.0 / (2.0 + (2.0 * slats - M_PI) * std::tan(slats)));
      }
      break;
    }
  }
  light.mis = d.multiple_importance && !is_delta(light.type);
  return light;
}

Color lamp_flux(const Light& light, float scene_radius) {
  switch (light.type) {
    case LightType::Point: return light.radiance * (4.0f * kPi);
    case LightType::Sphere: return light.radiance * (kPi * light.area);
    case LightType::Spot:
    case LightType::SpotSphere: {
      // Integral of the profile over the cone. The projected area of a sphere is pi r^2 in every direction.
      constexpr int kSteps = 256, kTurns = 32;
      const int turns = light.even_spot ? kTurns : 1;
      double sum = 0.0;
      for (int i = 0; i < kSteps * turns; ++i) {
        const float z = light.cos_widest + (1.0f - light.cos_widest) * (float(i / turns) + 0.5f) / float(kSteps);
        const float phi = 2.0f * kPi * (float(i % turns) + 0.5f) / float(turns), r = safe_sqrt(1.0f - z * z);
        sum += spot_profile(light, light.frame.to_world({r * std::cos(phi), r * std::sin(phi), z}));
      }
      const float integral = 2.0f * kPi * (1.0f - light.cos_widest) * float(sum / (kSteps * turns));
      return light.radiance * (integral * (light.type == LightType::Spot ? 1.0f : 0.25f * light.area));
    }
    case LightType::Rectangle:
    case LightType::Ellipse: return light.radiance * (kPi * light.area);
    case LightType::DistantDelta: return light.radiance * (kPi * sqr(scene_radius));
    case LightType::DistantDisk: {  // radiance times the solid angle; an even sun has radiance / area in its whole cone
      const float cone = light.sun_one_minus_cos > 0.0f ? 2.0f * kPi * light.sun_one_minus_cos / light.area : 1.0f;
      return light.radiance * (cone * kPi * sqr(scene_radius));
    }
    default: return Color(0.0f);
  }
}

float lamp_profile(const Light& light, Vec3 wo) {
  switch (light.type) {
    case LightType::Spot:
    case LightType::SpotSphere: return spot_profile(light, wo);
    case LightType::Rectangle:
    case LightType::Ellipse: return spread_profile(light, glm::dot(wo, light.frame.n));
    case LightType::DistantDisk: {
      const float cos_theta = glm::dot(wo, light.frame.n);
      if (light.sun_one_minus_cos > 0.0f) return 1.0f / light.area;
      return cos_theta > 0.0f ? 1.0f / (light.area * cos_theta * cos_theta * cos_theta) : 0.0f;
    }
    default: return 1.0f;
  }
}

std::optional<LightSample> sample_lamp_li(const Light& light, Vec3 p, Vec2 u) {
  switch (light.type) {
    case LightType::Point:
    case LightType::Spot: {
      LightSample s = towards(light, p, light.position, light.frame.n);
      if (!(s.distance > 0.0f)) return std::nullopt;
      s.normal = -s.wi;
      s.radiance /= sqr(s.distance);
      s.delta = true;
      if (light.type == LightType::Spot && is_black(s.radiance)) return std::nullopt;
      return s;
    }
    case LightType::Sphere:
    case LightType::SpotSphere: return sample_sphere(light, p, u);
    case LightType::Rectangle:
    case LightType::Ellipse: return sample_flat(light, p, u);
    case LightType::DistantDelta:
    case LightType::DistantDisk: {
      LightSample s;
      s.delta = light.type == LightType::DistantDelta;
      s.wi = s.delta ? -light.frame.n : sample_sun(light, u);
      s.normal = -s.wi;
      s.position = Vec3(0.0f);
      s.distance = kInfinity;
      s.pdf_solid_angle = s.delta ? 1.0f : sun_pdf(light, -s.wi);
      s.radiance = light.radiance * (s.delta ? 1.0f : lamp_profile(light, -s.wi));
      return s;
    }
    default: return std::nullopt;
  }
}

float pdf_lamp_li(const Light& light, Vec3 p, Vec3 wi, float distance, Vec3) {
  switch (light.type) {
    case LightType::Sphere:
    case LightType::SpotSphere: {
      const float d2 = length_squared(light.position - p), r2 = sqr(light.radius);
      const float pdf = light.soft ? warp::cone_pdf_solid_angle(sphere_one_minus_cos(r2, d2 + r2))
                        : d2 > r2  ? warp::cone_pdf_solid_angle(sphere_one_minus_cos(r2, d2))
                                   : warp::sphere_pdf_solid_angle();
      return std::isfinite(pdf) ? pdf : 0.0f;
    }
    case LightType::Rectangle:
    case LightType::Ellipse: return pdf_flat(light, p, wi, distance);
    case LightType::DistantDisk: return sun_pdf(light, -wi);
    default: return 0.0f;
  }
}

std::optional<LampCrossing> intersect_lamp_shape(const Light& light, const Ray& ray) {
  if (light.soft) {
    const Vec3 from = ray.origin - ray.travelled * ray.direction;
    const auto distance = soft_lamp_distance(light, from, ray.direction);
    const float t = distance ? *distance - ray.travelled : 0.0f;
    if (!distance || !(t > ray.t_min && t < ray.t_max)) return std::nullopt;
    return LampCrossing{t, glm::normalize(from - light.position)};
  }
  const Vec3 to_center = light.position - ray.origin;
  if (light.type == LightType::Sphere || light.type == LightType::SpotSphere) {
    const float b = glm::dot(to_center, ray.direction), d2 = length_squared(to_center), r2 = sqr(light.radius);
    // Squared distance of the centre from the ray, without cancellation (Haines et al. 2019).
    const float h2 = r2 - length_squared(to_center - b * ray.direction);
    if (!(h2 >= 0.0f)) return std::nullopt;
    const float t = d2 > r2 ? b - std::sqrt(h2) : b + std::sqrt(h2);
    if (!(t > ray.t_min && t < ray.t_max)) return std::nullopt;
    return LampCrossing{t, glm::normalize(ray.direction * t - to_center)};
  }
  if (light.type == LightType::Rectangle || light.type == LightType::Ellipse) {
    const float cosine = glm::dot(ray.direction, light.frame.n);
    if (!(cosine < 0.0f)) return std::nullopt;  // the back does not emit
    const float t = glm::dot(to_center, light.frame.n) / cosine;
    if (!(t > ray.t_min && t < ray.t_max)) return std::nullopt;
    const Vec3 on_plane = ray.direction * t - to_center;
    const float x = glm::dot(on_plane, light.edge1) / length_squared(light.edge1);
    const float y = glm::dot(on_plane, light.edge2) / length_squared(light.edge2);
    const bool inside = light.type == LightType::Ellipse ? x * x + y * y <= 1.0f
                                                         : std::abs(x) <= 1.0f && std::abs(y) <= 1.0f;
    if (!inside) return std::nullopt;
    return LampCrossing{t, light.frame.n};
  }
  return std::nullopt;
}

std::optional<float> soft_lamp_distance(const Light& light, Vec3 p, Vec3 wi) {
  const Vec3 to_center = light.position - p;
  const float distance = length_squared(to_center) / glm::dot(to_center, wi);
  if (!(distance > 0.0f && distance < kInfinity)) return std::nullopt;
  if (!(length_squared(distance * wi - to_center) <= sqr(light.radius))) return std::nullopt;
  return distance;
}

std::optional<Vec3> soft_lamp_normal(const Light& light, Vec3 position, Vec3 wo) {
  const Vec3 beside = soft_lamp_start(light, position, wo) - light.position;
  const float left = sqr(light.radius) - length_squared(beside);
  if (!(left >= 0.0f)) return std::nullopt;
  return glm::normalize(std::sqrt(left) * wo - beside);
}

Vec3 soft_lamp_start(const Light& light, Vec3 position, Vec3 wo) {
  return position - glm::dot(position - light.position, wo) * wo;
}

}  // namespace ajar
