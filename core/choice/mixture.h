// Two techniques that render the same image in turns, each into its own film.
//
// `auto` mixes techniques if the image will be denoised and the pilot cannot tell which is better. The relMSE that a
// denoiser leaves falls about as 1/sqrt(time), and it is independent in both techniques. Half of the time for each of two
// techniques that are equally good therefore gives 0.7 of the error of either (docs/research/mixture.md). The denoised
// images are combined by their local errors (denoise/denoise.h), so that each technique serves the regions that it
// renders well, and a wrong choice costs little [Fan 2006, chapter 6: optimizing control variates].
//
// The rendered image before denoising is the mean of both with one weight for all pixels, which follows from the pilot
// and from the work done. It does not depend on the samples that it weights, so that the mean has the bias of its parts.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "denoise/shown_error.h"
#include "film/film.h"
#include "integrators/integrator.h"
#include "integrators/learned.h"

namespace ajar {

/// Whether a render with these passes can have two techniques: each pass is either the mean of both (the image, light
/// groups), or that of the first technique (surfaces, mattes, AOVs). Other passes are not known for a mean.
bool can_mix(const std::vector<std::string>& passes);

class Mixture {
 public:
  /// The passes that the film of the second technique has, of those of the render.
  static std::vector<std::string> passes_of_second(const std::vector<std::string>& passes);
  /// `second` is prepared. `settings`: of the render. The first technique and its film belong to the owner.
  Mixture(Learned::Second choice, std::unique_ptr<Integrator> second, const RenderSettings& settings);

  const Learned::Second& choice() const { return choice_; }
  /// Whether the second technique has less than its share of the work.
  bool is_due(const Integrator& first) const;
  Integrator& second() const { return *second_; }
  Film& film() { return *film_; }
  const Film& film() const { return *film_; }
  /// Samples per pixel of the second technique, in whole iterations.
  uint64_t done() const { return done_; }
  void add_done(uint64_t samples) { done_ += samples; }

  /// The pass of both techniques from that of the first: their mean, or both halves. The pass of the first if the second
  /// has no samples yet or if the pass is not of light.
  std::vector<float> of_both(const std::string& pass, std::vector<float> of_first, const Integrator& first,
                             float exposure) const;
  /// Adds the counts of the second technique.
  void add_to(IntegratorStatistics& statistics) const;
  void add_to(Film::SampleCounts& counts) const;
  /// Error of the mean of both; negative if one is unknown.
  Film::ErrorEstimate error_of_both(Film::ErrorEstimate of_first, const Integrator& first) const;
  Bias bias(const Integrator& first) const { return std::max(first.bias(), second_->bias()); }

 private:
  /// Weight of the first technique in the mean.
  double weight_of_first(const Integrator& first) const;

  Learned::Second choice_;
  std::unique_ptr<Integrator> second_;
  std::unique_ptr<Film> film_;
  uint64_t done_ = 0;
};

}  // namespace ajar
