#include "render/technique_choice.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "integrators/integrator.h"
#include "math/random.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

namespace {

struct Candidate {
  const char* name;
  const char* integrator;
  double ray_cost;  ///< of one ray and what belongs to it, in path tracing's (docs/benchmarks/auto.md)
  /// relMSE of long renders over what short ones foretell: rare bright starts that none of these had (same page)
  double tail;
  bool unbiased;  ///< but for what vertex merging blurs, which is left out of account
  bool spreads;   ///< chains spread light over pixels of a size of their own
  int samples;    ///< of each of the pilot's two pictures: fewer where a sample brings photons for the whole picture
  /// of each sample of the pilot at most, unless 0: with fewer, discs grow until they hold as many, so that bias grows
  /// and noise does not
  int photons;
};
/// The first is the one to stay with.
constexpr Candidate kCandidates[] = {{"path tracing", "path", 1.0, 1.75, true, false, 4, 0},
                                     {"energy redistribution", "erpt", 1.4, 1.5, true, true, 4, 0},
                                     {"photon mapping", "photon_map", 2.5, 0.85, false, false, 1, 5000}};
constexpr int kPilotPixels = 12288, kMinPixels = 768;
constexpr int kPilotSamples = 2 * kCandidates[0].samples;  // of path tracing
/// The pilot may take this share of the samples asked for.
constexpr double kPilotShare = 0.06;
/// Error that is no noise falls with the passes to this power: photon radii shrink as passes^(-1/6) [Knaus and Zwicker
/// 2011].
constexpr double kBiasRate = -2.0 / 3.0;
/// Samples a pixel that a render is taken to have which is told neither samples nor time.
constexpr double kUsualSamples = 512.0;
/// Work of all candidates for a pixel and sample of path tracing in the pilot, in its own: measured on `room`, in CPU
/// time, but for what photons take.
constexpr double kPilotWork = 4.0;
/// How fast path tracing is, where a time limit asks: tried with so many pixels and samples.
constexpr int kTimedPixels = 1024, kTimedSamples = 4;
/// relMSE after the pilot's samples at which path tracing does well. Where it has found nothing at all, its error may
/// be all there is.
constexpr double kEasyRelmse = 0.05;

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, value >= 10.0 ? "%.0f" : "%.2g", value);
  return buffer;
}

/// The same picture with about so many pixels, not more than it has.
RenderSettings smaller(const RenderSettings& asked, double pixels) {
  RenderSettings small = asked;
  const double scale = std::min(1.0, std::sqrt(pixels / (double(asked.width) * asked.height)));
  small.width = std::max(1, int(std::lround(asked.width * scale)));
  small.height = std::max(1, int(std::lround(asked.height * scale)));
  small.region = {0, 0, 0, 0};
  small.passes = {"Combined"};
  small.image = "uniform";
  return small;
}

/// What the pilots render.
struct Tried {
  const std::shared_ptr<Scene>& scene;
  const CameraDescription& camera;
  const RenderSettings& asked;
  std::shared_ptr<const AttachedHints> hints;  // of the scene; null: not attached yet

  /// The integrator, ready to render a picture with these settings. Leaves the scene's view changed.
  std::unique_ptr<Integrator> prepared(const char* name, const RenderSettings& settings, uint32_t seed) const {
    scene->change_view(camera, settings);
    const IntegratorInfo& info = find_integrator(name);
    auto integrator = info.make();
    integrator->prepare(scene, make_render_plan(*scene, info, hints), seed);
    return integrator;
  }
};

/// Samples a second by path tracing, all threads together. Leaves the scene's view changed.
double samples_per_second(const Tried& tried, const std::atomic<bool>& stop) {
  const RenderSettings small = smaller(tried.asked, kTimedPixels);
  const auto integrator = tried.prepared(kCandidates[0].integrator, small, tried.asked.seed);
  Film film(0, 0, small.width, small.height, {"Combined"});
  const auto start = std::chrono::steady_clock::now();
  integrator->run_iteration(film, kTimedSamples, stop);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return kTimedSamples * double(small.width) * small.height / std::max(seconds, 1e-6);
}

/// Samples of path tracing that the render may take, in all pixels. `rate`: a second.
double samples_of_render(const RenderSettings& s, double rate) {
  const double pixels = double(s.width) * s.height;
  double samples = s.samples > 0 ? s.samples * pixels : 1e18;
  if (s.seconds > 0.0) samples = std::min(samples, s.seconds * rate);
  return samples < 1e18 ? samples : kUsualSamples * pixels;
}

