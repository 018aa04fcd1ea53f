// What a render has learned that holds in another frame of an animation, too.
//
// Everything here only proposes: where a guide sends paths, in which order lights are tried, which technique is asked.
// Estimates are made anew in every frame, with random numbers that no frame before has used; so each frame is as
// unbiased as if it had been rendered alone, and its error is not correlated with the error of those before, however
// wrong what it was handed (a wrong guide costs time).
//
// Not carried is what is an estimate itself: weights of members of a population, chains that go on, normalisations,
// irradiance records, photons. It would bring the error of one frame into the next. Nor what belongs to blocks of
// pixels and is wrong as soon as others are seen there: coefficients of control variates.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "transport/chains/path_population.h"
#include "transport/direct/estimators/pmc_hi.h"
#include "transport/guiding/path_guide.h"

namespace ajar {

struct Learned {
  /// By `auto`: from where it was made, and how many frames have relied on it.
  struct Choice {
    Vec3 eye, direction;
    uint32_t age;
  };
  static constexpr uint32_t kMaxAge = 24;  ///< of the choice
  /// A guide with more cells is not handed on, so that a long flight through a large scene does not fill the memory:
  /// about 60 MB.
  static constexpr size_t kMaxCells = 100'000;

  // Of the render that learned it; these are the session's.
  std::string integrator;
  uint32_t frames = 0;  ///< of the animation so far, this one included: each has random numbers of its own
  Vec3 center{0.0f};    ///< of the scene
  float radius = 0.0f;

  std::optional<Choice> choice;  ///< of the integrator

  // By integrators. Null: nothing.
  std::shared_ptr<const PathGuide::Past> guide;   ///< of paths
  std::shared_ptr<const GuideTree> gather_guide;  ///< of gather rays
  /// how mutations fare, and how bright the film is where: it divides out
  std::shared_ptr<const PathPopulation::Learned> population;
  std::shared_ptr<const LearnedLights> direct;  ///< which lights to choose, as long as they are the same
};

}  // namespace ajar
