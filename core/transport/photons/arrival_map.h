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
// Photons of chains and plain photons share the light by their densities at a position (balance heuristic). With c
// photons of chains per watt and unit of W, and p plain photons per watt, chains get the factor a = c / (p + c W'), and
// plain photons get 1 - a W. The sum of both is correct for *any* a, if W is an estimate without bias that does not
// depend on a. So there are two independent halves of the lookups. One gives W' (with kPrior further lookups of the mean
// throughput, so that it is never 0 or nearly 0), the other one W, and the mean of both ways is used. No reciprocal of a
// noisy estimate is needed: its expectation is too large where throughputs differ much. The factor of a plain photon can
// be negative.
//
// W at a photon is the sum of the throughputs of the nearest lookups over their area and the number of passes. Each counts
// as it would count the photon: by the surface around the photon, and by its kernel. The lookups of all passes are stored
// (20 bytes each) up to a limit, so that the radius of the nearest ones falls.
#pragma once

#include "transport/photons/photon_map.h"

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
  /// W at a place, from the lookups of one half within `radius` that look from the side of its normal.
  double density(Place place, int half, const SurfacePoint& at, float radius) const;

  /// Factors of the fluxes of photons of both kinds at the place of a photon. The expectation of of_chain * W + plain is 1.
  struct Factors {
    double of_chain, plain;
  };
  /// `chain_density`: photons of chains per watt are this times W. `plain_density`: plain photons per watt.
  Factors factors(Place place, const PhotonMap::Weighable& photon, float radius, double chain_density,
                  double plain_density) const;
  size_t memory_bytes() const { return stored() * (2 * sizeof(SurfacePoint) + 2 * sizeof(float)); }

 private:
  /// Lookups of a place in one half.
  struct Half {
    std::vector<SurfacePoint> points;
    std::vector<float> throughputs;
    PointTree tree;  ///< of the lookups at the time of the last build
    std::vector<float> tree_throughputs;
    double mean_throughput = 0.0;  ///< of the lookups of the tree
  };
  size_t stored() const;
  /// Throughput per area that `throughput` within `radius2` is, in one half.
  double per_area(double throughput, double radius2) const {
    return throughput / (M_PI * radius2 * 0.5 * passes_built_);
  }
  /// The density, and, added to it, that of kPrior lookups of the mean throughput within the same radius. The
  /// throughput of a lookup is multiplied by in_lookup(its position, its squared distance, the squared radius).
  struct Estimate {
    double density, with_prior;
  };
  template <class InLookup>
  Estimate estimate(Place place, int half, const SurfacePoint& at, float radius, InLookup&& in_lookup) const;

  Half halves_[2][2];  ///< of a place
  double passes_ = 0.0, passes_built_ = 0.0;
};

}  // namespace ajar
