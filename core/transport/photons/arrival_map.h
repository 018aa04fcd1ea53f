// The density of the lookups of final gathering, weighted by their throughput to the image: on the first rough surface
// that the eye sees, and on the next rough surface after it. It is a density of throughput per area, estimated from the
// lookups of earlier passes.
//
// Metropolis photon sampling needs it. A chain over complete paths visits the vertex of a photon together with one of
// the many eye subpaths from there. The flux of the photon is therefore the flux of its light subpath times the share
// of *this* eye subpath in all of them,
//   q(subpath | vertex) = W(subpath) / W(vertex),
// where W is the throughput to the film, and this map estimates W(vertex). The thesis [Fan 2006, section 4.2.2] leaves
// out q, so that the flux depends on the area that is visible from the vertex. W(subpath) is nearly a factor of the
// chain's target. All photons therefore contribute nearly the same to the image: a photon that is rarely looked up
// contributes much to few lookups.
//
// For n lookups with throughputs w within the radius r of a point, W is (n + 1) / n sum(w) / (pi r^2 passes). The
// expectation of 1 / W is then correct except for e^-mean(n), also if r is the distance of the lookup n + 1. Where a
// disc extends over an edge, the error is the inverse of the error of the photons' density estimate. Lookups of all
// passes are stored (20 bytes each) up to a limit, and n grows with their number.
//
// Photons of chains and plain photons share the light by their densities at a position (balance heuristic), which also
// need W. A product of two functions of one noisy estimate of W is biased. So there are two independent halves of the
// lookups: one gives 1 / W, the other one the shares, and the mean of both ways is used.
#pragma once

#include "transport/photons/point_tree.h"

namespace ajar {

struct Arrival {
  SurfacePoint point;  ///< on the eye's side
  float throughput;    ///< luminance, to the pixel of the lookup's sample
  uint32_t half = 0;   ///< 0 or 1, drawn for each sample of the image
};

/// Lookups of a part of a pass. Only every `stride`-th is stored, and it stands for `stride` lookups.
struct ArrivalLog {
  std::vector<Arrival> at[2];
  int stride[2] = {1, 1};
};

class ArrivalMap {
 public:
  enum Place : int { kSeen = 0, kGathered = 1 };
  /// Maximum in one pass.
  static constexpr int kMaxLookups = 1 << 16;

  /// Adds the lookups of one pass.
  void add(const std::vector<ArrivalLog>& pass);
  /// 1 / W at a position, from the lookups of one half within `radius`; 0 where there are none. `normal`: on the side
  /// from which they look.
  double inverse_density(Place place, int half, Vec3 position, Vec3 normal, float radius) const;

  /// Where photons are: `both_sides`: they are found from both sides of a surface that transmits.
  struct Spot {
    Vec3 position, normal;
    bool both_sides;
  };
  /// Factors of the fluxes of photons of both kinds at a position. `of_chain` contains 1 / W. The expectation of
  /// of_chain * W + plain is 1.
  struct Factors {
    double of_chain, plain;
  };
  /// `chain_density`: photons of chains per watt are this times W. `plain_density`: plain photons per watt.
  Factors factors(Place place, const Spot& spot, float radius, double chain_density, double plain_density) const;
  size_t memory_bytes() const { return stored() * (2 * sizeof(SurfacePoint) + 2 * sizeof(float)); }

 private:
  /// Lookups of a place in one half.
  struct Half {
    std::vector<SurfacePoint> points;
    std::vector<float> throughputs;
    PointTree tree;  ///< of the lookups at the time of the last build
    std::vector<float> tree_throughputs;
  };
  size_t stored() const;

  Half halves_[2][2];  ///< of a place
  double passes_ = 0.0, passes_built_ = 0.0;
};

}  // namespace ajar
