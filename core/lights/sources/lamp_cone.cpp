#include <algorithm>
#include <cmath>

#include "lights/sources/lamp.h"

namespace ajar {

// The point o + t d is in the cone if a = (o + t d - apex).axis is not negative and a^2 - cos^2 |o + t d - apex|^2 is not
// either: outside the roots of a quadratic polynomial, or between them.
void clip_to_cone(const Light& light, const Ray& ray, float& begin, float& end) {
  const bool is_area = light.type == LightType::Rectangle || light.type == LightType::Ellipse;
  const float cosine = is_area ? light.spread_tan / std::sqrt(1.0f + sqr(light.spread_tan)) : light.cos_widest;
  const float sine = safe_sqrt(1.0f - cosine * cosine);
  if (cosine < 0.0f || !(sine > 0.0f)) return;
  // So far behind its centre, the cone contains a sphere around the lamp, and the cones of all its points.
  const float radius = is_area ? std::sqrt(length_squared(light.edge1) + length_squared(light.edge2)) : light.radius;
  const Vec3 from = ray.origin - (light.position - radius / sine * light.frame.n);
  const double along = glm::dot(ray.direction, light.frame.n), start = glm::dot(from, light.frame.n);
  // First the half-space in front of the lamp.
  if (along > 0.0)
    begin = std::max(begin, float(-start / along));
  else if (along < 0.0)
    end = std::min(end, float(-start / along));
  else if (start < 0.0)
    end = begin;
  const double squared = double(cosine) * double(cosine);
  const double a = along * along - squared, b = along * start - squared * double(glm::dot(from, ray.direction)),
               c = start * start - squared * double(length_squared(from)), d = b * b - a * c;
  if (cosine > 0.0f && begin < end) {
    if (d < 0.0) {
      if (a < 0.0) end = begin;  // the ray passes beside the cone
    } else if (a < 0.0) {
      const double root = std::sqrt(d);
      begin = std::max(begin, float((-b + root) / a));
      end = std::min(end, float((-b - root) / a));
    } else if (a > 0.0) {
      // One root is in the mirrored cone behind the lamp, so only the other one limits the part in front.
      const double root = std::sqrt(d), first = (-b - root) / a, second = (-b + root) / a;
      if (along > 0.0)
        begin = std::max(begin, float(second));
      else
        end = std::min(end, float(first));
    }
  }
  if (!(begin < end)) end = begin;
}

}  // namespace ajar
