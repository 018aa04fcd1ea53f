// Interprets arbitrary bytes as a scene file. The file is refused with a message, or it renders to finite numbers. Its
// seed selects the integrator and its settings.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include <tbb/global_control.h>

#include "description/archive.h"
#include "film/image_plan.h"
#include "integrators/integrator.h"
#include "integrators/learned.h"
#include "integrators/render_plan.h"
#include "mutate_scene.h"
#include "render/importance_map.h"
#include "render/memory_estimate.h"
#include "scene/scene.h"
#include "transport/hints/hints.h"

using namespace ajar;

namespace {

constexpr uint32_t kPilotSeed = 17;
const std::atomic<bool> kGoOn{false};

/// Options of the render that are not part of the settings.
struct Extras {
  bool adapts = false;  ///< sample counts follow noise and importance
  bool all_passes = false;
  bool next_frame = false;  ///< renders a second frame that starts with the learned data
};

/// Takes digits from the seed, each with its own base.
Extras choose_technique(RenderSettings& s) {
  uint32_t left = s.seed;
  const auto digit = [&](size_t base) {
    const size_t value = left % base;
    left /= uint32_t(base);
    return value;
  };
  s.integrator = integrator_list()[digit(integrator_list().size())].name;
  const auto& methods = choices<DirectMethod>().all;
  s.direct = methods[digit(methods.size())].value;
  s.guiding = digit(2) ? Guiding::On : Guiding::Off;
  s.vertex_merging = digit(2) ? Merging::On : Merging::Off;
  Extras extras;
  extras.adapts = digit(3) == 1;
  extras.all_passes = digit(3) == 1;
  extras.next_frame = digit(3) == 1;
  return extras;
}

/// Limits settings that are valid but take a long time.
void limit(RenderSettings& s) {
  if (s.width > 8 || s.height > 8) s.region = {0, 0, 0, 0};
  s.width = std::min(s.width, 8);
  s.height = std::min(s.height, 8);
  s.direct_samples = std::min(s.direct_samples, 4);
  for (int* bounces : {&s.bounces.total, &s.bounces.diffuse, &s.bounces.glossy, &s.bounces.transmission,
                       &s.bounces.transparent, &s.bounces.volume})
    *bounces = std::min(*bounces, 8);
  s.photons = std::clamp(s.photons, 1, 200);
  s.gather_rays = std::min(s.gather_rays, 4);
  s.samples = 2;
}

void check(bool fine) {
  if (!fine) std::abort();
}

void render(const std::shared_ptr<const Scene>& scene, const Extras& extras, Learned& learned) {
  const IntegratorInfo& asked = find_integrator(scene->settings().integrator);
  const auto technique = make_integrator(asked.name);
  technique->prepare(scene, 1);
  technique->begin_with(learned);
  const auto& r = scene->settings().region;
  std::vector<std::string> passes{"Combined"};
  if (extras.all_passes)
    for (const PassInfo& pass : known_passes()) passes.push_back(pass.name);
  Film film(r[0], r[1], r[2], r[3], passes);
  if (extras.adapts && technique->goal_support().follows && technique->goal_support().equal <= 2) {
    const auto importance = [&] { return importance_map(scene, kPilotSeed, kGoOn); };
    ImagePlan plan(scene->settings().image_error, 2, 1, importance,
                   technique->goal_support().by_passes ? Counts::Any : Counts::Round);
    for (uint32_t done = 0; done < 4;) {
      const uint32_t next = technique->goal_support().by_passes ? done + 1 : std::min(4u, plan.next_decision(done));
      plan.plan(film, next);
      technique->run_iteration(film, int(next - done), kGoOn);
      done = next;
    }
  } else {
    for (int samples : {1, 1})
      technique->run_iteration(film, samples, kGoOn);  // two iterations, so that integrators learn in between
  }
  technique->statistics();
  technique->photons(100);
  technique->hand_on(learned);
  film.estimated_error(2);
  for (const std::string& pass : passes) {
    const bool of_samples = pass == "Combined" || pass == "Sample Count";
    for (float value : film.resolve(pass, 1.0f)) check(std::isfinite(value) || !of_samples);
  }
}

}  // namespace

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t most);

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t most, unsigned seed) {
  fuzz::Random random(seed | 1u);
  if (random() % 4 == 0) return LLVMFuzzerMutate(data, size, most);
  try {
    SceneDescription d = from_bytes(std::vector<char>(data, data + size));
    for (unsigned k = 1 + random() % 3; k > 0; --k) fuzz::mutate(d, random);
    const std::vector<char> bytes = to_bytes(d);
    if (bytes.size() > most) return LLVMFuzzerMutate(data, size, most);
    std::memcpy(data, bytes.data(), bytes.size());
    return bytes.size();
  } catch (const SceneError&) {
    return LLVMFuzzerMutate(data, size, most);
  }
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  try {
    SceneDescription d = from_bytes(std::vector<char>(data, data + size));
    const std::vector<char> again = to_bytes(d);
    check(to_bytes(from_bytes(again)) == again);
    const Extras extras = choose_technique(d.settings);
    check_memory_limit(d);
    limit(d.settings);
    for (ImageDescription& image : d.images) image.path.clear();  // no files of the machine are read
    Diagnostics diagnostics;
    const auto scene = Scene::build(std::move(d), {}, diagnostics);
    std::vector<HintReport> reports;
    Hints::attach(*scene, reports);
    make_render_plan(*scene);
    Learned learned;
    for (int frames = extras.next_frame ? 2 : 1; frames > 0; --frames) render(scene, extras, learned);
  } catch (const SceneError&) {
  }
  return 0;
}
