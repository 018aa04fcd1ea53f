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

namespace ajar {

const std::vector<IntegratorInfo>& integrator_list() {
  static const std::vector<IntegratorInfo> list{
      // Who renders for others asks render/technique_choice.h which it shall be; by itself it is path tracing.
      {"auto", "Auto", Honesty::Consistent, "Tries the techniques on a small picture, and renders with the best. The plan says which, and whether it is unbiased.", make_path_tracer, false, true, true, false, true, true},
      {"path", "Path Tracing", Honesty::Unbiased, "Paths from the eye; best for open scenes and easily seen lights.", make_path_tracer, false, true, true, false, true, true},
      {"bdpt", "Bidirectional Path Tracing", Honesty::Unbiased, "Paths from the eye and from the lights; for light that arrives indirectly.", make_bdpt, true, false, false, true},
      {"pmc_pt", "Population Monte Carlo", Honesty::Unbiased, "A population of light paths that learns.", make_pmc_path, true, false, false, true},
      {"erpt", "Energy Redistribution", Honesty::Unbiased, "Path tracing whose finds are spread by short chains.", make_erpt, true, false, false, true},
      {"mps", "Metropolis Photon Sampling", Honesty::Consistent, "Photons only where the picture needs them.", make_mps, true},
      {"metropolis", "Metropolis", Honesty::Consistent, "Chains of mutations that dwell on the light paths that matter.", make_metropolis, true, false, false, true},
      {"photon_map", "Photon Mapping", Honesty::Consistent, "Photons from the lights, gathered at what the eye sees.", make_photon_mapping},
      {"irradiance_cache", "Irradiance Caching", Honesty::Biased, "Light between diffuse surfaces, gathered at few points and interpolated.", make_irradiance_cache}};
  return list;
}

void add_statistics_of(const VertexMerging& merging, IntegratorStatistics& statistics) {
  if (!merging.active()) return;
  statistics.rays += merging.rays();
  statistics.extra["photon_rays"] = double(merging.rays());
  statistics.extra["photons"] = double(merging.photons());
  statistics.extra["photon_bytes"] = double(merging.memory_bytes());
  statistics.extra["photon_radius"] = double(merging.radius());
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

std::string reason_against(const IntegratorInfo& integrator, const Scene& scene) {
  if (scene.moves() && !integrator.renders_motion) return "it does not render motion blur";
  if (scene.has_media() && !integrator.renders_media) return "it does not render volumes";
  if (scene.has_strands() && !integrator.renders_strands) return "it does not render hair";
  if (scene.lights().any_partial() && !integrator.tells_parts) return "a light is hidden from some kinds of rays";
  if (!integrator.joins_camera) return "";
  const RenderSettings& s = scene.settings();
  if (scene.camera().finds_film(PixelFilter(s.filter, s.filter_width).half_width())) return "";
  return scene.camera().has_lens() ? "it cannot join light paths to a panoramic camera with depth of field"
                                   : "it cannot join light paths to a panorama that sees some directions twice, as at its seam";
}

}  // namespace ajar
