// A surface's lobes as components of a mixture: each is sampled alone, with the density of its own.
//
// Lobes that would be sampled much alike are one component (diffuse and sheen; diffuse and gloss of roughness 0.5; on
// the same side, with nearly the same normal), and there are at most three: further ones join the one of the nearest
// width. Components go from the widest to the sharpest. Mirrors and straight-through transparency belong to none: no
// light is sampled by way of them. Surfaces whose lobes are all alike have one component, the Bsdf itself, and nothing
// is copied.
#pragma once

#include <array>
#include <optional>

#include "shading/bsdf/bsdf.h"

namespace ajar {

class LobeComponents {
 public:
  static constexpr int kMax = 3;

  /// Refers to `bsdf`, which stays as prepared for `wo`. `apart` false: one component, whatever the lobes.
  LobeComponents(const Bsdf& bsdf, Vec3 wo, bool apart);
  LobeComponents(const LobeComponents&) = delete;

  int count() const { return count_; }
  /// Of the components' shares when nothing is known: half alike, half as sampling the whole Bsdf chooses its lobes.
  /// Sum 1.
  float prior(int i) const { return prior_[size_t(i)]; }
  /// Tells apart surfaces whose components mean different things; 0 where there is one.
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
  /// Nothing where the random numbers lead nowhere, or to a mirror.
  std::optional<Sample> sample(int i, Vec3 wo, float u_lobe, Vec2 u) const;

 private:
  int count_ = 1;
  uint32_t signature_ = 0;
  std::array<float, kMax> prior_{1.0f, 0.0f, 0.0f};
  std::array<const Bsdf*, kMax> parts_;
  std::array<Bsdf, kMax> storage_;
};

}  // namespace ajar
