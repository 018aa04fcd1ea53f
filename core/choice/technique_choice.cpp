#include "choice/technique_choice.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <span>

#include "choice/mixture.h"
#include "denoise/quality.h"
#include "integrators/integrator.h"
#include "math/random.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

namespace {

struct Candidate {
  const char* name;
  const char* integrator;
  double ray_cost;  ///< of one ray and its work, relative to path tracing (docs/benchmarks/auto.md)
  /// relMSE of long renders over the prediction from short ones: rare bright starts that no pilot had (same page)
  double tail;
  bool unbiased;  ///< except for the blur of vertex merging, which is ignored
  bool spreads;   ///< a chain spreads light over neighbouring pixels
  int samples;    ///< of each of the pilot's two images: fewer if a sample brings photons for the whole image
  bool photons;   ///< of the pilot: as many for each pixel as in the render
  double kept;    ///< minimum part of the noise of pixels that a denoiser keeps
  /// The gain over path tracing that is to be expected after denoising, if the pilot predicts g: gain * g^trust. The
  /// prediction is uncertain, so that the expected gain is between it and the mean (docs/research/auto.md).
  double gain, trust;
};
constexpr Candidate kPath{"path tracing", "path", 1.0, 1.75, true, false, 4, false, 0.0, 1.0, 1.0},
    kChains{"energy redistribution", "erpt", 1.5, 1.5, true, true, 4, false, 0.1, 0.0, 0.0},
    kPhotons{"photon mapping", "photon_map", 2.0, 0.85, false, false, 1, true, 0.03, 1.0, 0.2},
    kBidirectional{"bidirectional path tracing", "bdpt", 1.3, 1.5, true, false, 2, false, 0.0, 0.8, 0.5};
/// In the order of the trials. The first is the default. If the second is hopeless, it is the last that is tried.
/// The noise of bidirectional path tracing is large but not correlated, so that it is only tried for a denoised image;
/// that of chains is correlated, so that it is not tried then.
constexpr std::array kOrder{&kPath, &kChains, &kPhotons};
constexpr std::array kOrderIfDenoised{&kPath, &kPhotons, &kBidirectional};
/// The second technique is hopeless if it has this many times the noise of path tracing. The prediction for photons in
/// a denoised image spreads by a factor of three (docs/research/auto.md). Photons are only judged so if path tracing
/// finds most of the light.
constexpr double kHopelessChains = 1.25, kHopelessPhotons = 2.4;
constexpr int kPilotPixels = 12288, kMinPixels = 768;
constexpr int kPilotSamples = 2 * kPath.samples;  // of path tracing
/// Maximum share of the pilot in the requested samples.
constexpr double kPilotShare = 0.06;
/// Error that is not noise falls with the number of passes to this power: photon radii shrink as passes^(-1/6) [Knaus
/// and Zwicker 2011].
constexpr double kBiasRate = -2.0 / 3.0;
/// With a larger gain of learned starts, the few photons that start as before are so bright among the others that they
/// leave spots, which a pilot of few photons rarely meets. The factor is about what is missing in the prediction
/// (docs/research/emission.md).
constexpr double kLargeEmissionGain = 10.0, kTailOfBrightPhotons = 10.0;
/// Samples per pixel that are assumed for a render without a limit of samples or time.
constexpr double kUsualSamples = 512.0;
/// Work of all candidates per pixel and sample of path tracing in the pilot, relative to path tracing: measured on
/// `room` in CPU time, without the work for photons.
constexpr double kPilotWork = 4.0, kDenoisedPilotWork = 5.0;
/// Number of pixels and samples per pixel that measure the speed of path tracing if there is a time limit.
constexpr int kTimedPixels = 1024, kTimedSamples = 2, kTimedRuns = 2;
/// Path tracing does well if its relMSE after the pilot, plus the share of unlit pixels, is below this. The share
/// counts because the error of a pixel without any light can be its whole value.
constexpr double kEasyRelmse = 0.05;
/// Path tracing finds most of the light if the same sum is below this and the second technique is hopeless. Path guiding
/// is not measured then.
constexpr double kModerateRelmse = 0.3;
/// relMSE by light that path tracing misses and the second technique finds, from which on all techniques are tried. The
/// second one can be wrong: photons blur.
constexpr double kLeastMissed = 0.01;

/// A denoised image is path traced unless the expected gain of another technique is this.
constexpr double kLeastGain = 1.15;
/// Techniques take part in the render if their expected error is at most this many times that of the best one.
constexpr double kMaxRatio = 2.5;
/// Rays per pixel of the render below which a trial of several techniques would be too short to judge them.
constexpr double kLeastRays = 1000.0;

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, value >= 10.0 ? "%.0f" : "%.2g", value);
  return buffer;
}

