#include "transport/hints/hints.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lights/sources/lamp.h"
#include "math/frame.h"
#include "math/warps.h"
#include "transport/paths/ray_events.h"

namespace ajar {

namespace {

constexpr size_t kMaxPoints = 32;       // no path has more bounces
constexpr float kBlockedShare = 0.75f;  // of the distance to a point: a surface that is hit earlier blocks the segment
constexpr float kNearShare = 0.35f;     // of the distance to a point: the point belongs to a specular surface within it
constexpr float kSmallestSpread = 1e-4f;

/// Nearest point of a light at a finite distance.
std::optional<Vec3> nearest_on(const Light& light, Vec3 p) {
  switch (light.type) {
    case LightType::Point:
    case LightType::Spot: return light.position;
    case LightType::Sphere:
    case LightType::SpotSphere: {
      const Vec3 out = p - light.position;
      const float length = glm::length(out);
      return length > light.radius ? light.position + out * (light.radius / length) : p;
    }
    case LightType::Rectangle:
    case LightType::Ellipse: {
      const Vec3 out = p - light.position;
      Vec2 d(glm::dot(out, light.edge1) / length_squared(light.edge1),
             glm::dot(out, light.edge2) / length_squared(light.edge2));
      d = light.type == LightType::Ellipse && glm::length(d) > 1.0f ? glm::normalize(d) : glm::clamp(d, -1.0f, 1.0f);
      return light.position + d.x * light.edge1 + d.y * light.edge2;
    }
    case LightType::Triangle: {
      // Barycentric coordinates of the projection, clamped to the triangle: exact inside, and close enough outside.
      const Vec3 out = p - light.position;
      const float a = glm::dot(light.edge1, light.edge1), b = glm::dot(light.edge1, light.edge2),
                  c = glm::dot(light.edge2, light.edge2);
      const float x = glm::dot(out, light.edge1), y = glm::dot(out, light.edge2), det = a * c - b * b;
      if (!(det > 0.0f)) return std::nullopt;
      Vec2 d = glm::max(Vec2((c * x - b * y) / det, (a * y - b * x) / det), 0.0f);
      if (d.x + d.y > 1.0f) d /= d.x + d.y;
      return light.position + d.x * light.edge1 + d.y * light.edge2;
    }
    default: return std::nullopt;
  }
}

class Attacher {
 public:
  Attacher(const Scene& scene, const HintDescription& description, HintReport& report)
      : scene_(scene), d_(description), report_(report) {}

  std::optional<Hints::Hint> attach() {
    report_.attached = is_usable() && find_light() && follow();
    return report_.attached ? std::optional(std::move(hint_)) : std::nullopt;
  }

 private:
  bool fail(std::string reason) {
    report_.reason = std::move(reason);
    return false;
  }

  bool is_usable() {
    if (d_.points.size() < 2) return fail("it needs at least two points, the first at a light");
    if (d_.points.size() > kMaxPoints)
      return fail("it has " + std::to_string(d_.points.size()) + " points; the maximum is " +
                  std::to_string(kMaxPoints));
    for (const Vec3& p : d_.points)
      if (!is_finite(p)) return fail("a coordinate of its points is not a number");
    if (!(d_.spread > 0.0f) || !std::isfinite(d_.weight)) return fail("its spread or weight is not valid");
    return true;
  }

  bool find_light() {
    const LightSet& lights = scene_.lights();
    float nearest = kInfinity, nearest_moving = kInfinity;
    Vec3 start(0.0f);
    for (uint32_t i = 0; i < lights.size(); ++i) {
      if (!(lights.power_pmf(i) > 0.0f)) continue;
      const auto on_light = nearest_on(lights.light(i), d_.points[0]);
      if (!on_light) continue;
      const float distance = glm::length(*on_light - d_.points[0]);
      if (lights.moves(i))
        nearest_moving = std::min(nearest_moving, distance);
      else if (distance < nearest)
        nearest = distance, start = *on_light, hint_.light = i;
    }
    if (!(std::min(nearest, nearest_moving) < kInfinity))
      return fail("there is no lamp or emitting surface to start from");
    const float first = glm::length(d_.points[1] - d_.points[0]);
    if (nearest > 0.5f * first)
      return fail(nearest_moving > 0.5f * first ? "no light is near its first point"
                                                : "the light near its first point moves");
    add(start, HintSegmentState::Attached);
    for (const LightSet::SourceRange& source : lights.sources()) {
      if (hint_.light < source.first || hint_.light - source.first >= source.count) continue;
      hint_.first_light = source.first;
      double sum = 0.0;
      for (uint32_t i = 0; i < source.count; ++i)
        hint_.light_probabilities.push_back(sum += double(lights.power_pmf(source.first + i)));
    }
    return !hint_.light_probabilities.empty() || fail("the light near its first point has no power");
  }

