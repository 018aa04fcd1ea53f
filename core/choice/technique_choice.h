// `auto`: a pilot chooses the technique for a scene.
//
// Every technique that could be efficient renders the same small image of the scene twice, with few samples and
// independent seeds. The two images give its noise and, compared with the images of others, its bias
// (choice/pilot_comparison.h). From these follows the error with which the requested render would end, if noise falls
// with the rays and bias as its radii shrink. Rays are counted, not timed, and weighted by the cost of a ray in that
// technique, so that the same seed gives the same choice. The images of the pilot are discarded: a choice by samples
// that it keeps would prefer those that missed something bright.
//
// The pilot is skipped if it cannot be efficient, because nothing can bounce or few samples are requested. It ends
// early if path tracing has a small error, or if the second technique is hopeless. Where surfaces may focus light, the
// second technique is tried in any case: focused light of small lamps and suns is no noise in short renders of path
// tracing, because it is not there. If the second technique finds light in both of its images that path tracing misses,
// all techniques are tried.
//
// If the image will be denoised (RenderSettings::denoised), the noise that counts is the noise that a denoiser leaves:
// that of means over small windows. Independent noise nearly vanishes there, that of chains does not. The prediction
// then spreads by a factor of three, and all techniques that may be the best begin to render the image
// (choice/mixture.h).
//
// A sample of some techniques takes several times the work of a sample of path tracing. The number of samples that is
// asked for is that of path tracing; other techniques take as many as the same work pays for, so that a render takes about
// the same time whatever is chosen.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "choice/pilot_comparison.h"
#include "integrators/learned.h"
#include "integrators/render_plan.h"
#include "scene/scene.h"

namespace ajar {

struct TechniqueTrial {
  const char* name;                 ///< as in the plan
  double relmse = 0.0, rays = 0.0;  ///< of the pilot; relmse is that of its noise
  double bias = 0.0;                ///< relMSE of the pilot that is not noise
  PilotNoise cost;                  ///< predicted relMSE at the end of the requested render; smaller is better
};

struct TechniqueChoice {
  RenderSettings settings;  ///< with the chosen integrator
  Learned::Mixed mixed;     ///< no techniques: there is only the chosen one
  std::string name, reason;
  std::vector<TechniqueTrial> trials;
  /// Samples that take the work of one sample of path tracing, at most 1.
  double samples_of_work = 1.0;
  double seconds = 0.0;
  PlanSteps plan() const;
};

/// Share of the work of the render that is the trial of several techniques.
constexpr double kTrialShare = 0.25;

/// The samples of a technique that take the work of `asked` samples of path tracing: at least 16, so that its noise can be
/// estimated, and at most `asked`. 0 is no limit.
int samples_for_work(int asked, double samples_of_work);

/// The place for which a choice is made.
Learned::Choice place_of(const Camera& camera);

/// Chooses the technique for `scene`, of which the caller must be the sole owner. Pilots change the view of the scene;
/// it is restored at the end. `camera` is the present camera of the scene. `may_mix`: several techniques can be chosen.
TechniqueChoice choose_technique(const std::shared_ptr<Scene>& scene, const CameraDescription& camera,
                                 const std::atomic<bool>& stop, std::shared_ptr<const AttachedHints> hints = nullptr,
                                 bool may_mix = false);

}  // namespace ajar
