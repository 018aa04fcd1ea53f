#include "render/importance_map.h"

#include <algorithm>

#include <tbb/parallel_for.h>

#include "shading/shading_point.h"

namespace ajar {

std::vector<float> importance_map(const Scene& scene) {
  const RenderSettings& s = scene.settings();
  const bool objects = std::any_of(scene.instances().begin(), scene.instances().end(),
                                   [&](const BuiltInstance& i) { return scene.object(i.object).importance != 1.0f; });
  if (!objects && s.importance_factor == 1.0f) return {};
  const int width = s.region[2] - s.region[0];
  std::vector<float> map(size_t(width) * size_t(s.region[3] - s.region[1]));
  tbb::parallel_for(s.region[1], s.region[3], [&](int y) {
    for (int x = s.region[0]; x < s.region[2]; ++x) {
      const Vec2 centre(float(x) + 0.5f, float(y) + 0.5f), part = centre / Vec2(float(s.width), float(s.height));
      const auto& r = s.importance_region;
      float importance = part.x >= r[0] && part.y >= r[1] && part.x < r[2] && part.y < r[3] ? s.importance_factor : 1.0f;
      if (objects) {
        const Hit hit = scene.intersect(scene.camera().generate_ray(centre, Vec2(0.5f), 0.0f), kRayCamera);
        if (hit.found()) importance *= scene.object(scene.instances()[hit.instance].object).importance;
      }
      map[size_t(y - s.region[1]) * size_t(width) + size_t(x - s.region[0])] = importance;
    }
  });
  return map;
}

}  // namespace ajar
