#include "film/filter.h"
#include "integrators/bdpt.h"
#include "integrators/erpt.h"
#include "integrators/integrator.h"
#include "integrators/irradiance_cache.h"
#include "integrators/metropolis.h"
#include "integrators/mps.h"
#include "integrators/path_tracer.h"
#include "integrators/photon_mapping.h"
#include "integrators/pmc_path.h"
#include "transport/bidirectional/direct_pass.h"
#include "transport/hints/followed_hints.h"
#include "transport/media/path_media.h"

namespace ajar {

namespace {

constexpr IntegratorInfo kIntegrators[] = {
    // The session replaces "auto" by the choice of choice/technique_choice.h. Made directly, it is path tracing.
    {.name = "auto",
     .number = 0,
     .label = "Auto",
     .bias = Bias::Consistent,
     .sentence = "Tries several techniques on a small picture and renders with the best. The render plan says which "
                 "one, and whether it is unbiased.",
     .make = make_path_tracer,
     .knows_parts = true,
     .knows_groups = true,
     .follows_light_bounces = true,
     .follows_hints = true,
     .automatic = true,
     .has_direct_methods = true,
     .can_guide = true,
     .gathers_photons = true,
     .takes_further_samples = true,
     .samples_lens_light = true,
     .splats = true},
    {.name = "path",
     .number = 1,
     .label = "Path Tracing",
     .bias = Bias::Unbiased,
     .sentence = "Paths from the camera. Best for open scenes and visible lights.",
     .make = make_path_tracer,
     .knows_parts = true,
     .knows_groups = true,
     .follows_light_bounces = true,
     .has_direct_methods = true,
     .can_guide = true,
     .samples_lens_light = true,
     .bakes = true},
    {.name = "bdpt",
     .number = 7,
     .label = "Bidirectional Path Tracing",
     .bias = Bias::Unbiased,
     .sentence = "Paths from the camera and from the lights. For indirect light.",
     .make = make_bdpt,
     .knows_parts = true,
     .knows_groups = true,
     .follows_light_bounces = true,
     .can_merge = true,
     .follows_hints = true,
     .splats = true},
    {.name = "pmc_pt",
     .number = 2,
     .label = "Population Monte Carlo",
     .bias = Bias::Unbiased,
     .sentence = "A population of paths that learns where light is.",
     .make = make_pmc_path,
     .knows_parts = true,
     .knows_groups = true,
     .follows_light_bounces = true,
     .can_merge = true,
     .follows_hints = true,
     .takes_further_samples = true,
     .splats = true},
    {.name = "erpt",
     .number = 3,
     .label = "Energy Redistribution",
     .bias = Bias::Unbiased,
     .sentence = "Path tracing, with short Markov chains that spread what it finds.",
     .make = make_erpt,
     .knows_parts = true,
     .knows_groups = true,
     .follows_light_bounces = true,
     .can_merge = true,
     .follows_hints = true,
     .takes_further_samples = true,
     .splats = true},
    {.name = "mps",
     .number = 4,
     .label = "Metropolis Photon Sampling",
     .bias = Bias::Consistent,
     .sentence = "Photon mapping with photons only where the picture needs them.",
     .make = make_mps,
     .knows_parts = true,
     .follows_hints = true,
     .gathers_photons = true,
     .takes_further_samples = true},
    {.name = "metropolis",
     .number = 5,
     .label = "Metropolis",
     .bias = Bias::Consistent,
     .sentence = "Markov chains of paths that concentrate on the light that matters.",
     .make = make_metropolis,
     .knows_parts = true,
     .knows_groups = true,
     .follows_light_bounces = true,
     .can_merge = true,
     .follows_hints = true,
     .takes_further_samples = true,
     .splats = true},
    {.name = "photon_map",
     .number = 6,
     .label = "Photon Mapping",
     .bias = Bias::Consistent,
     .sentence = "Photons from the lights, gathered where the camera sees them.",
     .make = make_photon_mapping,
     .knows_parts = true,
     .follows_hints = true,
     .gathers_photons = true,
     .takes_further_samples = true,
     .bakes = true},
    {.name = "irradiance_cache",
     .number = 8,
     .label = "Irradiance Caching",
     .bias = Bias::Biased,
     .sentence = "Diffuse indirect light, computed at few points and interpolated.",
     .make = make_irradiance_cache,
     .has_direct_methods = true,
     .stores_records = true,
     .bakes = true}};

}  // namespace

const std::vector<IntegratorInfo>& integrator_list() {
  static const std::vector<IntegratorInfo> list(std::begin(kIntegrators), std::end(kIntegrators));
  return list;
}

Bias bias_with(const DirectPass& direct, Bias chains) {
  return direct.merging().active() ? std::max(chains, Bias::Consistent) : chains;
}

void add_statistics_of(const VertexMerging& merging, IntegratorStatistics& statistics) {
  if (!merging.active()) return;
  statistics.rays += merging.rays();
  statistics.extra["photon_rays"] = double(merging.rays());
  statistics.extra["photons"] = double(merging.photons());
  statistics.extra["photon_bytes"] = double(merging.memory_bytes());
  statistics.extra["photon_radius"] = double(merging.radius());
  statistics.extra["refused_photons"] = double(merging.refused());
}

void add_statistics_of(const DirectPass& direct, IntegratorStatistics& statistics) {
  add_statistics_of(direct.merging(), statistics);
  if (direct.eye_only_rays() > 0) statistics.extra["eye_only_rays"] = double(direct.eye_only_rays());
  if (direct.rays_beyond() > 0) statistics.extra["terminator_rays"] = double(direct.rays_beyond());
}

void add_statistics_of(const MediaCounters& counters, size_t bytes, IntegratorStatistics& statistics) {
  statistics.extra["media_bytes"] = double(bytes);
  statistics.extra["media_lookups"] = double(counters.lookups);
  statistics.extra["media_majorant_exceeded"] = double(counters.exceeded);
  statistics.extra["media_extinction_capped"] = double(counters.capped);
  statistics.extra["media_refused_values"] = double(counters.refused);
  statistics.extra["media_open_ends"] = double(counters.open_ends);
  statistics.extra["media_too_deep"] = double(counters.too_deep);
}

void add_statistics_of(const PathMedia* media, IntegratorStatistics& statistics) {
  if (media) add_statistics_of(media->counters(), media->memory_bytes(), statistics);
}

void add_statistics_of(const FollowedHints& followed, IntegratorStatistics& statistics) {
  statistics.rays += followed.rays() + followed.emission_rays();
  if (followed.rays() > 0) statistics.extra["hint_rays"] = double(followed.rays());
  statistics.extra["emission_rays"] = double(followed.emission_rays());
  statistics.extra["emission_gain"] = followed.emission_gain();
}

const IntegratorInfo& find_integrator(const std::string& name) {
  std::string names;
  for (const IntegratorInfo& info : integrator_list()) {
    if (info.name == name) return info;
    names += (names.empty() ? "" : ", ") + std::string(info.name);
  }
  throw SceneError("Unknown integrator '" + name + "'. Valid names: " + names + ".");
}

std::unique_ptr<Integrator> make_integrator(const std::string& name) { return find_integrator(name).make(); }

}  // namespace ajar
