#include "render/technique_choice.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "integrators/integrator.h"
#include "math/random.h"

namespace ajar {

namespace {

struct Candidate {
  const char* name;
  const char* integrator;
  double ray_cost;              ///< of one ray and what belongs to it, in path tracing's (docs/benchmarks/auto.md)
};
/// The first is the one to stay with.
constexpr Candidate kCandidates[] = {{"path tracing", "path", 1.0},
                                     {"energy redistribution", "erpt", 1.2},
                                     {"population Monte Carlo", "pmc_pt", 1.2}};
constexpr int kPilotPixels = 12288, kFewestPixels = 768;
constexpr int kPilotSamples = 8;              // in two pictures
constexpr int kBlur = 3;                      // pixels to each side
/// The pilot may take this share of the samples asked for.
constexpr double kPilotShare = 0.08;
/// Samples a second and thread that a time limit is taken to allow.
constexpr double kSamplesPerSecond = 5e5;
/// relMSE after the pilot's samples at which path tracing does well.
constexpr double kEasyRelmse = 0.05;
/// Another technique must be this much better than path tracing, whose stratification a small picture shows least.
constexpr double kClearlyBetter = 1.5;

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, value >= 10.0 ? "%.0f" : "%.2g", value);
  return buffer;
}

/// Pixels of a pilot that costs no more than its share of the render.
int affordable_pixels(const RenderSettings& s) {
  double samples = s.samples > 0 ? double(s.samples) * s.width * s.height : 1e18;
  if (s.seconds > 0.0) samples = std::min(samples, s.seconds * kSamplesPerSecond * std::max(1, s.threads));
  const double all = kPilotShare * samples / (kPilotSamples * double(std::size(kCandidates)));
  return int(std::min({all, double(kPilotPixels), double(s.width) * s.height}));
}

/// Two independent pictures by one technique.
struct Pilot {
  std::vector<float> first, second;   // RGBA
  double rays = 0.0;
};

Pilot run_pilot(const Candidate& candidate, const std::shared_ptr<const Scene>& scene, const std::atomic<bool>& stop) {
  Pilot pilot;
  const RenderSettings& s = scene->settings();
  for (uint32_t half = 0; half < 2; ++half) {
    const auto integrator = make_integrator(candidate.integrator);
    integrator->prepare(scene, hash_combine(s.seed, 0x6175746FU + half));
    Film film(0, 0, s.width, s.height, {"Combined"});
    integrator->run_iteration(film, kPilotSamples / 2, stop);
    (half == 0 ? pilot.first : pilot.second) = film.resolve("Combined", 1.0f);
    pilot.rays += double(integrator->statistics().rays);
  }
  return pilot;
}

/// Mean of pictures, blurred: what errors are relative to.
std::vector<float> blurred_mean(const std::vector<Pilot>& pilots, size_t from, int width, int height) {
  std::vector<float> mean(pilots[0].first.size(), 0.0f);
  const float share = 0.5f / float(pilots.size() - from);
  for (size_t k = from; k < pilots.size(); ++k)
    for (size_t i = 0; i < mean.size(); ++i) mean[i] += share * (pilots[k].first[i] + pilots[k].second[i]);
  std::vector<float> blurred(mean.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 4; ++c) {
        float sum = 0.0f;
        int count = 0;
        for (int v = std::max(0, y - kBlur); v <= std::min(height - 1, y + kBlur); ++v)
          for (int u = std::max(0, x - kBlur); u <= std::min(width - 1, x + kBlur); ++u, ++count) sum += mean[4 * (size_t(v) * size_t(width) + size_t(u)) + size_t(c)];
        blurred[4 * (size_t(y) * size_t(width) + size_t(x)) + size_t(c)] = sum / float(count);
      }
  return blurred;
}

double relmse_of(const Pilot& pilot, const std::vector<float>& truth) {
  double sum = 0.0;
  for (size_t i = 0; i < truth.size(); ++i) {
    if (i % 4 == 3) continue;
    const double difference = double(pilot.first[i]) - double(pilot.second[i]);
    sum += 0.25 * difference * difference / (double(truth[i]) * double(truth[i]) + 0.01);
  }
  return sum / (0.75 * double(truth.size()));
}

}  // namespace

RenderPlan TechniqueChoice::plan() const {
  RenderPlan plan{{"technique", true, name + ": " + reason}};
  const double path = trials.empty() ? 0.0 : trials.front().cost;
  for (const TechniqueTrial& trial : trials) {
    plan.push_back({std::string("trial of ") + trial.name, trial.name == name,
                    "relMSE " + text(trial.relmse) + " with " + text(trial.rays) + " rays" +
                        (trial.cost > 0.0 && &trial != &trials.front() ? ", " + text(path / trial.cost) + " times the efficiency of path tracing" : "")});
  }
  return plan;
}

TechniqueChoice choose_technique(const std::shared_ptr<Scene>& scene, const CameraDescription& camera, const std::atomic<bool>& stop) {
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
  const int pixels = affordable_pixels(asked);
  if (pixels < kFewestPixels) {
    choice.reason = "too few samples to pay for a pilot";
    return choice;
  }

  RenderSettings small = asked;
  const double scale = std::min(1.0, std::sqrt(double(pixels) / (double(asked.width) * asked.height)));
  small.width = std::max(1, int(std::lround(asked.width * scale)));
  small.height = std::max(1, int(std::lround(asked.height * scale)));
  small.region = {0, 0, 0, 0};
  small.passes = {"Combined"};
  small.image = "uniform";
  scene->change_view(camera, small);
  std::vector<Pilot> pilots;
  for (const Candidate& candidate : kCandidates) {
    pilots.push_back(run_pilot(candidate, scene, stop));
    if (stop.load()) break;
    if (pilots.size() == 1 && relmse_of(pilots[0], blurred_mean(pilots, 0, small.width, small.height)) < kEasyRelmse) break;
  }
  scene->change_view(camera, asked);
  if (stop.load()) return choice;
  // Path tracing misses most of what is hard to find: the others tell what there is.
  const std::vector<float> truth = blurred_mean(pilots, pilots.size() > 1 ? 1 : 0, small.width, small.height);
  for (size_t k = 0; k < pilots.size(); ++k) {
    const double relmse = relmse_of(pilots[k], truth);
    choice.trials.push_back({kCandidates[k].name, relmse, pilots[k].rays, relmse * pilots[k].rays * kCandidates[k].ray_cost});
  }
  const TechniqueTrial* best = nullptr;
  for (const TechniqueTrial& trial : choice.trials) {
    const double handicap = best == &choice.trials.front() ? kClearlyBetter : 1.0;
    if (!best || (trial.cost > 0.0 && trial.cost * handicap < best->cost)) best = &trial;
  }
  const Candidate& chosen = kCandidates[best - choice.trials.data()];
  choice.settings.integrator = chosen.integrator;
  choice.name = chosen.name;
  choice.reason = choice.trials.size() == 1         ? "it finds the light well"
                  : best == &choice.trials.front() ? "no other technique is clearly better"
                                                   : text(choice.trials.front().cost / best->cost) + " times the efficiency of path tracing in a small picture";
  choice.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return choice;
}

}  // namespace ajar
