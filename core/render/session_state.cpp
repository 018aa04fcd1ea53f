#include "render/session_state.h"

#include <algorithm>
#include <cstdlib>

#include <tbb/task_arena.h>

#include "description/archive.h"

namespace ajar {

namespace {

constexpr int kMaxThreads = 1024;  // limit of Blender

/// The number of threads if the settings have none: AJAR_THREADS, or all of the machine.
int default_threads() {
  const char* named = std::getenv("AJAR_THREADS");
  const int threads = named ? std::atoi(named) : 0;
  return threads > 0 ? threads : tbb::this_task_arena::max_concurrency();
}

}  // namespace

void SessionState::begin(const Job& job) {
  busy = true;
  progress = {};
  progress.phase = Progress::Phase::Building;
  progress.render = job.number;
  error.clear();
  settings = job.description ? job.description->settings : job.settings;
  view_fingerprint = job.description ? ajar::view_fingerprint(job.description->camera, settings) : 0;
  begin_film();
  integrator_name = settings.integrator;
  pilot_seconds = 0.0;
  technique_steps.clear();
  choice.reset();
  mixed = {};
  threads = std::min(settings.threads > 0 ? settings.threads : default_threads(), kMaxThreads);
  if (!job.description) return;
  diagnostics.clear();
  hints.reset();
  plan.clear();
  if (!job.keep) scene.reset();
}

void SessionState::begin_film() {
  range.reset();
  continued.reset();
  samples_in_film = 0;
  mixture.reset();
  integrator.reset();  // before the scene that it holds changes
  film.reset();
  image_plan.reset();
  film_idle = false;
  sample_counts = {};
  film_bytes = 0;
  // Passes that the owner read from the last film are published from the first iteration on.
  wanted = {"Combined"};
  for (const std::string& pass : settings.passes)
    if (published.contains(pass)) wanted.insert(pass);
  published.clear();
  published_checkpoint.reset();
  published_photons = {};
  wanted_photons = 0;
  statistics = {};
  error_over_time.clear();
}

DenoiserInput SessionState::denoiser_input() const {
  const auto if_asked = [&](const char* pass) {
    const auto& passes = settings.passes;
    return std::find(passes.begin(), passes.end(), pass) == passes.end() ? std::vector<float>() : resolve(pass);
  };
  std::vector<bool> biased;
  if (mixture)
    for (const Mixture::Part& part : mixture->parts()) biased.push_back(part.integrator.bias() != Bias::Unbiased);
  return {resolve("Combined"),
          resolve("Halves"),
          if_asked("Direct Halves"),
          if_asked("Denoising Albedo"),
          if_asked("Denoising Normal"),
          film->width(),
          film->height(),
          std::move(biased),
          settings.view_exposure};
}

PhotonPoints SessionState::photons(uint64_t max_count) const {
  if (!mixture) return integrator->photons(max_count);
  for (const Mixture::Part& part : mixture->parts())
    if (PhotonPoints found = part.integrator.photons(max_count); found.stored > 0) return found;
  return {};
}

void SessionState::measure_film() {
  sample_counts = film->sample_counts();
  film_bytes = film->memory_bytes();
  refused = film->refused();
  if (!mixture) return;
  mixture->add_to(sample_counts);
  film_bytes += mixture->film_bytes();
  refused += mixture->refused();
}

std::vector<float> SessionState::resolve(const std::string& pass) const {
  std::vector<float> values = film->resolve(pass, settings.exposure);
  if (mixture) return mixture->of_all(pass, std::move(values), settings.exposure);
  if (!base) return values;
  const auto before = base->passes.find(pass);
  if (before == base->passes.end()) return values;
  const double samples = film->sample_counts().mean;
  if (matte_pass(pass) && samples > 0.0) return merge_matte(pass, *base, checkpoint_of_film());
  return samples > 0.0 ? merge_pass(pass, before->second, base->samples, values, samples) : before->second;
}

std::optional<SampleRange> SessionState::wanted_range(const RenderSettings& s) const {
  if (base && base->sums.pixels > 0 && base->ranges.size() == 1 &&
      base->integrators == std::vector<std::string>{integrator_name})
    return base->ranges[0];
  if (base || !first_sample) return std::nullopt;
  return SampleRange{s.seed, *first_sample, *first_sample};
}

Checkpoint SessionState::checkpoint_of_film() const {
  Checkpoint c;
  c.frame = {settings.width, settings.height};
  c.region = settings.region;
  c.exposure = settings.exposure;
  c.view_exposure = settings.view_exposure;
  c.view = view_fingerprint;
  c.seeds = {seed};
  if (range) {
    c.ranges = {{range->seed, range->first, range->first + film->sample_counts().max}};
    c.sums = film->sums();
  }
  c.integrators = {integrator_name};
  c.samples = film->sample_counts().mean;
  c.seconds = progress.render_seconds;
  c.rays = statistics.rays;
  c.refused = film->refused();
  c.relmse = progress.estimated_relmse;
  if (continued) {
    c.seconds += continued->seconds;
    c.rays += continued->rays;
    c.refused += continued->refused;
  }
  for (const std::string& pass : settings.passes) c.passes[pass] = film->resolve(pass, settings.exposure);
  for (const char* pass : {"Sample Count", "Variance"}) c.passes[pass] = film->resolve(pass, settings.exposure);
  return c;
}

Checkpoint SessionState::checkpoint() const {
  Checkpoint c = checkpoint_of_film();
  return base ? merge(*base, c) : c;
}

}  // namespace ajar
