// `auto`: the technique with which this scene is rendered, chosen by a pilot.
//
// Every technique that could pay renders the same small picture of the scene twice, with a few samples and independent
// seeds. From the two follow its noise and, by another's pictures, its bias (render/pilot_comparison.h), and from these
// the error that the render asked for would end with, if noise falls with the rays and bias as its radii shrink. Rays
// are counted, not timed, and weighed by what a ray costs in that technique: the same seed chooses the same. The
// pilot's pictures are thrown away: a choice that looked at samples it keeps would prefer those that missed something
// bright.
//
// The pilot is skipped where it could not pay, when nothing can bounce or few samples are asked for, and ends early
// where path tracing is found to do well.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "integrators/render_plan.h"
#include "render/pilot_comparison.h"
#include "scene/scene.h"

namespace ajar {

/// The integrator's name in settings that asks for a choice. While an artist moves about in a viewport it is path
/// tracing.
inline constexpr const char* kAutomatic = "auto";

struct TechniqueTrial {
  const char* name;                 ///< in the plan
  double relmse = 0.0, rays = 0.0;  ///< of the pilot; relMSE is that of its noise
  double bias = 0.0;                ///< relMSE of the pilot that is no noise
  PilotNoise cost;                  ///< relMSE that the render asked for would end with; smaller is better
};

struct TechniqueChoice {
  RenderSettings settings;  ///< with the integrator that was chosen
  std::string name, reason;
  std::vector<TechniqueTrial> trials;
  double seconds = 0.0;
  PlanSteps plan() const;
};

/// Choose for `scene`, whose sole owner the caller is; it is looked at with small pictures meanwhile and left as it
/// was. `camera` is the one it has.
TechniqueChoice choose_technique(const std::shared_ptr<Scene>& scene, const CameraDescription& camera,
                                 const std::atomic<bool>& stop, std::shared_ptr<const AttachedHints> hints = nullptr);

}  // namespace ajar
