// Bidirectional samples as starts of chains and members of populations: complete paths with energy.
//
// One sample finds several paths x_j; their energies y_j >= 0 are such that E[sum_j y_j h(x_j)] is the integral of h
// times the target of the space, for every h. Paths the space leaves out are not among them.
#pragma once

#include <optional>

#include "transport/bidirectional/bidirectional.h"
#include "transport/paths/path.h"

namespace ajar {

/// Walks that find the paths of a space, and those it leaves out as direct.
BidirectionalWalks walks_over(const PathSpace& space);

class PathSeeds {
 public:
  explicit PathSeeds(const PathSpace& space) : space_(space), walks_(walks_over(space)) {}

  /// Walks through a point of the film taken from `sampler`; returns the energy of all paths found together.
  double sample(Sampler& sampler);
  /// The path found where the cumulative energy passes `u` times the whole, complete. False (and counted) when rounding
  /// makes it carry nothing after all.
  bool take(double u, Path& path);

  /// Luminance arriving by paths the space leaves out, as estimated by the last sample, where it went through the film.
  Vec2 film() const { return film_; }
  double left_out() const { return left_out_; }
  /// The same for the whole film, with what light walks bring to the lens.
  double left_out_light() const { return left_out_light_; }

  const Scene& scene() const { return space_.scene; }
  uint64_t rays() const { return walks_.rays(); }
  uint64_t failed() const { return failed_; }

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
