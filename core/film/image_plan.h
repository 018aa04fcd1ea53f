// Samples where the eye sees noise: how many samples each pixel gets (PMC-IP) [Fan 2006, section 5.3].
//
// The pixels are the components of a mixture over the image plane; adapting it means giving pixel k
//   C_k = max(floor, lambda o_k),   o_k = importance_k (e mean + (1 - e) (variance_k / w(L_k))^0.4),   sum C_k = N
//   pixels,
// w being tvi(L) (perceptual) or L^2 + 0.01 (relative). The thesis has the power 1, which makes the error of all pixels
// equal; 0.5 makes their sum least for independent samples, and somewhat less than that for ours, which are stratified
// in each pixel. The thesis has a fixed e of 0.01 and each pixel's own variance; ours is averaged over neighbours. Over
// how wide a reach, and which e, is chosen by how well such averages foretell pixels that were not in them: edges want
// a narrow reach, and where rare bright samples come from anywhere nothing foretells anything and e is 1. Leftover
// fractions go to pixels by ordered thresholds that are spread evenly over the plane.
//
// Unbiased. A pixel's value is the plain mean of its own samples, so its count must not depend on them, not even by way
// of others [algorithms.md, section 1: a pilot that decides how many more samples it is averaged with darkens the
// picture]. Therefore:
//   1. The pixels are coloured like a chessboard. o_k is made of pixels of the *other* colour only, and so is lambda:
//   each colour has
//      its own, and half of the samples.
//   2. Of those pixels, only the first b samples count, b fixed beforehand and the same for all (every pixel has at
//   least b).
// Samples of different pixels are independent. So the counts of white pixels are a function of the first b samples of
// black pixels, which are independent of all samples of white pixels, and their number is no one's choice; the same
// with the colours exchanged. Given its count, a pixel's mean is that of a fixed number of samples: unbiased, after any
// number of iterations. Without (2), two colours or two buffers would not do: the counts of white pixels would follow
// black samples whose number had followed white ones. Weights fixed per iteration would do as well, but a pixel's
// samples then are not one low-discrepancy sequence any more, and the weight of the first, uniform iteration is wasted
// where variance is high. What this does not cover: integrators whose pixels share what they learn during the render
// (photon maps, ocv_progressive) are consistent only, and so is stopping at an error, which looks at the samples.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "film/film.h"

namespace ajar {

enum class ErrorMeasure : uint8_t { Relative, Perceptual };
/// Round suits low-discrepancy sequences; integrators that render by passes want each pixel's samples spread over them.
enum class Counts : uint8_t { Round, Any };

class ImagePlan {
 public:
  /// Multiplies the share of each pixel of the film; empty: 1 for all. Called at the first look.
  using Importance = std::function<std::vector<float>()>;
  /// `first` samples a pixel, a power of two of at least 2, are taken before the first look.
  ImagePlan(ErrorMeasure measure, uint32_t first, uint32_t seed, Importance importance = {},
            Counts counts = Counts::Round);

  /// The iteration that starts when the average pixel has `done` samples must end here at the latest.
  uint32_t next_decision(uint32_t done) const;
  /// Set the film's goals to `samples` for the average pixel; all earlier goals have been reached. The picture depends
  /// on the last `samples`, not on the steps towards it, as long as these stop at the decisions.
  void plan(Film& film, uint32_t samples);

 private:
  uint32_t looked_at(uint32_t done) const;
  void decide(Film& film);
  void share_out(int width, int color, uint32_t samples, std::vector<uint32_t>& goals) const;

  ErrorMeasure measure_;
  uint32_t first_, seed_;
  int digits_;  // binary ones that counts keep below their first
  Importance find_importance_;
  std::vector<float> importance_;
  uint32_t planned_ = 0;                 // samples of the average pixel
  uint32_t early_ = 0;                   // the b of the last decision
  std::vector<float> shares_;            // o_k of the last decision
  std::vector<uint32_t> decided_goals_;  // goals that held then
};

}  // namespace ajar
