// Several techniques that render the same image in turns, each into its own film.
//
// `auto` mixes techniques if the image will be denoised and the pilot cannot tell which is best. All of them first get
// equal parts of a quarter of the work. Then the errors of their denoised images are estimated, and the two best share
// the rest (the first technique stays in any case, because its film has the passes that show surfaces). This is
// population Monte Carlo over techniques: the shares follow from finished iterations [Fan 2006, chapter 5].
//
// The relMSE that a denoiser leaves falls about as 1/sqrt(work), and it is independent in two techniques. With errors
// e1 and e2 at equal work, the best shares are in proportion to 1/e^2. Equally good techniques with half of the work each
// give 0.7 of the error of either with all of it (docs/research/mixture.md). The denoised images are combined by their
// local errors (denoise/technique_images.h), so that each technique serves the regions that it renders well, and a wrong
// choice costs little [Fan 2006, chapter 6: optimizing control variates].
//
// The rendered image before denoising is the mean of the images with one weight for all pixels, which follows from the
// pilot and from the work done. The shares depend on samples, so that the image is consistent, not unbiased.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "film/film.h"
#include "integrators/integrator.h"
#include "integrators/learned.h"

namespace ajar {

/// Whether a render with these passes can have several techniques: each pass is either the mean of all (the image, light
/// groups), or that of the first technique (surfaces, mattes, AOVs). Other passes are not known for a mean.
bool can_mix(const std::vector<std::string>& passes);

class Mixture {
 public:
  /// A technique that is ready to render, with its film. The first one belongs to the owner.
  struct Part {
    Integrator& integrator;
    Film& film;
    uint64_t done = 0;  ///< samples per pixel in whole iterations
  };

  /// The passes that the films of all but the first technique have, of those of the render.
  static std::vector<std::string> passes_of_others(const std::vector<std::string>& passes);

  /// `choice`: at least two techniques. `others`: all but the first, prepared, in the same order. The first technique
  /// and its film must outlive the mixture.
  Mixture(Learned::Mixed choice, Part first, std::vector<std::unique_ptr<Integrator>> others,
          const RenderSettings& settings);

  /// The techniques with their present shares.
  const Learned::Mixed& choice() const { return choice_; }
  const std::vector<Part>& parts() const { return parts_; }
  /// The technique whose turn it is: the one that is most behind its share of the work. A turn has a number of samples
  /// that does not depend on the clock, so that the image does not.
  Part& due();
  uint64_t samples_of_turn() const { return turn_samples_; }  ///< that are left
  void add_done(uint64_t samples);                            ///< at most as many, by the technique whose turn it is
  /// Whether the trial has just ended: a turn is over, its work is done, and each technique has enough samples.
  bool trial_ends() const;
  /// Ends the trial. `errors`: estimates of the relMSE of each technique's denoised image; empty: unknown, then the two
  /// best of the pilot remain with equal shares. Returns a step of the plan.
  PlanStep share_by(const std::vector<double>& errors);
  /// Samples per pixel of all techniques together that this work pays for, with the present shares. All techniques must
  /// have samples.
  uint64_t samples_for(double work) const;

  /// The pass of all techniques from that of the first: their mean, or the halves of each. Techniques without samples
  /// do not count, and a pass that is not of light is that of the first.
  std::vector<float> of_all(const std::string& pass, std::vector<float> of_first, float exposure) const;
  /// Adds the counts of the other techniques. Rays and paths include those of techniques that got no share.
  void add_to(IntegratorStatistics& statistics) const;
  void add_to(Film::SampleCounts& counts) const;
  /// Memory of their films, and samples that they have refused.
  uint64_t film_bytes() const;
  uint64_t refused() const;
  /// Error of the mean of all; negative if one is unknown.
  Film::ErrorEstimate estimated_error() const;

 private:
  /// Those of the mean of all images, with the sum 1.
  std::vector<double> weights() const;
  double work(size_t technique) const;
  void remove(size_t technique);

  Learned::Mixed choice_;
  std::vector<Part> parts_;
  size_t turn_ = 0;
  uint64_t turn_samples_ = 0;
  std::vector<std::unique_ptr<Integrator>> integrators_;  // of parts_ from the second on
  std::vector<std::unique_ptr<Film>> films_;              // the same
  uint64_t removed_rays_ = 0, removed_paths_ = 0;
};

}  // namespace ajar
