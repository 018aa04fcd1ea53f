// The lobes of a surface as components of a mixture. Each component is sampled separately, with a density of its own.
//
// Lobes with nearly equal sampling are one component: those on the same side, with nearly the same normal and similar
// widths (diffuse and sheen; diffuse and glossy of roughness 0.5). There are at most three components; further lobes
// join the component with the nearest width. Components are ordered from the widest to the sharpest. Delta lobes and
// transparency belong to no component, because no light is sampled through them. A surface with a single component uses
// the Bsdf itself, and nothing is copied.
#pragma once

#include <array>
#include <optional>

#include "shading/bsdf/bsdf.h"

namespace ajar {

class LobeComponents {
 public:
  static constexpr int kMax = 3;

  /// Refers to `bsdf`, which must stay prepared for `wo`. If `apart` is false, there is one component for all lobes.
  LobeComponents(const Bsdf& bsdf, Vec3 wo, bool apart);
  LobeComponents(const LobeComponents&) = delete;

  int count() const { return count_; }
  /// The prior share of a component: half of it is equal for all, half is the selection probability of its lobes. The
  /// sum is 1.
  float prior(int i) const { return prior_[size_t(i)]; }
  /// Differs between surfaces whose components have different meanings. 0 for a single component.
  uint32_t signature() const { return signature_; }

  struct Evaluation {
    Color f_cos;                  ///< of all lobes
    std::array<float, kMax> pdf;  ///< of each component, per solid angle
  };
  Evaluation evaluate(Vec3 wo, Vec3 wi) const;
  struct Sample {
    Vec3 wi;
    uint32_t flags;  ///< LobeFlags
    Evaluation value;
  };
  /// Returns nothing if the random numbers give no direction or select a delta lobe.
  std::optional<Sample> sample(int i, Vec3 wo, float u_lobe, Vec2 u) const;

 private:
  int count_ = 1;
  uint32_t signature_ = 0;
  std::array<float, kMax> prior_{1.0f, 0.0f, 0.0f};
  std::array<const Bsdf*, kMax> parts_;
  std::array<Bsdf, kMax> storage_;
};

}  // namespace ajar
