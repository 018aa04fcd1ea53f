#include "render/technique_choice.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "integrators/integrator.h"
#include "math/random.h"
#include "transport/photon_tracer.h"

namespace ajar {

namespace {

struct Candidate {
  const char* name;
  const char* integrator;
  double ray_cost;              ///< of one ray and what belongs to it, in path tracing's (docs/benchmarks/auto.md)
  double tail;                  ///< relMSE of long renders over what short ones foretell: rare bright starts that none of these had (same page)
  bool unbiased;                ///< but for what vertex merging blurs, which is left out of account
  bool spreads;                 ///< chains spread light over pixels of a size of their own
  int samples;                  ///< of each of the pilot's two pictures: fewer where a sample brings photons for the whole picture
};
/// The first is the one to stay with.
constexpr Candidate kCandidates[] = {{"path tracing", "path", 1.0, 1.75, true, false, 4},
                                     {"energy redistribution", "erpt", 1.4, 3.0, true, true, 4},
                                     {"photon mapping", "photon_map", 2.5, 0.85, false, false, 1}};
constexpr int kPilotPixels = 12288, kFewestPixels = 768;
constexpr int kPilotSamples = 2 * kCandidates[0].samples;   // of path tracing
constexpr int kBlur = 3;                      // pixels to each side
/// The pilot may take this share of the samples asked for.
constexpr double kPilotShare = 0.06;
/// Error that is no noise falls with the passes to this power: photon radii shrink as passes^(-1/6) [Knaus and Zwicker 2011].
constexpr double kBiasRate = -2.0 / 3.0;
/// Samples a pixel that a render is taken to have which is told neither samples nor time.
constexpr double kUsualSamples = 512.0;
/// Work of all candidates for a pixel and sample of path tracing in the pilot, in its own: measured on `room`, in CPU time, but for what photons take.
constexpr double kPilotWork = 4.0;
/// How fast path tracing is, where a time limit asks: tried with so many pixels and samples.
constexpr int kTimedPixels = 1024, kTimedSamples = 4;
/// relMSE after the pilot's samples at which path tracing does well.
constexpr double kEasyRelmse = 0.05;
/// Another technique must be this much better than path tracing, whose stratification a small picture shows least.
constexpr double kClearlyBetter = 1.6;

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

/// Samples a second by path tracing, all threads together. Leaves the scene's view changed.
double samples_per_second(const std::shared_ptr<Scene>& scene, const CameraDescription& camera, const RenderSettings& asked, const std::atomic<bool>& stop) {
  const RenderSettings small = smaller(asked, kTimedPixels);
  scene->change_view(camera, small);
  const auto integrator = make_integrator(kCandidates[0].integrator);
  integrator->prepare(scene, asked.seed);
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

/// Two independent pictures by one technique.
struct Pilot {
  std::vector<float> first, second;   // RGBA
  double rays = 0.0;                  // as if the picture had its share of the render's photons; without those that learn once
};

/// relMSE of chains in a picture of so many pixels, over that in a large one: the fewer there are, the fewer chains does each see (docs/benchmarks/auto.md).
double crowding(double pixels) { return 1.0 + std::pow(2300.0 / pixels, 2.0 / 3.0); }

/// Photons for a pixel of the render over those for a pixel of a pilot: a small picture has more than its share.
double photon_share(const RenderSettings& asked, const RenderSettings& small) {
  const double pixels = double(asked.width) * asked.height, few = double(small.width) * small.height;
  return asked.photons > 0 ? few / pixels : photons_of_a_pass(pixels) / pixels * few / photons_of_a_pass(few);
}

Pilot run_pilot(const Candidate& candidate, const std::shared_ptr<const Scene>& scene, double photon_share, const std::atomic<bool>& stop) {
  Pilot pilot;
  const RenderSettings& s = scene->settings();
  for (uint32_t half = 0; half < 2; ++half) {
    const auto integrator = make_integrator(candidate.integrator);
    integrator->prepare(scene, hash_combine(s.seed, 0x6175746FU + half));
    Film film(0, 0, s.width, s.height, {"Combined"});
    integrator->run_iteration(film, candidate.samples, stop);
    (half == 0 ? pilot.first : pilot.second) = film.resolve("Combined", 1.0f);
    IntegratorStatistics statistics = integrator->statistics();
    pilot.rays += double(statistics.rays) - (1.0 - photon_share) * statistics.extra["photon_rays"] - statistics.extra["hint_rays"];
  }
  return pilot;
}

/// The mean of both pictures of each pilot, and of those.
std::vector<float> mean_of(const std::vector<const Pilot*>& pilots) {
  std::vector<float> mean(pilots[0]->first.size(), 0.0f);
  const float share = 0.5f / float(pilots.size());
  for (const Pilot* pilot : pilots)
    for (size_t i = 0; i < mean.size(); ++i) mean[i] += share * (pilot->first[i] + pilot->second[i]);
  return mean;
}

/// Means over windows of 2 kBlur + 1 pixels.
std::vector<float> blurred(const std::vector<float>& image, int width, int height) {
  std::vector<float> result(image.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 4; ++c) {
        float sum = 0.0f;
        int count = 0;
        for (int v = std::max(0, y - kBlur); v <= std::min(height - 1, y + kBlur); ++v)
          for (int u = std::max(0, x - kBlur); u <= std::min(width - 1, x + kBlur); ++u, ++count) sum += image[4 * (size_t(v) * size_t(width) + size_t(u)) + size_t(c)];
        result[4 * (size_t(y) * size_t(width) + size_t(x)) + size_t(c)] = sum / float(count);
      }
  return result;
}

double squared_difference(const std::vector<float>& a, const std::vector<float>& b, const std::vector<float>& truth) {
  double sum = 0.0;
  for (size_t i = 0; i < truth.size(); ++i) {
    if (i % 4 == 3) continue;
    const double difference = double(a[i]) - double(b[i]);
    sum += difference * difference / (double(truth[i]) * double(truth[i]) + 0.01);
  }
  return sum / (0.75 * double(truth.size()));
}

double relmse_of(const Pilot& pilot, const std::vector<float>& truth) { return 0.25 * squared_difference(pilot.first, pilot.second, truth); }

/// relMSE of a technique that is no noise: how far its blurred picture is from an unbiased one's, beyond the noise of both.
double bias_of(const Pilot& pilot, const Pilot& unbiased, const std::vector<float>& truth, int width, int height) {
  const auto blur = [&](const std::vector<float>& image) { return blurred(image, width, height); };
  const double noise = 0.25 * (squared_difference(blur(pilot.first), blur(pilot.second), truth) +
                               squared_difference(blur(unbiased.first), blur(unbiased.second), truth));
  return std::max(0.0, squared_difference(blur(mean_of({&pilot})), blur(mean_of({&unbiased})), truth) - noise);
}

}  // namespace

RenderPlan TechniqueChoice::plan() const {
  RenderPlan plan{{"technique", true, name + ": " + reason}};
  const double path = trials.empty() ? 0.0 : trials.front().cost;
  for (const TechniqueTrial& trial : trials) {
    plan.push_back({std::string("trial of ") + trial.name, trial.name == name,
                    "relMSE " + text(trial.relmse) + " with " + text(trial.rays) + " rays" + (trial.bias > 0.0 ? ", bias " + text(trial.bias) : "") +
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
  std::vector<const Candidate*> candidates;
  for (const Candidate& candidate : kCandidates) {
    choice.reason = reason_against(find_integrator(candidate.integrator), *scene);
    if (!choice.reason.empty()) return choice;
    candidates.push_back(&candidate);
  }
  const double samples_asked = samples_of_render(asked, asked.seconds > 0.0 ? samples_per_second(scene, camera, asked, stop) : 0.0);
  // A pilot costs no more than its share of the render.
  const double pixels = std::min({kPilotShare * samples_asked / (kPilotSamples * kPilotWork), double(kPilotPixels), double(asked.width) * asked.height});
  if (pixels < kFewestPixels) {
    scene->change_view(camera, asked);
    choice.reason = "too few samples to pay for a pilot";
    return choice;
  }

  const RenderSettings small = smaller(asked, pixels);
  scene->change_view(camera, small);
  std::vector<Pilot> pilots;
  const auto truth_by = [&](size_t from) {
    std::vector<const Pilot*> used;
    for (size_t k = from; k < pilots.size(); ++k) used.push_back(&pilots[k]);
    return blurred(mean_of(used), small.width, small.height);
  };
  for (const Candidate* candidate : candidates) {
    pilots.push_back(run_pilot(*candidate, scene, photon_share(asked, small), stop));
    if (stop.load()) break;
    if (pilots.size() == 1 && relmse_of(pilots[0], truth_by(0)) < kEasyRelmse) break;
  }
  scene->change_view(camera, asked);
  if (stop.load()) return choice;
  // Path tracing misses most of what is hard to find: the others tell what there is.
  const std::vector<float> truth = truth_by(pilots.size() > 1 ? 1 : 0);
  size_t calmest = 0;   // of those that are unbiased
  for (size_t k = 0; k < pilots.size(); ++k) {
    choice.trials.push_back({candidates[k]->name, relmse_of(pilots[k], truth), pilots[k].rays});
    if (candidates[k]->unbiased && choice.trials[k].relmse < choice.trials[calmest].relmse) calmest = k;
  }
  // Noise falls with the samples that the render's rays pay for, bias more slowly.
  const double rays_asked = samples_asked * pilots[0].rays / (kPilotSamples * double(small.width) * small.height);
  for (size_t k = 0; k < pilots.size(); ++k) {
    TechniqueTrial& trial = choice.trials[k];
    if (!candidates[k]->unbiased) trial.bias = bias_of(pilots[k], pilots[calmest], truth, small.width, small.height);
    const double pilot_rays = trial.rays * candidates[k]->ray_cost * (double(asked.width) * asked.height) / (double(small.width) * small.height);
    const double longer = std::max(1.0, rays_asked / pilot_rays);
    const double crowded = candidates[k]->spreads ? crowding(double(small.width) * small.height) / crowding(double(asked.width) * asked.height) : 1.0;
    trial.cost = candidates[k]->tail * trial.relmse / (longer * crowded) + trial.bias * std::pow(longer, kBiasRate);
  }
  const TechniqueTrial* best = nullptr;
  for (const TechniqueTrial& trial : choice.trials) {
    const double handicap = best == &choice.trials.front() ? kClearlyBetter : 1.0;
    if (!best || (trial.cost > 0.0 && trial.cost * handicap < best->cost)) best = &trial;
  }
  const Candidate& chosen = *candidates[size_t(best - choice.trials.data())];
  choice.settings.integrator = chosen.integrator;
  choice.name = chosen.name;
  choice.reason = choice.trials.size() == 1         ? "it finds the light well"
                  : best == &choice.trials.front() ? "no other technique is clearly better"
                                                   : text(choice.trials.front().cost / best->cost) + " times the efficiency of path tracing in a small picture";
  choice.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return choice;
}

}  // namespace ajar
