// Direct light of the whole film (direct_paths.h), and light that media emit, for integrators whose chains or populations
// leave it out. Where there is subsurface scattering, or where surfaces depend on the kind of the ray, it adds the light
// that only walks from the eye find (eye_only_light.h). Where there are smooth meshes, it adds the light beyond the
// shadow terminator (light_beyond.h). Where merging is active, it also adds the light of paths that only photons find.
// Pixels with highlights and reflected lamps smaller than a pixel get further samples (further_samples.h).
#pragma once

#include <atomic>

#include "film/film.h"
#include "transport/bidirectional/eye_only_light.h"
#include "transport/bidirectional/further_samples.h"
#include "transport/bidirectional/light_beyond.h"
#include "transport/bidirectional/vertex_merging.h"
#include "transport/paths/path.h"

namespace ajar {

class DirectPass {
 public:
  /// `merges`: use vertex merging.
  void prepare(const Scene& scene, const PathMedia* media, bool merges, uint32_t seed);
  VertexMerging& merging() { return merging_; }
  const VertexMerging& merging() const { return merging_; }

  /// Adds the direct samples that belong to `steps` more chain steps per pixel, one for kShare steps, with alpha and
  /// passes. When `stop` is set, the remaining pixels get no samples. Where merging is active, each sample has its own
  /// photon pass.
  void add(Film& film, const PathSpace& space, int steps, const std::atomic<bool>& stop);
  /// Without the rays of merging's photons.
  uint64_t rays() const { return rays_ + further_rays_ + eye_only_.rays() + beyond_.rays(); }
  /// The parts of EyeOnlyLight and of LightBeyond.
  uint64_t eye_only_rays() const { return eye_only_.rays(); }
  uint64_t rays_beyond() const { return beyond_.rays(); }

  static constexpr uint32_t kShare = 4;  ///< chain steps in a pixel for each direct sample

 private:
  void add_samples(Film& film, const PathSpace& space, uint32_t first, uint32_t end, const std::atomic<bool>& stop);

  uint32_t seed_ = 0, wanted_ = 0, done_ = 0;  ///< wanted_: chain steps; done_: samples
  uint64_t rays_ = 0, further_rays_ = 0;
  VertexMerging merging_;
  FurtherSamples further_;
  EyeOnlyLight eye_only_;
  LightBeyond beyond_;
};

}  // namespace ajar
