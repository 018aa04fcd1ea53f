// Any bytes as a scene file: it is refused in words, or it renders to numbers. Its seed says by which integrator and how.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <tbb/global_control.h>

#include "integrators/integrator.h"
#include "scene/archive.h"
#include "scene/scene.h"
#include "transport/direct_light.h"
#include "transport/hints.h"

using namespace ajar;

namespace {

/// Digits of the seed, each of what is left of it.
void choose_technique(RenderSettings& s) {
  uint32_t left = s.seed;
  const auto digit = [&](size_t base) {
    const size_t value = left % base;
    left /= uint32_t(base);
    return value;
  };
  s.integrator = integrator_list()[digit(integrator_list().size())].name;
  s.direct = direct_method_list()[digit(direct_method_list().size())].name;
  s.guiding = digit(2) ? "on" : "off";
  s.vertex_merging = digit(2) ? "on" : "off";
}

}  // namespace

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
    for (int* bounces : {&s.bounces.total, &s.bounces.diffuse, &s.bounces.glossy, &s.bounces.transmission, &s.bounces.transparent, &s.bounces.volume})
      *bounces = std::clamp(*bounces, 0, 8);
    s.photons = std::clamp(s.photons, 1, 200);
    s.gather_rays = std::clamp(s.gather_rays, 0, 4);
    s.samples = 2;
    choose_technique(s);
    for (ImageDescription& image : d.images) image.path.clear();   // not this machine's files
    Diagnostics diagnostics;
    const auto scene = Scene::build(std::move(d), {}, diagnostics);
    std::vector<HintReport> reports;
    Hints::attach(*scene, reports);
    const IntegratorInfo& asked = find_integrator(scene->settings().integrator);
    const auto technique = make_integrator(reason_against(asked, *scene).empty() ? asked.name : "path");
    technique->prepare(scene, 1);
    Film film(0, 0, scene->settings().width, scene->settings().height, {"Combined"});
    const std::atomic<bool> go_on{false};
    for (int samples : {1, 1}) technique->run_iteration(film, samples, go_on);   // what learns does so in between
    technique->statistics();
    for (float value : film.resolve("Combined", 1.0f))
      if (!std::isfinite(value)) std::abort();
  } catch (const SceneError&) {
  }
  return 0;
}
