// Where the final gather looks its maps up, and how much of the picture each lookup carries: on the first rough surface
// the eye sees, and on the rough one after it. A density per area of throughput, estimated from the lookups of earlier
// passes.
//
// Metropolis photon sampling needs it: a chain over complete paths visits a photon's place together with one of the
// many ways from there to the eye, so the photon's power is that of its light subpath times the share of *that* way in
// all,
//   q(way | place) = W(way) / W(place),
// W being the throughput to the film and W(place) what this map estimates. The thesis [Fan 2006, section 4.2.2] leaves
// q out, which makes powers depend on the area of what is seen from the place. W(way) is nearly the way's own part of
// the chain's target, so that all photons bring nearly the same to the picture: one that is seldom looked up, much to
// few lookups.
//
// Around a place with n lookups of throughputs w within radius r, W is (n + 1) / n sum(w) / (pi r^2 passes): the mean
// of 1 / W is then right but for e^-mean(n), also where r is the distance of the nearest n + 1. Where a disc reaches
// over an edge this errs as the density estimate of the photons does, the other way round. Lookups of all passes are
// kept (20 bytes each) up to a limit.
#pragma once

#include "transport/photons/point_tree.h"

namespace ajar {

struct Arrival {
  SurfacePoint point;  ///< normal on the eye's side
  float throughput;    ///< luminance, to the pixel of the sample it belongs to
};

/// Lookups of a part of a pass. Only every `stride`-th is kept, for so many.
struct ArrivalLog {
  std::vector<Arrival> at[2];
  int stride[2] = {1, 1};
};

class ArrivalMap {
 public:
  enum Place : int { kSeen = 0, kGathered = 1 };
  /// Of one pass.
  static constexpr int kMaxLookups = 1 << 16;

  /// A pass, added to those before.
  void add(const std::vector<ArrivalLog>& pass);
  /// Inverse of W around a place, from lookups within `radius`; 0 where there are none. `normal`: of the side they look
  /// from.
  double inverse_density(Place place, Vec3 position, Vec3 normal, float radius) const;
  /// Of lookups from either side, as photons on surfaces that transmit are found.
  double inverse_density_of_both_sides(Place place, Vec3 position, Vec3 normal, float radius) const;
  size_t memory_bytes() const {
    return (points_[0].size() + points_[1].size()) * (2 * sizeof(SurfacePoint) + 2 * sizeof(float));
  }

 private:
  std::vector<SurfacePoint> points_[2];
  std::vector<float> throughputs_[2];
  PointTree trees_[2];  ///< of the lookups there were when they were last built
  std::vector<float> tree_throughputs_[2];
  double passes_ = 0.0, passes_built_ = 0.0;
};

}  // namespace ajar