struct Pilot : PilotImages {
  double rays = 0.0;  // as if the picture had its share of the render's photons; without those that learn once
};

/// relMSE of chains in a picture of so many pixels, over that in a large one: the fewer there are, the fewer chains
/// does each see (docs/benchmarks/auto.md).
double crowding(double pixels) { return 1.0 + std::pow(2300.0 / pixels, 2.0 / 3.0); }

/// Photons for a pixel of the render over those for a pixel of a pilot: a small picture has more than its share.
double photon_share(const RenderSettings& asked, const RenderSettings& small) {
  const double pixels = double(asked.width) * asked.height, few = double(small.width) * small.height;
  return photons_of_a_pass(asked) / pixels * few / photons_of_a_pass(small);
}

/// Leaves the scene's view changed. `small`: of the picture.
Pilot run_pilot(const Candidate& candidate, const Tried& tried, RenderSettings small, const std::atomic<bool>& stop) {
  if (candidate.photons > 0 && (small.photons == 0 || small.photons > candidate.photons))
    small.photons = candidate.photons;
  Pilot pilot;
  for (uint32_t half = 0; half < 2; ++half) {
    const auto integrator = tried.prepared(candidate.integrator, small, hash_combine(small.seed, 0x6175746FU + half));
    Film film(0, 0, small.width, small.height, {"Combined"});
    integrator->run_iteration(film, candidate.samples, stop);
    (half == 0 ? pilot.first : pilot.second) = film.resolve("Combined", tried.asked.exposure);
    IntegratorStatistics statistics = integrator->statistics();
    pilot.rays += double(statistics.rays) - (1.0 - photon_share(tried.asked, small)) * statistics.extra["photon_rays"] -
                  statistics.extra["hint_rays"];
  }
  return pilot;
}

/// Share of the pixels that show a surface, and in neither picture any light. The scene is looked at as it was for the
/// pilot.
double unlit_share(const Scene& scene, const PilotImages& pilot) {
  const int width = scene.settings().width, height = scene.settings().height;
  const auto has_light = [](const std::vector<float>& image, size_t pixel) {
    return image[4 * pixel] > 0.0f || image[4 * pixel + 1] > 0.0f || image[4 * pixel + 2] > 0.0f;
  };
  size_t unlit = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const size_t pixel = size_t(y) * size_t(width) + size_t(x);
      if (has_light(pilot.first, pixel) || has_light(pilot.second, pixel)) continue;
      const Ray ray = scene.camera().generate_ray(Vec2(float(x) + 0.5f, float(y) + 0.5f), Vec2(0.5f),
                                                  scene.camera().time_of(0.5f));
      if (!sees_nothing(ray) && scene.intersect(ray, kRayCamera).found()) ++unlit;
    }
  return double(unlit) / (double(width) * double(height));
}

/// What the pilots foretell of a render of so many samples: those of the first so many candidates.
std::vector<TechniqueTrial> trials_of(const std::vector<Pilot>& pilots, const RenderSettings& asked,
                                      const RenderSettings& small, double samples_asked) {
  std::vector<const PilotImages*> pictures;
  for (const Pilot& pilot : pilots) pictures.push_back(&pilot);
  const std::vector<float> light = max_light(pictures, small.width, small.height);
  const double pixels = double(asked.width) * asked.height, few = double(small.width) * small.height;
  std::vector<TechniqueTrial> trials;
  std::vector<PilotNoise> noises;
  size_t calmest = 0;  // of those that are unbiased
  for (size_t k = 0; k < pilots.size(); ++k) {
    noises.push_back(noise_of(pilots[k], light));
    // What chains have missed is no such measure of theirs, as neighbours share them.
    for (size_t j = 0; j < pilots.size() && kCandidates[k].unbiased && !kCandidates[k].spreads; ++j) {
      if (j == k || !kCandidates[j].unbiased) continue;
      const double unseen = unseen_noise_of(pilots[k], pilots[j], light, small.width, small.height);
      noises[k].whole += unseen;
      noises[k].typical += unseen;
    }
    trials.push_back({kCandidates[k].name, noises[k].whole, pilots[k].rays});
    if (kCandidates[k].unbiased && noises[k].whole < noises[calmest].whole) calmest = k;
  }
  // Noise falls with the samples that the render's rays pay for, bias more slowly.
  const double rays_asked = samples_asked * pilots[0].rays / (kPilotSamples * few);
  for (size_t k = 0; k < pilots.size(); ++k) {
    const Candidate& candidate = kCandidates[k];
    if (!candidate.unbiased) trials[k].bias = bias_of(pilots[k], pilots[calmest], light, small.width, small.height);
    const double longer = std::max(1.0, rays_asked / (pilots[k].rays * candidate.ray_cost * pixels / few));
    const double crowded = candidate.spreads ? crowding(few) / crowding(pixels) : 1.0;
    const double noise_left = candidate.tail / (longer * crowded),
                 bias_left = trials[k].bias * std::pow(longer, kBiasRate);
    trials[k].cost = {noise_left * noises[k].whole + bias_left, noise_left * noises[k].typical + bias_left};
  }
  return trials;
}

}  // namespace

