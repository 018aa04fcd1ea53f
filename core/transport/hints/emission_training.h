// Learns where photons should start (emission_guide.h), before the first pass.
//
// First proposals: from places where the image looks up the maps straight to the lights, through surfaces that transmit
// light. They find small windows and glass in front of lamps at once. Then a few thousand photons in each of some
// rounds. A photon's value is the sum, over the places where it would be stored, of its flux times the root of the density
// of lookups there: the variance of the image is the sum over lookups of flux^2, so that its second moment is about that
// of the noise which photons bring into the image. The result is used if it halves this moment, and if a tenth of the
// values belongs to paths that light sampling does not find. It is used for proposals only, and its photons are not
// stored.
#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include "transport/guiding/emission_guide.h"
#include "transport/photons/photon_lookups.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

constexpr uint32_t kPhotonsOfEmissionRound = 8192;

struct EmissionTask {
  const Scene& scene;
  const PathMedia* media;  ///< null if the scene has none
  uint32_t seed;
};

/// The part of the values that paths have which light sampling does not find. No value counts more than 64 times the mean,
/// so that a few rare ones do not decide.
double sharp_share(const std::vector<PhotonValue>& values);

struct LearnedEmission {
  std::shared_ptr<const EmissionMap> map;  ///< null: not worth it
  float share = 0.0f;                      ///< of the walks that start as learned
  double gain = 1.0;  ///< second moment without the map over that with it; estimated by the last round
  uint64_t rays = 0;
};
LearnedEmission learn_emission(const EmissionTask& task, const std::atomic<bool>& stop);

/// The emission of one scene, learned when it is first asked for, and again if the camera has moved. All integrators that
/// render the scene share it.
class SharedEmission {
 public:
  /// `rays`: those that this call has traced are added. Nothing is kept if it is stopped.
  LearnedEmission get(const EmissionTask& task, const std::atomic<bool>& stop, uint64_t& rays);

 private:
  std::mutex mutex_;
  std::optional<LearnedEmission> learned_;
  Vec3 camera_position_{0.0f}, camera_direction_{0.0f};
};

}  // namespace ajar
