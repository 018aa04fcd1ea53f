// What a render has learned that is also valid in another frame of an animation.
//
// All of it affects proposals only: the directions of a guide, the order in which lights are tried, the choice of a
// technique. Every frame computes its estimates from new random numbers that no earlier frame has used. Each frame is
// therefore as unbiased as if it had been rendered alone, and its error is not correlated with the errors of earlier
// frames, even if the learned data is wrong (a wrong guide costs time).
//
// Estimates are not passed on: weights of population members, running chains, brightness, irradiance records, photons.
// They would bring the error of one frame into the next. Data of blocks of pixels is not passed on either (coefficients
// of control variates), because it is wrong when the pixels show something else.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "transport/chains/path_population.h"
#include "transport/direct/estimators/pmc_hi.h"
#include "transport/guiding/path_guide.h"

namespace ajar {

struct Learned {
  /// The choice of `auto`: the camera for which it was made, and the number of frames that have used it.
  struct Choice {
    Vec3 eye, direction;
    uint32_t age;
    /// Whether it probably suits another camera in a scene of this radius.
    bool is_near(const Choice& other, float radius_of_scene) const {
      return glm::length(other.eye - eye) < 0.1f * radius_of_scene && glm::dot(other.direction, direction) > 0.9f;
    }
  };
  static constexpr uint32_t kMaxAge = 24;  ///< of the choice, in frames
  /// The techniques that render one image (choice/mixture.h), the integrator of the render first.
  struct Mixed {
    struct Technique {
      std::string integrator;
      double share = 0.0;     ///< of the work
      double ray_cost = 1.0;  ///< work for a ray
      double noise = 1.0;     ///< relMSE times work in the pilot, before denoising
    };
    std::vector<Technique> techniques;  ///< empty: the render has one technique
    double trial_work = 0.0;            ///< of all techniques, after which the shares follow from errors; 0: they stay
    double denoise_seconds = 0.0;       ///< of a core, for each image
  };
  /// A guide with more cells (about 60 MB) is not passed on, so that a long flight through a large scene does not fill
  /// the memory.
  static constexpr size_t kMaxCells = 100'000;

  // Describes the render that learned it. The session sets these.
  std::string integrator;
  uint32_t frames = 0;  ///< of the animation so far, including this one: each has its own random numbers
  Vec3 center{0.0f};    ///< of the scene
  float radius = 0.0f;
  /// Whether a scene has about the same place and size. Its objects may differ.
  bool is_of_scene(Vec3 its_center, float its_radius) const {
    const float ratio = its_radius / radius;
    return glm::length(its_center - center) < 0.5f * radius && ratio < 2.0f && ratio > 0.5f;
  }

  std::optional<Choice> choice;    ///< of the integrator
  Mixed mixed;                     ///< chosen with it
  double samples_of_work = 1.0;    ///< samples that take the work of one of path tracing (choice/technique_choice.h)
  Guiding guiding = Guiding::Off;  ///< the same

  // Set by integrators. Null: nothing learned.
  std::shared_ptr<const PathGuide::Past> guide;   ///< guide of paths
  std::shared_ptr<const GuideTree> gather_guide;  ///< guide of gather rays
  /// Efficiency of mutations, and the importance of the film, by which contributions are divided.
  std::shared_ptr<const PathPopulation::Learned> population;
  std::shared_ptr<const LearnedLights> direct;  ///< probabilities of lights, valid while the lights are the same
};

}  // namespace ajar