  void add(Vec3 position, HintSegmentState way) {
    if (!hint_.vertices.empty()) report_.segments.push_back(way);
    report_.positions.push_back(position);
    hint_.vertices.push_back({position, false, false});
  }

  /// Adds the spread of the segment to point `next` of the curve.
  void add_cone(size_t next) {
    float spread = next - 1 < d_.spreads.size() ? d_.spreads[next - 1] : d_.spread;
    if (!(spread > kSmallestSpread)) spread = kSmallestSpread;
    hint_.one_minus_cos.push_back(warp::one_minus_cos(std::min(spread, kPi)));
  }

  bool follow() {
    size_t next = 1;
    ShadingPoint point;
    SurfaceShading shading;
    Ray ray;
    Vec3 aim = d_.points[1] - hint_.vertices[0].position;
    if (!(glm::length(aim) > 0.0f)) return fail("its first two points coincide");
    ray.origin = hint_.vertices[0].position;
    ray.direction = glm::normalize(aim);
    ray.origin += ray.direction * (1e-4f * glm::length(aim));
    point.ray_kind = kRayDiffuse | kRayReflection;
    bool bounced = false;
    add_cone(1);
    for (int crossed = 0; hint_.vertices.size() <= kMaxPoints;) {
      const Hit hit = scene_.intersect(ray, point.ray_kind);
      const std::string where = "on the way to its point " + std::to_string(next + 1);
      if (!hit.found()) {
        report_.segments.push_back(HintSegmentState::Failed);
        return fail(where + " there is no surface");
      }
      scene_.shading_point(ray, hit, point);
      const ShaderProgram& program = scene_.material(hit);
      program.evaluate_surface(point, shading);
      const bool only_encloses = program.only_encloses();
      if (only_encloses || (program.may_be_transparent() && !program.scatters())) {
        if (++crossed > 64) return fail(where + " there are too many transparent surfaces");
        ray = scene_.spawn_ray(point, ray.direction);
        continue;
      }
      const float way = glm::length(d_.points[next] - hint_.vertices.back().position),
                  miss = glm::length(d_.points[next] - point.position);
      const bool rough = shading.bsdf.has_non_delta();
      if (!rough && shading.bsdf.empty())
        return stop(point.position, where + " '" + point.object->name + "' reflects nothing");
      // An aimed ray must come near its point. A ray after a specular bounce may end anywhere.
      if (!bounced && rough && hit.t < kBlockedShare * way && miss > kNearShare * way)
        return stop(point.position, where + " '" + point.object->name + "' blocks the segment");
      add(point.position, bounced ? HintSegmentState::Bounced : HintSegmentState::Attached);
      if (rough) {
        if (next + 1 == d_.points.size()) break;
        ++next;
        aim = d_.points[next] - point.position;
        if (!(glm::length(aim) > 0.0f)) return fail("two of its points coincide");
        ray = scene_.spawn_ray(point, glm::normalize(aim));
        bounced = false;
        add_cone(next);
        continue;
      }
      if (next + 1 < d_.points.size() && miss <= kNearShare * std::max(way, hit.t)) ++next;
      if (!bounce(point, shading.bsdf, d_.points[next], ray))
        return stop(point.position, where + " '" + point.object->name + "' does not reflect towards its next point");
      hint_.one_minus_cos.push_back(0.0f);
      bounced = true;
    }
    if (hint_.vertices.back().specular)
      return fail("its last point is on a mirror or on glass, to which paths cannot be connected");
    if (hint_.vertices.size() > kMaxPoints) return fail("it has too many bounces");
    hint_.name = d_.name;
    hint_.axis = glm::normalize(hint_.vertices[1].position - hint_.vertices[0].position);
    return true;
  }

  bool stop(Vec3 position, std::string reason) {
    report_.positions.push_back(position);
    report_.segments.push_back(HintSegmentState::Failed);
    return fail(std::move(reason));
  }

