// Adaptive sampling: how many samples each pixel gets (PMC-IP) [Fan 2006, section 5.3].
//
// The pixels are the components of a mixture over the image plane. Adaptation gives pixel k
//   C_k = max(floor, lambda o_k) samples,   sum C_k = N pixels,
//   o_k = importance_k (e mean + (1 - e) (variance_k / (w(L_k) cost_k))^0.4),
// where w is tvi(L) (perceptual) or L^2 + 0.01 (relative) of the displayed luminance L, and cost_k is the time of a
// sample, in rays. Fractions of samples go to pixels by ordered thresholds that are spread evenly over the plane.
//
// Departures from the thesis:
// - The thesis has the power 1, which makes the errors of all pixels equal. The power 0.5 minimises their sum for
//   independent samples. The samples of a pixel are stratified here, for which a somewhat lower power is best.
// - The thesis does not count the cost. A noisy pixel often costs more than others. With shares by variance alone, the
//   error at equal time can be larger than with equal counts.
// - The thesis has a fixed e of 0.01 and the variance of each pixel alone. Here variance and cost are averaged over
//   neighbours. The reach of the average and e are chosen by how well such averages predict pixels that were not in
//   them. Edges need a narrow reach. If rare bright samples come from anywhere, no average predicts them, and e is 1.
//
// The image is unbiased. The value of a pixel is the plain mean of its own samples, so its count must not depend on
// them, not even through other pixels [algorithms.md, section 1: a pilot that decides how many more samples it is
// averaged with darkens the image]. Therefore:
// 1. The pixels are coloured like a chessboard. o_k and lambda depend on pixels of the *other* colour only. Each colour
//    has its own lambda and half of the samples.
// 2. Only the first b samples of those pixels are used. b is fixed beforehand and the same for all; every pixel has at
//    least b samples.
// Samples of different pixels are independent. So the counts of white pixels are a function of the first b samples of
// black pixels. These are independent of all samples of white pixels, and b depends on no sample. The same holds with
// the colours exchanged. Given its count, the mean of a pixel is that of a fixed number of samples and so unbiased,
// after any number of iterations.
//
// Without (2), two colours or two buffers would not be sufficient: the counts of white pixels would depend on black
// samples whose number had depended on white ones. Weights that are fixed for each iteration would be sufficient. But
// the samples of a pixel would then not be one low-discrepancy sequence, and the weight of the first, uniform iteration
// would be wasted where the variance is high.
//
// Two cases are only consistent: integrators whose pixels share what they learn during the render (photon maps,
// ocv_progressive), and a render that stops at an error, which depends on the samples.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "description/choices.h"
#include "film/film.h"

namespace ajar {

/// Round counts suit low-discrepancy sequences. Integrators that render in passes spread the samples of each pixel over
/// the passes and need any count.
enum class Counts : uint8_t { Round, Any };

class ImagePlan {
 public:
  /// Factors of the shares of the pixels, in the order of the film; empty: 1 for all. Called at the first decision.
  using Importance = std::function<std::vector<float>()>;
  /// Every pixel gets `first` samples, rounded up to a power of two and at least 2, before the first decision.
  ImagePlan(ErrorMeasure measure, uint32_t first, uint32_t seed, Importance importance = {},
            Counts counts = Counts::Round);

  /// An iteration that starts when the average pixel has `done` samples must not go beyond this count.
  uint32_t next_decision(uint32_t done) const;
  /// Sets the goals of the film to `samples` for the average pixel. All earlier goals must have been reached. The image
  /// depends on the last `samples` and not on the steps before it, if these stop at the decisions.
  void plan(Film& film, uint32_t samples);

 private:
  uint32_t looked_at(uint32_t done) const;
  void decide(Film& film);
  void share_out(int width, int color, uint32_t samples, std::vector<uint32_t>& goals) const;

  ErrorMeasure measure_;
  uint32_t first_, seed_;
  int digits_;  // number of binary digits of a count after the first one; the others are 0
  Importance find_importance_;
  std::vector<float> importance_;
  uint32_t planned_ = 0;                 // sample count of the average pixel
  uint32_t early_ = 0;                   // the b of the last decision
  std::vector<float> shares_;            // o_k of the last decision
  std::vector<uint32_t> decided_goals_;  // goals at the last decision
};

}  // namespace ajar
