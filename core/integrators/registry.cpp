#include "integrators/bdpt.h"
#include "integrators/erpt.h"
#include "integrators/integrator.h"
#include "integrators/metropolis.h"
#include "integrators/mps.h"
#include "integrators/path_tracer.h"
#include "integrators/photon_mapping.h"
#include "integrators/pmc_path.h"

namespace ajar {

const std::vector<IntegratorInfo>& integrator_list() {
  static const std::vector<IntegratorInfo> list{
      // Who renders for others asks render/technique_choice.h which it shall be; by itself it is path tracing.
      {"auto", "Auto", Honesty::Consistent, "Tries the techniques on a small picture, and renders with the best. The plan says which, and whether it is unbiased.", make_path_tracer},
      {"path", "Path Tracing", Honesty::Unbiased, "Paths from the eye; best for open scenes and easily seen lights.", make_path_tracer},
      {"bdpt", "Bidirectional Path Tracing", Honesty::Unbiased, "Paths from the eye and from the lights; for light that arrives indirectly.", make_bdpt},
      {"pmc_pt", "Population Monte Carlo", Honesty::Unbiased, "A population of light paths that learns.", make_pmc_path},
      {"erpt", "Energy Redistribution", Honesty::Unbiased, "Path tracing whose finds are spread by short chains.", make_erpt},
      {"mps", "Metropolis Photon Sampling", Honesty::Consistent, "Photons only where the picture needs them.", make_mps},
      {"metropolis", "Metropolis", Honesty::Consistent, "Chains of mutations that dwell on the light paths that matter.", make_metropolis},
      {"photon_map", "Photon Mapping", Honesty::Consistent, "Photons from the lights, gathered at what the eye sees.", make_photon_mapping}};
  return list;
}

std::unique_ptr<Integrator> make_integrator(const std::string& name) {
  std::string names;
  for (const IntegratorInfo& info : integrator_list()) {
    if (info.name == name) return info.make();
    names += (names.empty() ? "" : ", ") + std::string(info.name);
  }
  throw SceneError("Unknown integrator '" + name + "'. Valid names: " + names + ".");
}

}  // namespace ajar
