#include "transport/media/subsurface_profile.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "math/frame.h"

namespace ajar {

namespace {

constexpr float kEnd = 16.0f;               ///< of the profile, in widths
constexpr float kWithinEnd = 0.996378984f;  ///< the fraction of the profile's light that leaves before its end
constexpr int kMostHits = 32;               ///< of a probe ray

/// The three axes of probe rays, and the probability of each.
struct Axes {
  std::array<Vec3, 3> axis;
  static constexpr std::array<float, 3> kProbability = {0.5f, 0.25f, 0.25f};

  explicit Axes(Vec3 normal) {
    const Frame frame(normal);
    axis = {normal, frame.s, frame.t};
  }
  /// The weight of a hit of a probe along axis `k`, over the density of such hits on the surface.
  float weight(int k, Vec3 normal) const {
    float squares = 0.0f, own = 0.0f;
    for (int i = 0; i < 3; ++i) {
      const float density = kProbability[size_t(i)] * std::abs(glm::dot(axis[size_t(i)], normal));
      squares += density * density;
      if (i == k) own = density;
    }
    return own / squares;
  }
};

/// The widths of the channels that have light and a profile.
struct Widths {
  std::array<float, 3> of_channel{};
  std::array<int, 3> channels{};
  int count = 0;

  Widths(const SubsurfaceMedium& medium, Color light) {
    for (int i = 0; i < 3; ++i) {
      if (!(light[i] > 0.0f && medium.radius[i] > 0.0f)) continue;
      of_channel[size_t(i)] = medium.radius[i];
      channels[size_t(count++)] = i;
    }
  }
  Color density(float distance) const {
    Color value(0.0f);
    for (int i = 0; i < 3; ++i)
      if (of_channel[size_t(i)] > 0.0f) value[i] = profile_density(of_channel[size_t(i)], distance);
    return value;
  }
};

}  // namespace

float profile_density(float d, float distance) {
  if (!(distance < kEnd * d)) return 0.0f;
  const float third = std::exp(-distance / (3.0f * d));
  return (third * third * third + third) / (4.0f * kWithinEnd * d);
}

// The integral up to x widths is 1 - (y^3 + 3 y) / 4 with y = exp(-x / 3). The real root of the cubic equation is a
// hyperbolic sine.
float sample_profile(float d, float u) {
  const float y = 2.0f * std::sinh(std::asinh(2.0f * (1.0f - u * kWithinEnd)) / 3.0f);
  return d * std::clamp(-3.0f * std::log(y), 0.0f, kEnd);
}

bool scatter_by_profile(const Scene& scene, const EntryPoint& entry, Pcg32& rng, ShadingPoint& point,
                        SurfaceShading& shading, Color& weight, uint64_t& rays) {
  const SubsurfaceMedium& medium = shading.medium;
  const Widths widths(medium, weight);
  if (widths.count == 0) return false;
  const Vec3 from = point.position;
  const bool from_back = point.backfacing;
  const Axes axes(point.ng);
  const float u_axis = rng.next_float();
  const int k = u_axis < 0.5f ? 0 : (u_axis < 0.75f ? 1 : 2);
  const Vec3 axis = axes.axis[size_t(k)];
  const Frame disk(axis);
  const int channel = widths.channels[size_t(std::min(int(rng.next_float() * float(widths.count)), widths.count - 1))];
  const float width = widths.of_channel[size_t(channel)], radius = sample_profile(width, rng.next_float());
  const float phi = 2.0f * kPi * rng.next_float(),
              height = safe_sqrt((kEnd * width - radius) * (kEnd * width + radius));
  const Color on_disk = widths.density(radius);
  const float density = (on_disk.x + on_disk.y + on_disk.z) / float(widths.count);
  if (!(density > 0.0f)) return false;

  Ray probe;
  probe.origin = from + disk.to_world({radius * std::cos(phi), radius * std::sin(phi), height});
  probe.direction = -axis;
  probe.t_max = 2.0f * height;
  probe.time = point.time;
  // One of the hits is kept, with a probability proportional to its weight.
  Ray kept_ray;
  Hit kept;
  Color kept_weight(0.0f);
  float sum = 0.0f, kept_share = 0.0f;
  ShadingPoint found;
  for (int i = 0; i < kMostHits && probe.t_max > 0.0f; ++i) {
    const Hit hit = find_own_surface(scene, entry.instance, probe, rays);
    if (!hit.found()) break;
    scene.shading_point(probe, hit, found);
    const Color of_hit = widths.density(glm::length(found.position - from)) * (axes.weight(k, found.ng) / density);
    const float share = of_hit.x + of_hit.y + of_hit.z;
    sum += share;
    if (share > 0.0f && rng.next_float() * sum < share) {
      kept = hit;
      kept_ray = probe;
      kept_weight = of_hit;
      kept_share = share;
      if (found.backfacing != from_back) kept_ray.direction = -kept_ray.direction;
    }
    probe = scene.straight_on(found, probe, hit.t);
  }
  if (!(kept_share > 0.0f)) return false;
  // The surface is seen from the side on which light entered.
  scene.shading_point(kept_ray, kept, point);
  if (!(glm::dot(point.ns, point.ng) > 0.0f)) point.ns = point.ng;
  point.wo = point.ns;
  weight *= kept_weight * medium.albedo * (sum / kept_share);
  leave_surface(scene.material(kept), point, point.ns, shading);
  return is_finite(weight);
}

}  // namespace ajar
