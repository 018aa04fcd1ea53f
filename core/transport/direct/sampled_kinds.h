// The kinds of the lobes that scatter light along a direction, for lights that only some kinds of rays see.
//
// The BSDF sample of a vertex has one direction, and the kind of one lobe. Its ray meets a light only if the light is
// visible to this kind. So the density with which rays find the light is that of the direction, times the probability of
// the visible kinds given the direction; and what they find is the light that the visible lobes scatter. Light samples
// are weighted against this density [Veach 1997, section 9.2]: all light is found once, although the two estimators see
// different kinds in each sample. If a path guide has sampled the direction, it chooses the kind with the same
// probabilities (guided_bsdf.h).
#pragma once

#include <array>

#include "transport/paths/ray_events.h"

namespace ajar {

/// The probability of the kinds of rays that see a light of this visibility.
inline float visible_share(const Bsdf::KindShares& shares, uint32_t visibility) {
  return (visibility & kVisibleDiffuse ? shares.diffuse : 0.0f) + (visibility & kVisibleGlossy ? shares.glossy : 0.0f) +
         (visibility & kVisibleTransmission ? shares.transmission + shares.diffuse_transmission : 0.0f);
}

/// Of a direction that the rough lobes of a surface have sampled.
class SampledKinds {
 public:
  SampledKinds() = default;
  SampledKinds(const Bsdf& bsdf, Vec3 wo, Vec3 wi)
      : shares_(bsdf.kind_shares(wo, wi, false)), f_cos_(bsdf.f_cos_of_kinds(wo, wi)) {}

  /// The probability that the ray sees a light of this visibility.
  float share(uint32_t visibility) const { return visible_share(shares_, visibility); }
  /// The throughput of a path that meets the light, over the throughput of the sample, which is that of all lobes.
  Color throughput(uint32_t visibility) const {
    const float found = share(visibility);
    const Color all = visible_to(kVisibleAll, f_cos_), visible = visible_to(visibility, f_cos_);
    Color ratio(0.0f);
    for (int c = 0; c < 3; ++c)
      if (found > 0.0f && all[c] != 0.0f) ratio[c] = visible[c] / (all[c] * found);
    return ratio;
  }

 private:
  Bsdf::KindShares shares_;
  std::array<Color, 3> f_cos_;
};

}  // namespace ajar
