// Rays that leave lamps: their places, directions and densities.
#include "lights/sources/lamp.h"
#include "math/frame.h"
#include "math/warps.h"

namespace ajar {

namespace {

/// sin^2 of the angle to the axis beyond which the spread lets no light pass.
float spread_sin2(const Light& light) { return 1.0f / (1.0f + sqr(light.spread_tan)); }

/// Direction of a ray that leaves the lamp, around the axis `n` (for spots, the axis of the cone).
Vec3 sample_le_direction(const Light& light, Vec3 n, Vec2 u) {
  switch (light.type) {
    case LightType::Point: return warp::square_to_sphere(u);
    case LightType::Spot:
    case LightType::SpotSphere: return light.frame.to_world(warp::square_to_cone(u, 1.0f - light.cos_widest));
    case LightType::Rectangle:
    case LightType::Ellipse: {
      // Cosine-weighted inside the cone that passes the spread.
      const Vec2 d = warp::square_to_disk(u) * std::sqrt(spread_sin2(light));
      return light.frame.to_world({d.x, d.y, safe_sqrt(1.0f - d.x * d.x - d.y * d.y)});
    }
    default: return Frame(n).to_world(warp::square_to_cosine_hemisphere(u));
  }
}
float pdf_le_direction(const Light& light, Vec3 n, Vec3 direction) {
  switch (light.type) {
    case LightType::Point: return warp::sphere_pdf_solid_angle();
    case LightType::Spot:
    case LightType::SpotSphere:
      return glm::dot(direction, light.frame.n) > light.cos_widest ? warp::cone_pdf_solid_angle(1.0f - light.cos_widest)
                                                                   : 0.0f;
    case LightType::Rectangle:
    case LightType::Ellipse: {
      const float cos_theta = glm::dot(direction, light.frame.n), sin2_max = spread_sin2(light);
      return cos_theta > 0.0f && 1.0f - cos_theta * cos_theta <= sin2_max ? cos_theta * kInvPi / sin2_max : 0.0f;
    }
    default: return warp::cosine_hemisphere_pdf_solid_angle(glm::dot(direction, n));
  }
}

}  // namespace

void sample_place(const Light& light, Vec2 u, Vec3& position, Vec3& normal) {
  position = light.position;
  normal = light.frame.n;
  switch (light.type) {
    case LightType::Sphere:
    case LightType::SpotSphere:
      normal = warp::square_to_sphere(u);
      position += (light.soft ? -light.radius : light.radius) * normal;
      return;
    case LightType::Rectangle:
    case LightType::Ellipse: {
      const Vec2 d = light.type == LightType::Ellipse ? warp::square_to_disk(u) : 2.0f * u - 1.0f;
      position += d.x * light.edge1 + d.y * light.edge2;
      return;
    }
    case LightType::Triangle: {
      const Vec2 b = warp::square_to_triangle(u);
      position += b.x * light.edge1 + b.y * light.edge2;
      return;
    }
    default: return;
  }
}

std::optional<LightRay> sample_lamp_le(const Light& light, Vec2 u_position, Vec2 u_direction, Vec3 center,
                                       float radius) {
  LightRay r;
  switch (light.type) {
    case LightType::Point:
    case LightType::Spot:
      r.ray.origin = light.position;
      r.ray.direction = sample_le_direction(light, light.frame.n, u_direction);
      r.normal = r.ray.direction;
      break;
    case LightType::Sphere:
    case LightType::SpotSphere:
    case LightType::Rectangle:
    case LightType::Ellipse:
      sample_place(light, u_position, r.ray.origin, r.normal);
      r.ray.direction = sample_le_direction(light, r.normal, u_direction);
      if (is_sphere(light.type) && !(glm::dot(r.ray.direction, r.normal) > 0.0f)) return std::nullopt;
      break;
    case LightType::DistantDelta:
    case LightType::DistantDisk: {
      const auto s = sample_lamp_li(light, center, u_direction);
      r.ray.direction = r.normal = -s->wi;
      const Vec2 d = radius * warp::square_to_disk(u_position);
      const Frame frame(r.ray.direction);
      r.ray.origin = center - radius * r.ray.direction + d.x * frame.s + d.y * frame.t;
      break;
    }
    default: return std::nullopt;
  }
  r.radiance = light.radiance * (light.type == LightType::DistantDelta ? 1.0f : lamp_profile(light, r.ray.direction));
  pdf_lamp_le(light, r.normal, r.ray.direction, radius, r.pdf_area, r.pdf_solid_angle);
  if (is_delta(light.type) && is_distant(light.type)) r.pdf_solid_angle = 1.0f;
  if (!(r.pdf_solid_angle > 0.0f)) return std::nullopt;
  return r;
}

void pdf_lamp_le(const Light& light, Vec3 normal, Vec3 direction, float scene_radius, float& pdf_area,
                 float& pdf_solid_angle) {
  switch (light.type) {
    case LightType::Point:
    case LightType::Spot:
      pdf_area = 1.0f;
      pdf_solid_angle = pdf_le_direction(light, normal, direction);
      return;
    case LightType::DistantDelta:
    case LightType::DistantDisk:
      pdf_area = kInvPi / sqr(scene_radius);
      pdf_solid_angle = light.type == LightType::DistantDisk ? sun_pdf(light, direction) : 0.0f;
      return;
    default:
      pdf_area = light.area > 0.0f ? 1.0f / light.area : 0.0f;
      pdf_solid_angle = pdf_le_direction(light, normal, direction);
  }
}

}  // namespace ajar