/// Settings of the same image with about this many pixels, but not more than it has.
RenderSettings smaller(const RenderSettings& asked, double pixels) {
  RenderSettings small = asked;
  const double scale = std::min(1.0, std::sqrt(pixels / (double(asked.width) * asked.height)));
  small.width = std::max(1, int(std::lround(asked.width * scale)));
  small.height = std::max(1, int(std::lround(asked.height * scale)));
  small.region = {0, 0, 0, 0};
  small.passes = {"Combined"};
  small.image = ImageSampling::Uniform;
  return small;
}

/// The scene and the settings of the pilots.
struct Tried {
  const std::shared_ptr<Scene>& scene;
  const CameraDescription& camera;
  const RenderSettings& asked;
  std::shared_ptr<const AttachedHints> hints;  // of the scene

  /// The integrator, ready to render an image with these settings. Changes the view of the scene.
  std::unique_ptr<Integrator> prepared(const char* name, const RenderSettings& settings, uint32_t seed) const {
    scene->change_view(camera, settings);
    const IntegratorInfo& info = find_integrator(name);
    auto integrator = info.make();
    integrator->prepare(scene, make_render_plan(*scene, info, hints), seed);
    return integrator;
  }
};

/// Samples per second of path tracing with all threads: the faster of two short renders, because the first fills
/// caches, and another program may interrupt one of them. Changes the view of the scene.
double samples_per_second(const Tried& tried, const std::atomic<bool>& stop) {
  const RenderSettings small = smaller(tried.asked, kTimedPixels);
  double seconds = 1e30;
  for (int run = 0; run < kTimedRuns; ++run) {
    const auto integrator = tried.prepared(kPath.integrator, small, tried.asked.seed);
    Film film(0, 0, small.width, small.height, {"Combined"});
    const auto start = std::chrono::steady_clock::now();
    integrator->run_iteration(film, kTimedSamples, stop);
    seconds = std::min(seconds, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return kTimedSamples * double(small.width) * small.height / std::max(seconds, 1e-6);
}

/// Samples of path tracing that the render may take, in all pixels. `rate`: samples per second.
double samples_of_render(const RenderSettings& s, double rate) {
  const double pixels = double(s.width) * s.height;
  double samples = s.samples > 0 ? s.samples * pixels : 1e18;
  if (s.seconds > 0.0) samples = std::min(samples, s.seconds * rate);
  return samples < 1e18 ? samples : kUsualSamples * pixels;
}

struct Pilot : PilotImages {
  const Candidate* candidate = nullptr;
  double rays = 0.0;  ///< without rays that learn only once
  double emission_gain = 0.0;
};

/// relMSE of chains in an image with this many pixels, relative to that in a large one: the fewer pixels there are, the
/// fewer chains reach each of them (docs/benchmarks/auto.md).
double crowding(double pixels) { return 1.0 + std::pow(2300.0 / pixels, 2.0 / 3.0); }

/// Photon paths of a pass of the render, for the share of its pixels that the pilot has.
int photons_of_pilot(const RenderSettings& asked, const RenderSettings& small) {
  const double pixels = double(asked.width) * asked.height, few = double(small.width) * small.height;
  return std::max(1, int(std::lround(photons_of_a_pass(asked) / pixels * few)));
}

/// Renders both images of a pilot with the settings `small`. Changes the view of the scene.
Pilot run_pilot(const Candidate& candidate, const Tried& tried, RenderSettings small, const std::atomic<bool>& stop) {
  if (candidate.photons) small.photons = photons_of_pilot(tried.asked, small);
  Pilot pilot;
  pilot.candidate = &candidate;
  for (uint32_t half = 0; half < 2; ++half) {
    const auto integrator = tried.prepared(candidate.integrator, small, hash_combine(small.seed, 0x6175746FU + half));
    Film film(0, 0, small.width, small.height, {"Combined"});
    integrator->run_iteration(film, candidate.samples, stop);
    (half == 0 ? pilot.first : pilot.second) = film.resolve("Combined", shown_exposure(tried.asked));
    IntegratorStatistics statistics = integrator->statistics();
    pilot.rays += double(statistics.rays) - statistics.extra["hint_rays"] - statistics.extra["emission_rays"];
    pilot.emission_gain = statistics.extra["emission_gain"];
  }
  return pilot;
}

/// Share of the pixels that show a surface and have no light in either image. The scene must have the view of the
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

/// Changes the noise that a denoiser leaves of a technique, so that its gain over the first technique is the geometric
/// mean of the gains before and after denoising. What a denoiser leaves is uncertain in a small image; this mean comes
/// closest to the gains of long renders (docs/research/auto.md).
void use_mean_gain(PilotNoise& after, const PilotNoise& after_first, const PilotNoise& before,
                   const PilotNoise& before_first) {
  const auto mean = [](double& left, double left_first, double noise, double noise_first) {
    if (noise_first > 0.0) left = std::sqrt(left * left_first * noise / noise_first);
  };
  mean(after.whole, after_first.whole, before.whole, before_first.whole);
  mean(after.typical, after_first.typical, before.typical, before_first.typical);
}

/// Predictions for a render with `samples_asked` samples. The first pilot is that of path tracing.
std::vector<TechniqueTrial> trials_of(const std::vector<Pilot>& pilots, const Tried& tried, const RenderSettings& small,
                                      double samples_asked) {
  const RenderSettings& asked = tried.asked;
  const bool in_media = tried.scene->has_media();
  std::vector<const PilotImages*> pictures;
  pictures.reserve(pilots.size());
  for (const Pilot& pilot : pilots) pictures.push_back(&pilot);
  const std::vector<float> light = max_light(pictures, small.width, small.height);
  const double pixels = double(asked.width) * asked.height, few = double(small.width) * small.height;
  std::vector<TechniqueTrial> trials;
  std::vector<PilotNoise> noises, shown;
  std::vector<double> missed(pilots.size(), 0.0);  // relMSE of light that is not found, if the image is denoised
  size_t calmest = 0;                              // the unbiased one with the minimum noise
  for (size_t k = 0; k < pilots.size(); ++k) {
    const Candidate& candidate = *pilots[k].candidate;
    noises.push_back(noise_of(pilots[k], light));
    shown.push_back(noises[k]);
    if (asked.denoised) {
      const PilotNoise left = denoised_noise_of(pilots[k], light, small.width, small.height);
      shown[k].whole = std::max(left.whole, candidate.kept * noises[k].whole);
      shown[k].typical = std::max(left.typical, candidate.kept * noises[k].typical);
      if (k > 0) use_mean_gain(shown[k], shown[0], noises[k], noises[0]);
    }

    // Missed light is not a measure of the noise of chains, because neighbouring pixels share it. After denoising it stays
    // missing: more samples find some of it in single bright pixels, which the denoiser removes.
    for (size_t j = 0; j < pilots.size() && candidate.unbiased && !candidate.spreads; ++j) {
      if (j == k || !pilots[j].candidate->unbiased) continue;
      const double unseen = unseen_noise_of(pilots[k], pilots[j], light, small.width, small.height);
      noises[k].whole += unseen;
      noises[k].typical += unseen;
      if (asked.denoised) {
        missed[k] = std::max(missed[k], unseen / kUnseenPixels);
      } else {
        shown[k].whole += unseen;
        shown[k].typical += unseen;
      }
    }
    trials.push_back({candidate.name, noises[k].whole, pilots[k].rays});
    if (candidate.unbiased && noises[k].whole < noises[calmest].whole) calmest = k;
  }
  // Noise falls with the samples that the rays of the render pay for, bias more slowly.
  const double rays_asked = samples_asked * pilots[0].rays / (kPilotSamples * few);
  for (size_t k = 0; k < pilots.size(); ++k) {
    const Candidate& candidate = *pilots[k].candidate;
    if (!candidate.unbiased) trials[k].bias = bias_of(pilots[k], pilots[calmest], light, small.width, small.height);
    const double longer = std::max(1.0, rays_asked / (pilots[k].rays * candidate.ray_cost * pixels / few));
    const double crowded = candidate.spreads ? crowding(few) / crowding(pixels) : 1.0;
    // No photons are stored in volumes: their light is path traced.
    double tail = candidate.photons && in_media ? std::max(candidate.tail, kPath.tail) : candidate.tail;
    if (candidate.photons && pilots[k].emission_gain > kLargeEmissionGain) tail *= kTailOfBrightPhotons;
    const double noise_left = tail / (longer * crowded),
                 bias_left = trials[k].bias * std::pow(longer, kBiasRate) + missed[k];
    trials[k].cost = {noise_left * shown[k].whole + bias_left, noise_left * shown[k].typical + bias_left};
  }
  return trials;
}

std::span<const Candidate* const> order_of(const RenderSettings& asked) {
  if (asked.denoised) return kOrderIfDenoised;
  return kOrder;
}

/// The candidates for the scene, in the order of the trials. `left_out`: why some are missing.
std::vector<const Candidate*> candidates_of(const Scene& scene, std::string& left_out) {
  std::vector<const Candidate*> candidates;
  for (const Candidate* candidate : order_of(scene.settings())) {
    std::string reason = left_out_by(scene, find_integrator(candidate->integrator));
    if (reason.empty())
      candidates.push_back(candidate);
    else
      left_out = std::move(reason);
  }
  return candidates;
}

/// Whether the second technique finds light in both of its images that path tracing finds in neither. Small lights that
/// are focused are not noise in short renders of path tracing: their light is not there.
bool misses_light(const Pilot& path, const Pilot& second, const RenderSettings& small) {
  const std::vector<float> light = max_light({&path, &second}, small.width, small.height);
  return unseen_noise_of(path, second, light, small.width, small.height) > kLeastMissed * kUnseenPixels;
}

struct Trials {
  std::vector<TechniqueTrial> trials;  ///< of the first techniques in the order
  bool finds_light = false;            ///< path tracing has found nearly all light
  double rays_asked = 0.0;             ///< of path tracing with the samples of the render
};

/// Runs pilots of `candidates` until it is clear that no further technique can be better. Changes the view of the scene.
Trials run_trials(const Tried& tried, std::span<const Candidate* const> candidates, const RenderSettings& small,
                  double samples_asked, const std::atomic<bool>& stop) {
  const RenderSettings& asked = tried.asked;
  Trials all;
  std::vector<Pilot> pilots;
  double unfound = 0.0;
  const bool may_focus_light = plan_photons(*tried.scene).caustic;
  for (const Candidate* candidate : candidates) {
    pilots.push_back(run_pilot(*candidate, tried, small, stop));
    if (stop.load()) break;
    all.trials = trials_of(pilots, tried, small, samples_asked);
    if (pilots.size() == 1) {
      all.rays_asked = samples_asked * pilots[0].rays / (kPilotSamples * double(small.width) * small.height);
      unfound = all.trials[0].relmse + unlit_share(*tried.scene, pilots[0]);
      all.finds_light = unfound < kEasyRelmse;
      if (all.finds_light && !may_focus_light) break;
    }
    if (pilots.size() != 2 || candidate != order_of(asked)[1]) continue;
    if (misses_light(pilots[0], pilots[1], small)) {
      all.finds_light = false;
      continue;
    }
    if (all.finds_light) break;
    // Chains and photons are efficient if light is hard to find from the eye. The second technique is the one that says
    // more about the others: a denoiser handles the noise of photons much better than that of chains.
    const double hopeless = asked.denoised ? kHopelessPhotons : kHopelessChains;
    if (is_hopeless(all.trials[1].cost, all.trials[0].cost, hopeless)) {
      all.finds_light = unfound < kModerateRelmse;
      if (all.finds_light || !asked.denoised) break;
    }
  }
  return all;
}

/// The expected gains of the techniques over path tracing, after denoising.
std::vector<double> expected_gains(const std::vector<TechniqueTrial>& trials,
                                   std::span<const Candidate* const> candidates) {
  const auto product = [](const PilotNoise& cost) { return cost.whole * cost.typical; };
  std::vector<double> gains;
  for (size_t k = 0; k < trials.size(); ++k) {
    const double of_path = product(trials[0].cost), own = product(trials[k].cost);
    // A technique without noise has found nearly nothing.
    const double predicted = own > 0.0 && of_path > 0.0 ? std::sqrt(of_path / own) : 0.0;
    gains.push_back(k == 0 ? 1.0 : candidates[k]->gain * std::pow(predicted, candidates[k]->trust));
    if (k > 0 && !(predicted > 0.0)) gains.back() = 0.0;
  }
  return gains;
}

/// The index of the best technique for a denoised image.
size_t best_expected(const std::vector<double>& gains) {
  const auto best = std::max_element(gains.begin(), gains.end());
  return *best >= kLeastGain ? size_t(best - gains.begin()) : 0;
}

/// Samples of the technique of this trial that take the work of one sample of path tracing.
double samples_of_work(const std::vector<TechniqueTrial>& trials, std::span<const Candidate* const> candidates,
                       size_t k) {
  const auto work = [&](size_t one) { return trials[one].rays * candidates[one]->ray_cost / candidates[one]->samples; };
  return work(k) > 0.0 ? std::min(1.0, work(0) / work(k)) : 1.0;
}

/// The techniques that render the image, the best one first; none if the others are predicted to be much worse, if the
/// render is short, or if denoising a second image would take too much of it. `rays`: of path tracing with the samples of the render.
Learned::Mixed mixed_techniques(const std::vector<TechniqueTrial>& trials, std::span<const Candidate* const> candidates,
                                const std::vector<double>& gains, size_t best, const RenderSettings& asked,
                                double rays) {
  const double pixels = double(asked.width) * asked.height;
  const DenoiseQuality quality = denoise_quality_for(rays, 2.0 * pixels, 0.0, true);
  if (rays < kLeastRays * pixels || (quality != DenoiseQuality::High && quality != DenoiseQuality::Balanced)) return {};
  Learned::Mixed mixed;
  const auto add = [&](size_t k) {
    const double noise = trials[k].relmse * trials[k].rays * candidates[k]->ray_cost;
    if (noise > 0.0) mixed.techniques.push_back({candidates[k]->integrator, 0.0, candidates[k]->ray_cost, noise});
  };
  add(best);
  for (size_t k = 0; k < trials.size(); ++k)
    if (k != best && kMaxRatio * gains[k] >= gains[best]) add(k);
  if (mixed.techniques.size() < 2 || mixed.techniques[0].integrator != candidates[best]->integrator) return {};
  for (auto& technique : mixed.techniques) technique.share = 1.0 / double(mixed.techniques.size());
  mixed.trial_work = kTrialShare * rays;
  mixed.denoise_seconds = denoise_seconds(quality, pixels, true);
  return mixed;
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
  if (!mixed.techniques.empty()) {
    std::string names;
    for (const auto& technique : mixed.techniques)
      names += (names.empty() ? "" : ", ") + std::string(find_integrator(technique.integrator).label);
    plan.push_back({"several techniques", true, names + ": each may be the best after denoising",
                    "an image for each, and two that are denoised"});
  }
  return plan;
}

int samples_for_work(int asked, double samples_of_work) {
  constexpr int kLeast = 16;
  return std::max(std::min(asked, kLeast), int(std::lround(asked * samples_of_work)));
}

Learned::Choice place_of(const Camera& camera) {
  const Vec2 middle = 0.5f * Vec2(float(camera.width()), float(camera.height()));
  return {camera.position(), camera.generate_ray(middle, Vec2(0.5f), 0.0f).direction, 0};
}

TechniqueChoice choose_technique(const std::shared_ptr<Scene>& scene, const CameraDescription& camera,
                                 const std::atomic<bool>& stop, std::shared_ptr<const AttachedHints> hints,
                                 bool may_mix) {
  const auto start = std::chrono::steady_clock::now();
  const RenderSettings asked = scene->settings();
  TechniqueChoice choice;
  choice.settings = asked;
  choice.settings.integrator = kPath.integrator;
  choice.name = kPath.name;
  if (scene->lights().empty()) {
    choice.reason = "no lights are known";
    return choice;
  }
  if (!scene->scatters_light()) {
    choice.reason = "nothing scatters light";
    return choice;
  }
  std::string left_out;
  const std::vector<const Candidate*> candidates = candidates_of(*scene, left_out);
  if (candidates.size() == 1) {
    choice.reason = std::move(left_out);
    return choice;
  }
  if (asked.bounces.total < 1) {
    choice.reason = "the limit of bounces is 0";
    return choice;
  }
  if (!hints) hints = std::make_shared<const AttachedHints>(attach_hints(*scene));
  const Tried tried{scene, camera, asked, std::move(hints)};
  const double samples_asked = samples_of_render(asked, asked.seconds > 0.0 ? samples_per_second(tried, stop) : 0.0);
  // The pilot costs at most its share of the render.
  const double work = asked.denoised ? kDenoisedPilotWork : kPilotWork;
  const double pixels = std::min(
      {kPilotShare * samples_asked / (kPilotSamples * work), double(kPilotPixels), double(asked.width) * asked.height});
  if (pixels < kMinPixels) {
    scene->change_view(camera, asked);
    choice.reason = "too few samples for a pilot";
    return choice;
  }

  const RenderSettings small = smaller(asked, pixels);
  Trials all = run_trials(tried, candidates, small, samples_asked, stop);
  choice.trials = std::move(all.trials);
  scene->change_view(camera, asked);
  if (stop.load()) {
    choice.trials.clear();
    choice.reason = "the pilot was stopped before its end";
    return choice;
  }
  std::vector<PilotNoise> costs;
  for (const TechniqueTrial& trial : choice.trials) costs.push_back(trial.cost);
  std::vector<double> gains;
  if (asked.denoised) gains = expected_gains(choice.trials, candidates);
  const size_t best = asked.denoised ? best_expected(gains) : clearly_best(costs);
  choice.settings.integrator = candidates[best]->integrator;
  if (may_mix && asked.denoised && !all.finds_light && can_mix(asked.passes))
    choice.mixed = mixed_techniques(choice.trials, candidates, gains, best, asked, all.rays_asked);
  choice.samples_of_work = samples_of_work(choice.trials, candidates, best);
  // Guiding makes the independent noise of path tracing smaller, and is measured before it is used.
  const bool uses_paths = best == 0 || std::any_of(choice.mixed.techniques.begin(), choice.mixed.techniques.end(),
                                                   [](const auto& t) { return t.integrator == kPath.integrator; });
  if (uses_paths && !all.finds_light && asked.guiding == Guiding::Off) choice.settings.guiding = Guiding::Auto;
  choice.name = candidates[best]->name;
  choice.reason = costs.size() == 1 ? "its error in the pilot is small"
                  : best == 0       ? "no other technique is clearly better"
                  : asked.denoised
                      ? "after denoising, path tracing is expected to have " + text(gains[best]) + " times its error"
                      : text(costs[0].whole / costs[best].whole) +
                            " times the efficiency of path tracing in a small picture";
  choice.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return choice;
}

}  // namespace ajar
