// Photons on their way: emitted from the lights, scattered as importance, stored where surfaces are rough.
//
// Particles carry flux. At shading normals the adjoint BSDF and Veach's correction (1997, section 5.3) apply. Numbers
// come from one Sobol sequence over the photons of a pass; photon paths are cut into fixed blocks that are joined in
// order, so the result does not depend on the number of threads.
//
// Rays that leave lights see what shadow rays see; rays that leave surfaces are of the kind their scattering made them.
// Surfaces are evaluated as rays after a diffuse bounce see them, because that is how a gather or a caustic will look
// at them; so Blender's caustics switches hold. `cast_shadow = false` of lamps is not honoured here.
#pragma once

#include <atomic>

#include "transport/paths/light_walk_guide.h"
#include "transport/photons/photon_map.h"

namespace ajar {

/// Emitted photon paths, or steps of chains, of a pass for a picture of this many pixels.
uint32_t photons_of_a_pass(double pixels);
/// What the settings ask for, else by the full frame: a region of it uses the same maps.
uint32_t photons_of_a_pass(const RenderSettings& settings);
/// Radii of first passes are at most this part of the scene's.
constexpr float kLargestPhotonRadius = 0.05f;

/// Which maps a scene needs, and why.
struct PhotonPlan {
  bool global = false, caustic = false;
  const char* global_reason = "";
  const char* caustic_reason = "";
};
PhotonPlan plan_photons(const Scene& scene);

struct PhotonBatch {
  std::vector<Photon> global;         ///< light that arrives on any path
  std::vector<Photon> caustic;        ///< light that arrives by sharp scattering only, at least once
  std::vector<IrradianceSite> sites;  ///< every `site_stride`-th place where a photon lies on a Lambertian surface
  double emitted[3] = {0, 0, 0};      ///< watts
  uint64_t rays = 0;
};

struct PhotonEmission {
  PhotonPlan plan;
  uint32_t seed = 0, pass = 0;
  uint32_t count = 0;  ///< photon paths
  uint32_t site_stride = 4;
  const LightWalkGuide*
      guide = nullptr;  ///< hints that photons follow besides; their flux is then less where hints send many
};
/// Returns early when `stop` is raised, with what there is.
PhotonBatch trace_photons(const Scene& scene, const PhotonEmission& emission, const std::atomic<bool>& stop);

}  // namespace ajar