  /// The specular bounce whose direction is closest to `target`.
  bool bounce(const ShadingPoint& point, const Bsdf& bsdf, Vec3 target, Ray& ray) {
    const Vec3 wanted = glm::normalize(target - point.position);
    std::optional<BsdfSample> best;
    for (int i = 0; i < 18; ++i) {
      // Evenly spaced, and close to both ends, where branches of small probability are (a weak reflection).
      const float u_lobe = i < 16 ? (float(i) + 0.5f) / 16.0f : (i == 16 ? 0.999f : 0.001f);
      const auto sample = bsdf.sample(point.wo, u_lobe, Vec2(0.5f), TransportMode::Importance);
      if (sample && sample->specular && !(sample->flags & kTransparent) && !is_black(sample->f_cos) &&
          (!best || glm::dot(sample->wi, wanted) > glm::dot(best->wi, wanted)))
        best = sample;
    }
    if (!best) return false;
    hint_.vertices.back().specular = true;
    hint_.vertices.back().transmitted = best->flags & kTransmission;
    ray = scene_.spawn_ray(point, best->wi);
    return true;
  }

  const Scene& scene_;
  const HintDescription& d_;
  HintReport& report_;
  Hints::Hint hint_;
};

}  // namespace

Hints Hints::attach(const Scene& scene, const std::vector<HintDescription>& descriptions,
                    std::vector<HintReport>& reports) {
  Hints hints;
  double total = 0.0;
  for (const HintDescription& description : descriptions) {
    if (!description.enabled || description.weight <= 0.0f) continue;
    reports.push_back({description.name, false, {}, {}, {}});
    auto hint = Attacher(scene, description, reports.back()).attach();
    if (!hint) continue;
    hint->share = description.weight;
    total += hint->share;
    hints.hints_.push_back(std::move(*hint));
  }
  for (Hint& hint : hints.hints_) hint.share /= total;
  return hints;
}

uint32_t Hints::choose(float u) const {
  double sum = 0.0;
  for (uint32_t i = 0; i + 1 < hints_.size(); ++i)
    if (double(u) < (sum += hints_[i].share)) return i;
  return uint32_t(hints_.size()) - 1;
}

uint32_t Hints::choose_light(const Hint& hint, float u) {
  const auto at = std::upper_bound(hint.light_probabilities.begin(), hint.light_probabilities.end() - 1,
                                   double(u) * hint.light_probabilities.back());
  return hint.first_light + uint32_t(at - hint.light_probabilities.begin());
}

double Hints::pdf_position(const Hint& hint, LightType type, Vec3 normal) {
  if (!is_sphere(type)) return 1.0;
  return glm::dot(normal, hint.axis) > 0.0f ? 2.0 : 0.0;
}

void Hints::sample_position(const Hint& hint, const Light& light, Vec2 u, Vec3& position, Vec3& normal) {
  sample_place(light, u, position, normal);
  if (!is_sphere(light.type) || !(glm::dot(normal, hint.axis) < 0.0f)) return;
  normal = -normal;
  position = 2.0f * light.position - position;
}

Vec3 Hints::sample_direction(const Hint& hint, size_t j, Vec3 position, Vec2 u) {
  return Frame(glm::normalize(hint.vertices[j + 1].position - position))
      .to_world(warp::square_to_cone(u, hint.one_minus_cos[j]));
}

float Hints::pdf_solid_angle(const Hint& hint, size_t j, Vec3 position, Vec3 direction) {
  // 1 - cos as half the squared chord, which avoids cancellation in cones of a milliradian.
  const Vec3 axis = glm::normalize(hint.vertices[j + 1].position - position);
  const float one_minus_cos = 0.5f * length_squared(direction - axis);
  return one_minus_cos <= hint.one_minus_cos[j] ? warp::cone_pdf_solid_angle(hint.one_minus_cos[j]) : 0.0f;
}

double Hints::pdf(const Hint& hint, uint32_t light, LightType type, Vec3 normal, std::span<const PathPoint> path) {
  if (light < hint.first_light || light - hint.first_light >= hint.light_probabilities.size() ||
      hint.vertices.size() != path.size())
    return 0.0;
  double density = pdf_position(hint, type, normal) / hint.light_probabilities.back();
  for (size_t j = 0; j + 1 < path.size(); ++j) {
    if (path[j].specular != hint.vertices[j].specular) return 0.0;
    if (path[j].specular) {
      if (path[j].transmitted != hint.vertices[j].transmitted) return 0.0;
      continue;
    }
    density *= double(
        pdf_solid_angle(hint, j, path[j].position, glm::normalize(path[j + 1].position - path[j].position)));
    if (density == 0.0) return 0.0;
  }
  return path.back().specular ? 0.0 : density;
}

}  // namespace ajar
