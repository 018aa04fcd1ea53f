// The bounce limits of a path that photons and a walk from the eye make together. Limits are for whole paths, so that a
// photon stores how many bounces its part leaves to the rest, and a lookup compares them with those on its side.
//
// As in path tracing, the scattering next to the light counts only for the limit of the total. The scattering where the
// photon is looked up counts if the photon was scattered before.
#pragma once

#include <algorithm>
#include <bit>

#include "description/settings.h"
#include "math/types.h"
#include "shading/bsdf/bsdf.h"

namespace ajar {

/// Bounces of each kind of a part of a path. `total` is one less than the number of scatterings of the whole path.
struct BounceCounts {
  int total = 0, diffuse = 0, glossy = 0, transmission = 0, volume = 0;
};

/// Bounce counts in 30 bits, to compare all of them at once: five fields of five bits, each with a clear bit above it.
/// A count of kAny or more is kAny, which means any number if it is left.
class PackedBounces {
 public:
  static constexpr int kAny = 31;
  static constexpr int kBits = 30;

  constexpr PackedBounces() : bits_(kFields) {}
  explicit constexpr PackedBounces(const BounceCounts& c)
      : bits_(field(c.total, 0) | field(c.diffuse, 1) | field(c.glossy, 2) | field(c.transmission, 3) |
              field(c.volume, 4)) {}
  static constexpr PackedBounces from_bits(uint32_t bits) {
    PackedBounces b;
    b.bits_ = bits;
    return b;
  }
  constexpr uint32_t bits() const { return bits_; }

  /// The same counts with a mark, which comparisons ignore in the counts that are left.
  constexpr PackedBounces marked() const { return from_bits(bits_ | kMark); }
  constexpr bool is_marked() const { return bits_ & kMark; }

  /// Whether each of these counts is at most the one that is left.
  constexpr bool within(PackedBounces left) const { return differences(left.bits_, bits_) == kAbove; }
  /// The smaller one of each count.
  friend constexpr PackedBounces min(PackedBounces a, PackedBounces b) {
    const uint32_t b_is_smaller = differences(a.bits_, b.bits_ & kFields),
                   mask = b_is_smaller - (b_is_smaller >> kFieldBits);
    return from_bits((b.bits_ & mask) | (a.bits_ & ~mask & kFields));
  }

 private:
  static constexpr int kFieldBits = 5;
  static constexpr uint32_t kAbove = 0x20820820U, kFields = 0x1f7df7dfU, kMark = 0x20U;
  static constexpr uint32_t field(int count, int number) {
    return uint32_t(std::clamp(count, 0, kAny)) << ((kFieldBits + 1) * number);
  }
  /// The bits above the fields where a is at least b.
  static constexpr uint32_t differences(uint32_t a, uint32_t b) { return ((a | kAbove) - b) & kAbove; }
  uint32_t bits_;
};

/// The bounces of a photon so far, for comparison with the limits. A stored photon has one more scattering (caustics) or
/// two more (global map) before it reaches the eye.
struct PhotonBounces {
  BounceCounts counts;  ///< without the kind of the scattering next to the light
  bool only_sharp = true, diffuse_at_first = false;
  bool past_ray_kinds = false;  ///< the light has passed surfaces as only shadow rays do

  void add(const BsdfSample& sample) {
    const bool is_diffuse = sample.flags & kDiffuse, transmitted = sample.flags & kTransmission;
    if (counts.total++ == 0) {
      diffuse_at_first = is_diffuse;
      return;
    }
    counts.diffuse += is_diffuse;
    counts.glossy += !is_diffuse && !transmitted;
    counts.transmission += transmitted;
  }
  void add_volume() {
    counts.volume += counts.total > 0;
    ++counts.total;
    only_sharp = false;
  }
  /// Whether there may be a lookup in the global map with bounces within the limits. `rough_glossy`: some rough lobes are
  /// not diffuse. `next_is_diffuse`: those of the place at which the photon arrives are.
  bool global(const BounceLimits& limits, bool rough_glossy, bool next_is_diffuse = false) const {
    const bool diffuse_left = rough_glossy ? counts.diffuse + (next_is_diffuse && counts.total > 0) <= limits.diffuse
                                           : counts.diffuse + diffuse_at_first < limits.diffuse;
    return counts.total < limits.total && diffuse_left && others(limits);
  }
  bool caustic(const BounceLimits& limits) const {
    return only_sharp && counts.total > 0 && counts.total <= limits.total && others(limits);
  }
  PackedBounces left(const BounceLimits& limits) const {
    if (counts.total == 0) return {};  // the eye's side is within the limits, and no other scattering counts
    const PackedBounces left({limits.total - counts.total, limits.diffuse - counts.diffuse,
                              limits.glossy - counts.glossy, limits.transmission - counts.transmission,
                              limits.volume - counts.volume});
    return past_ray_kinds ? left.marked() : left;
  }

 private:
  bool others(const BounceLimits& limits) const {
    return counts.glossy <= limits.glossy && counts.transmission <= limits.transmission &&
           counts.volume <= limits.volume;
  }
};

/// Flux with a PackedBounces in the lowest bits of its mantissas. It is rounded to 14 significant bits.
class FluxWithBounces {
 public:
  FluxWithBounces() = default;
  FluxWithBounces(Color flux, PackedBounces left) {
    for (int c = 0; c < 3; ++c)
      bits_[c] = ((std::bit_cast<uint32_t>(flux[c]) + kMask / 2 + 1) & ~kMask) | (left.bits() >> (kShare * c) & kMask);
  }
  Color flux() const {
    return {std::bit_cast<float>(bits_[0] & ~kMask), std::bit_cast<float>(bits_[1] & ~kMask),
            std::bit_cast<float>(bits_[2] & ~kMask)};
  }
  PackedBounces left() const {
    return PackedBounces::from_bits((bits_[0] & kMask) | (bits_[1] & kMask) << kShare |
                                    (bits_[2] & kMask) << (2 * kShare));
  }

 private:
  static constexpr int kShare = PackedBounces::kBits / 3;
  static constexpr uint32_t kMask = (1u << kShare) - 1;
  uint32_t bits_[3];
};

}  // namespace ajar
