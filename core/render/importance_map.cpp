#include "render/importance_map.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "integrators/path_tracer.h"
#include "shading/bsdf/shading_point.h"

namespace ajar {

namespace {

/// Samples per pixel of the pilot: a fraction of those of the image, within bounds; 1 if that number is unknown.
constexpr float kPilotShare = 0.06f, kMinPilot = 0.25f, kMaxPilot = 4.0f;
/// Standard deviation, in pixels, of the Gaussian over which the light of the pilot is averaged, and its radius.
constexpr float kReach = 1.5f;
constexpr int kRadius = 3;

bool objects_matter(const Scene& scene) {
  return std::any_of(scene.instances().begin(), scene.instances().end(),
                     [&](const BuiltInstance& instance) { return scene.object(instance.object).importance != 1.0f; });
}

/// Sums around each pixel with Gaussian weights, along one axis. Pixels are `step` apart; each row of `length` pixels
/// begins at one of `begins`.
std::vector<Vec2> smoothed(const std::vector<Vec2>& light, const std::vector<size_t>& begins, int length, size_t step) {
  std::vector<Vec2> sums(light.size(), Vec2(0.0f));
  tbb::parallel_for(size_t(0), begins.size(), [&](size_t row) {
    for (int i = 0; i < length; ++i)
      for (int k = std::max(0, i - kRadius); k <= std::min(length - 1, i + kRadius); ++k)
        sums[begins[row] + size_t(i) * step] += std::exp(-0.5f * float((k - i) * (k - i)) / (kReach * kReach)) *
                                                light[begins[row] + size_t(k) * step];
  });
  return sums;
}

void multiply_by_light(const std::shared_ptr<const Scene>& scene, uint32_t seed, const std::atomic<bool>& stop,
                       int width, int height, std::vector<float>& map) {
  const RenderSettings& s = scene->settings();
  const float samples = s.samples > 0 && s.seconds == 0.0 && s.target_error == 0.0
                            ? std::clamp(kPilotShare * float(s.samples), kMinPilot, kMaxPilot)
                            : 1.0f;
  std::vector<Vec2> light = measure_important_light(scene, seed, samples, stop);
  std::vector<size_t> rows, columns;
  for (int y = 0; y < height; ++y) rows.push_back(size_t(y) * size_t(width));
  for (int x = 0; x < width; ++x) columns.push_back(size_t(x));
  light = smoothed(smoothed(light, rows, width, 1), columns, height, size_t(width));
  for (size_t i = 0; i < map.size(); ++i)
    if (light[i].x > 0.0f && light[i].y >= 0.0f) map[i] *= light[i].y / light[i].x;  // weights of media can be negative
}

}  // namespace

bool has_importance(const Scene& scene) {
  return scene.settings().importance_factor != 1.0f || objects_matter(scene) || scene.any_light_importance();
}

std::vector<float> importance_map(const std::shared_ptr<const Scene>& shared, uint32_t seed,
                                  const std::atomic<bool>& stop) {
  const Scene& scene = *shared;
  if (!has_importance(scene)) return {};
  const RenderSettings& s = scene.settings();
  const bool objects = objects_matter(scene);
  const int width = s.region[2] - s.region[0], height = s.region[3] - s.region[1];
  std::vector<float> map(size_t(width) * size_t(height));
  tbb::parallel_for(s.region[1], s.region[3], [&](int y) {
    for (int x = s.region[0]; x < s.region[2]; ++x) {
      const Vec2 centre(float(x) + 0.5f, float(y) + 0.5f), part = centre / Vec2(float(s.width), float(s.height));
      const auto& r = s.importance_region;
      float importance = part.x >= r[0] && part.y >= r[1] && part.x < r[2] && part.y < r[3] ? s.importance_factor
                                                                                            : 1.0f;
      if (objects) {
        const Hit hit = scene.intersect(scene.camera().generate_ray(centre, Vec2(0.5f), 0.0f), kRayCamera);
        if (hit.found()) importance *= scene.object(scene.instances()[hit.instance].object).importance;
      }
      map[size_t(y - s.region[1]) * size_t(width) + size_t(x - s.region[0])] = importance;
    }
  });
  if (scene.any_light_importance()) multiply_by_light(shared, seed, stop, width, height, map);
  return map;
}

}  // namespace ajar
