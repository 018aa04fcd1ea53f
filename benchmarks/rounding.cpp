// rounding SCENE.ajar [--integrator NAME] [--scale S] [--samples N] [--seeds N] [--threads N] Measures the error by
// rounding of floats relative to the noise at 4096 samples per pixel (tests/core/rounding.h). Prints one row of a table
// for each direction of rounding.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "description/archive.h"
#include "rounding.h"

int main(int argc, char** argv) {
  using namespace ajar;
  if (argc < 2) {
    std::fprintf(
        stderr, "usage: rounding SCENE.ajar [--integrator NAME] [--scale S] [--samples N] [--seeds N] [--threads N]\n");
    return 2;
  }
  const auto option = [&](const char* name, const char* otherwise) {
    for (int i = 2; i + 1 < argc; i += 2)
      if (std::strcmp(argv[i], name) == 0) return static_cast<const char*>(argv[i + 1]);
    return otherwise;
  };
  try {
    SceneDescription d = load_description(argv[1]);
    const double scale = std::atof(option("--scale", "0.1"));
    d.settings.width = std::max(1, int(scale * d.settings.width));
    d.settings.height = std::max(1, int(scale * d.settings.height));
    d.settings.region = {0, 0, 0, 0};
    d.settings.direct = DirectMethod::Mis;
    d.settings.guiding = Guiding::Off;  // learned data would differ after the first different sample
    const std::string integrator = option("--integrator", "path");
    Diagnostics diagnostics;
    const auto scene = Scene::build(std::move(d), {}, diagnostics);
    const int samples = std::atoi(option("--samples", "16")), seeds = std::atoi(option("--seeds", "8"));
    for (const rounding::Share& share :
         rounding::measure(scene, integrator, samples, seeds, std::atoi(option("--threads", "1"))))
      std::printf("| %s | %s | %s | %.4f | %.4f (± %.4f) | %+.1e ± %.1e |\n", argv[1], integrator.c_str(), share.mode,
                  share.straying, share.shift, share.resolution, share.mean_change, share.mean_change_error);
  } catch (const SceneError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
