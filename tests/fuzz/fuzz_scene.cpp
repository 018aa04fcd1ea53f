// Any bytes as a scene file: it is refused in words, or it renders to numbers.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <tbb/global_control.h>

#include "integrators/integrator.h"
#include "scene/archive.h"
#include "scene/scene.h"

using namespace ajar;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  try {
    SceneDescription d = from_bytes(std::vector<char>(data, data + size));
    RenderSettings& s = d.settings;
    // What a user may ask for takes long, and is no fault.
    s.width = std::min(s.width, 8);
    s.height = std::min(s.height, 8);
    s.region = {0, 0, 0, 0};
    s.direct_samples = std::clamp(s.direct_samples, 1, 4);
    for (int* bounces : {&s.bounces.total, &s.bounces.diffuse, &s.bounces.glossy, &s.bounces.transmission, &s.bounces.transparent})
      *bounces = std::clamp(*bounces, 0, 8);
    for (ImageDescription& image : d.images) image.path.clear();   // not this machine's files
    Diagnostics diagnostics;
    const auto scene = Scene::build(std::move(d), {}, diagnostics);
    const auto technique = make_integrator("path");
    technique->prepare(scene, 1);
    Film film(0, 0, scene->settings().width, scene->settings().height, {"Combined"});
    const std::atomic<bool> go_on{false};
    technique->run_iteration(film, 1, go_on);
    for (float value : film.resolve("Combined", 1.0f))
      if (!std::isfinite(value)) std::abort();
  } catch (const SceneError&) {
  }
  return 0;
}
