#include "transport/direct/direct_methods.h"

#include <algorithm>

#include "description/diagnostics.h"

namespace ajar {

const std::vector<DirectMethodInfo>& direct_method_list() {
  using enum DirectMethod;
  static const std::vector<DirectMethodInfo> list{
      {Mis, "mis", "Multiple Importance", false,
       "Samples both lights and surfaces. The right choice for nearly every scene."},
      {PmcHi, "pmc_hi", "Adaptive Mixture", false,
       "Learns, for each region of the scene, which lights and lobes to sample."},
      {OcvProgressive, "ocv_progressive", "Progressive Control Variates", false,
       "Corrects each estimate by what earlier ones found nearby."},
      {Ocv, "ocv", "Control Variates", false,
       "Corrects one half of the samples by the other half. Use 16 or more direct samples."},
      {PmcHiPaper, "pmc_hi_paper", "Adaptive Mixture (per estimate)", false,
       "Learns within each estimate. Use 16 or more direct samples. For comparison."},
      {OcvPaper, "ocv_paper", "Control Variates (as published)", true, "Darkens the picture. For comparison."},
      {Correlated, "correlated", "Single Control Variate", false,
       "One control variate for all lights. For comparison."},
      {Ris, "ris", "Resampled Importance", false,
       "Sends shadow rays to the brightest of several candidates. For comparison."},
      {MisBalance, "mis_balance", "Multiple Importance (balance)", false,
       "Multiple importance sampling with the balance heuristic."},
      {Light, "light", "Lights Only", false, "Samples only lights. For comparison."},
      {Bsdf, "bsdf", "Surfaces Only", false, "Samples only surfaces. For comparison."}};
  return list;
}

const DirectMethodInfo& find_direct_method(const std::string& name) {
  std::string names;
  for (const DirectMethodInfo& info : direct_method_list()) {
    if (info.name == name) return info;
    names += (names.empty() ? "" : ", ") + std::string(info.name);
  }
  throw SceneError("Unknown direct light method '" + name + "'. Valid names: " + names + ".");
}

const DirectMethodInfo& find_direct_method(DirectMethod method) {
  return *std::find_if(direct_method_list().begin(), direct_method_list().end(),
                       [&](const DirectMethodInfo& info) { return info.method == method; });
}

}  // namespace ajar
