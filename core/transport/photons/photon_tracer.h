// Photon tracing: emission from the lights, scattering in importance mode, storage on rough surfaces.
//
// Photons have flux. At shading normals the adjoint BSDF and Veach's correction apply (1997, section 5.3). Random
// numbers come from one Sobol sequence over the photons of a pass. Photon paths are divided into blocks of fixed size
// whose results are joined in order, so the result does not depend on the number of threads.
//
// Rays that leave lights see what shadow rays see. Rays that leave surfaces have the kind of their scattering. Surfaces
// are evaluated as rays after a diffuse bounce see them, because a gather ray or a caustic lookup sees them in this
// way. Blender's caustics switches therefore apply. Nothing blocks the light of a lamp that casts no shadow, as long as
// nothing has scattered it. Surfaces that depend on the kind of the ray (shading/ray_kind_surfaces.h) let the rays that
// leave lights pass as shadow rays, and photons end at them otherwise. Behind them, a photon is first stored where the
// light arrives after its first scattering: lookups sample the direct light.
#pragma once

#include <atomic>

#include "transport/guiding/emission_guide.h"
#include "transport/media/path_media.h"
#include "transport/photons/photon_map.h"

namespace ajar {

class PhotonLookups;  // transport/photons/photon_lookups.h

/// Number of emitted photon paths, or of chain steps, in a pass for an image of this many pixels.
uint32_t photons_of_a_pass(double pixels);
/// The number in the settings. If it is 0, the number follows from the full frame, so that a region uses the same maps.
uint32_t photons_of_a_pass(const RenderSettings& settings);
/// Time of a pass: of its photons, and of the samples that look them up. The times of the passes are a van der Corput
/// sequence, shifted by the seed; 0 where nothing moves.
float time_of_pass(const Scene& scene, uint32_t seed, uint32_t pass);
/// Upper bound of the radius of the first pass, relative to the radius of the scene.
constexpr float kLargestPhotonRadius = 0.05f;

/// The maps that a scene needs, with the reasons.
struct PhotonPlan {
  bool global = false, caustic = false;
  const char* global_reason = "";
  const char* caustic_reason = "";
  bool rough_glossy = false;  ///< gather rays may start or end at rough lobes that are not diffuse
};
PhotonPlan plan_photons(const Scene& scene);

/// The start of a photon path that is worth something to the image.
struct PhotonValue {
  LightStart start;
  float density_ratio;  ///< density of the start, over that without a guide
  bool sharp_first;     ///< a sharp lobe scattered the light first, so that light sampling does not find the path
};

struct PhotonBatch {
  std::vector<Photon> global;         ///< light that arrives on all paths
  std::vector<Photon> caustic;        ///< light that arrives after at least one sharp scattering event and no rough one
  std::vector<IrradianceSite> sites;  ///< every `site_stride`-th position of a photon on a Lambertian surface
  std::vector<PhotonValue> values;    ///< of the photon paths, if they are asked for
  double emitted[3] = {0, 0, 0};      ///< watts
  uint64_t rays = 0;
};

struct PhotonEmission {
  PhotonPlan plan;
  uint32_t seed = 0, pass = 0;
  uint32_t count = 0;  ///< photon paths
  uint32_t site_stride = 4;
  float time = 0.0f;  ///< time_of_pass
  /// What photons follow in addition. The flux is then smaller where it sends many photons.
  const LightWalkGuide* guide = nullptr;
  /// If it is not null, photons are not stored. Each path has a value instead: the sum over its photons of their flux,
  /// times the root of the density of lookups there.
  const PhotonLookups* values = nullptr;
};
/// Returns early with the photons so far when `stop` is set.
PhotonBatch trace_photons(const Scene& scene, const PathMedia* media, const PhotonEmission& emission,
                          const std::atomic<bool>& stop);

}  // namespace ajar