PlanSteps TechniqueChoice::plan() const {
  PlanSteps plan{{"technique", true, name + ": " + reason}};
  const PilotNoise path = trials.empty() ? PilotNoise() : trials.front().cost;
  for (const TechniqueTrial& trial : trials) {
    plan.push_back({std::string("trial of ") + trial.name, trial.name == name,
                    "relMSE " + text(trial.relmse) + " with " + text(trial.rays) + " rays" +
                        (trial.bias > 0.0 ? ", bias " + text(trial.bias) : "") +
                        (trial.cost.typical > 0.0 && &trial != &trials.front()
                             ? ", " + text(path.whole / trial.cost.whole) +
                                   " times the efficiency of path tracing (without the worst pixels " +
                                   text(path.typical / trial.cost.typical) + ")"
                             : "")});
  }
  return plan;
}

TechniqueChoice choose_technique(const std::shared_ptr<Scene>& scene, const CameraDescription& camera,
                                 const std::atomic<bool>& stop, std::shared_ptr<const AttachedHints> hints) {
  const auto start = std::chrono::steady_clock::now();
  const RenderSettings asked = scene->settings();
  TechniqueChoice choice;
  choice.settings = asked;
  choice.settings.integrator = kCandidates[0].integrator;
  choice.name = kCandidates[0].name;
  if (scene->lights().empty()) {
    choice.reason = "nothing is known to emit light";
    return choice;
  }
  if (asked.bounces.total < 1) {
    choice.reason = "light does not bounce";
    return choice;
  }
  for (const Candidate& candidate : kCandidates) {
    choice.reason = reason_against(find_integrator(candidate.integrator), *scene);
    if (!choice.reason.empty()) return choice;
  }
  const Tried tried{scene, camera, asked, std::move(hints)};
  const double samples_asked = samples_of_render(asked, asked.seconds > 0.0 ? samples_per_second(tried, stop) : 0.0);
  // A pilot costs no more than its share of the render.
  const double pixels = std::min({kPilotShare * samples_asked / (kPilotSamples * kPilotWork), double(kPilotPixels),
                                  double(asked.width) * asked.height});
  if (pixels < kMinPixels) {
    scene->change_view(camera, asked);
    choice.reason = "too few samples to pay for a pilot";
    return choice;
  }

  const RenderSettings small = smaller(asked, pixels);
  std::vector<Pilot> pilots;
  for (const Candidate& candidate : kCandidates) {
    pilots.push_back(run_pilot(candidate, tried, small, stop));
    if (stop.load()) break;
    choice.trials = trials_of(pilots, asked, small, samples_asked);
    // Photon mapping is not tried where chains are hopeless: both pay where light is hard to find from the eye.
    if (pilots.size() == 1 ? choice.trials[0].relmse + unlit_share(*scene, pilots[0]) < kEasyRelmse
                           : is_hopeless(choice.trials[1].cost, choice.trials[0].cost))
      break;
  }
  scene->change_view(camera, asked);
  if (stop.load()) {
    choice.trials.clear();
    choice.reason = "the pilot was stopped before it could tell";
    return choice;
  }
  std::vector<PilotNoise> costs;
  for (const TechniqueTrial& trial : choice.trials) costs.push_back(trial.cost);
  const size_t best = clearly_best(costs);
  choice.settings.integrator = kCandidates[best].integrator;
  choice.name = kCandidates[best].name;
  choice.reason = costs.size() == 1 ? "it finds the light well"
                  : best == 0       ? "no other technique is clearly better"
                                    : text(costs[0].whole / costs[best].whole) +
                                    " times the efficiency of path tracing in a small picture";
  choice.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return choice;
}

}  // namespace ajar
