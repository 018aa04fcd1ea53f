// Media as walks and connections of whole paths need them: collisions with a density in closed form, transmittance apart.
//
// On each stretch of a ray in one stack of media, a walk collides with the density mean_c(r_c exp(-r_c t)) of the
// distance t, where r_c is the collision rate of channel c. Where the media are homogeneous, r is the extinction, and
// the density is that of the usual distance sampling [Veach 1997, section 9.2.4 for the mean over the channels]. A
// medium that varies has the mean extinction where it is not opaque as rate; the transmittance is then an unbiased
// estimate (ratio tracking, media.h) and not part of the density. So the density depends on the two ends of an edge
// alone, as multiple importance sampling and Metropolis-Hastings ratios need. Media that only absorb have the rate 0.
//
// Thread-safe. Functions count what media.h counts.
#pragma once

#include <tbb/combinable.h>

#include "sampling/sampler.h"
#include "transport/media/media.h"
#include "transport/media/phase_function.h"

namespace ajar {

/// A walk through one stretch.
struct MediaStretch {
  Color transmittance{1.0f};  ///< to the collision, or to the end of the stretch
  float pass = 1.0f;          ///< probability that a walk gets as far without a collision
  float rate = 0.0f;          ///< density of a collision there per metre, given that the walk gets there
};

class PathMedia {
 public:
  explicit PathMedia(const Scene& scene) : media_(scene) {}

  /// The volumes around a position.
  MediaStack around(Vec3 position, float time) const;
  /// The volumes that a ray is in after it has left a surface point to the side of `direction`. `front`: those on the
  /// side of point.ng.
  MediaStack beyond(const Scene& scene, const ShadingPoint& point, const MediaStack& front, Vec3 direction) const;
  /// Passes through the surface at `hit`.
  void cross(const Hit& hit, bool inwards, MediaStack& stack) const;
  /// The volumes of a ray that leaves the scene: the world's.
  void leave_all(MediaStack& stack) const;

  /// Samples a collision before the end of the stretch. True if there is one: at distance `t`, in the medium `at`.
  bool sample(const MediaRay& along, Sampler& sampler, MediaStretch& stretch, float& t, MediumPoint& at) const;
  /// The whole stretch without a collision.
  MediaStretch pass(const MediaRay& along, Pcg32& rng) const;
  /// The medium at distance t. A point that scatters nothing has no lobes.
  MediumPoint at(const MediaRay& along, float t) const;
  /// Whether the world has a volume.
  bool fills_world() const { return media_.fills_world(); }
  bool any_emission() const { return media_.any_emission(); }
  /// Radiance that the stretch emits towards its start; an unbiased estimate where media vary.
  Color emitted(const MediaRay& along, Pcg32& rng) const;
  /// Fraction of the light that reaches the end of a shadow ray, through surfaces that let light through.
  Color transmittance_to_light(const Ray& ray, const MediaStack& stack, const ShadingPoint& path, Pcg32& rng) const;

  /// For estimates that use media.h itself.
  const Media& media() const { return media_; }
  MediaCounters& local_counters() const { return counters_.local(); }
  MediaCounters counters() const;
  size_t memory_bytes() const { return media_.memory_bytes(); }

 private:
  Media media_;
  mutable tbb::combinable<MediaCounters> counters_;
};

/// Random numbers for estimates of transmittance, from one number of a sampler.
inline Pcg32 media_numbers(Sampler& sampler) { return Pcg32(uint64_t(double(sampler.get_1d()) * 0x1p32), 0x7472616eU); }

}  // namespace ajar
