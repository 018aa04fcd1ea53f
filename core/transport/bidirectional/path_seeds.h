// Bidirectional samples as starts of chains and members of populations: complete paths with energies.
//
// One sample finds several paths x_j. Their energies y_j >= 0 satisfy, for every function h, that E[sum_j y_j h(x_j)]
// is the integral of h times the target of the space. Paths that the space leaves out are not among them.
#pragma once

#include <optional>

#include "transport/bidirectional/bidirectional.h"
#include "transport/paths/path.h"

namespace ajar {

/// Walks that find the paths of a space, and the direct paths that it leaves out.
BidirectionalWalks walks_over(const PathSpace& space);

class PathSeeds {
 public:
  explicit PathSeeds(const PathSpace& space) : space_(space), walks_(walks_over(space)) {}

  /// Walks through a point of the film taken from `sampler`. Returns the sum of the energies of all paths found.
  double sample(Sampler& sampler);
  /// Completes the path at which the cumulative energy exceeds `u` times the sum. Returns false and counts a failure if
  /// rounding makes its contribution zero.
  bool take(double u, Path& path);

  /// Position of the last sample on the film, and its estimate of the luminance there by paths that the space leaves
  /// out.
  Vec2 film() const { return film_; }
  double left_out() const { return left_out_; }
  /// The same for the whole film, including paths from light walks that reach the lens.
  double left_out_light() const { return left_out_light_; }

  const Scene& scene() const { return space_.scene; }
  uint64_t rays() const { return walks_.rays(); }
  uint64_t failed() const { return failed_; }
  uint64_t refused() const { return walks_.refused(); }

 private:
  struct Found {
    const FoundPath* path;
    double energy_up_to;
  };
  const PathSpace& space_;
  BidirectionalWalks walks_;
  std::vector<Found> found_;
  Vec2 film_{0.0f};
  double left_out_ = 0.0, left_out_light_ = 0.0;
  uint64_t failed_ = 0;
};

}  // namespace ajar
