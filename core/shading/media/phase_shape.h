// The shapes of phase functions. The cosine is between the directions of travel before and after scattering; densities
// are per solid angle and integrate to 1.
//
// - Draine 2003 ("Scattering by Interstellar Dust Grains", eq. 1), with Henyey and Greenstein 1941 (alpha 0) and
//   Rayleigh scattering (anisotropy 0, alpha 1) as special cases.
// - Fournier and Forand 1994 in the form of Fournier and Jonasz 1999, for particles in water.
#pragma once

#include <cmath>
#include <cstdint>

#include "math/types.h"

namespace ajar {

class PhaseShape {
 public:
  /// `anisotropy` is the mean cosine, within (-1, 1).
  static PhaseShape henyey_greenstein(float anisotropy) { return draine(anisotropy, 0.0f); }
  static PhaseShape rayleigh() { return draine(0.0f, 1.0f); }
  /// `alpha` is not negative.
  static PhaseShape draine(float anisotropy, float alpha);
  /// `backscatter` is the fraction of light that is scattered backwards, up to 0.5; `ior` is the relative index of the
  /// particles, above 1.
  static PhaseShape fournier_forand(float backscatter, float ior);

  float evaluate(float cosine) const {
    if (kind_ == Kind::FournierForand) return evaluate_fournier_forand(cosine);
    const float d = 1.0f + a_ * (a_ - 2.0f * cosine);
    const float value = 0.25f * kInvPi * (1.0f - a_ * a_) / (d * std::sqrt(d));
    return b_ == 0.0f ? value : value * (1.0f + b_ * cosine * cosine) * c_;
  }
  /// A cosine with that density.
  float sample(float u) const;
  /// The mean cosine; approximate for Fournier-Forand.
  float mean_cosine() const;
  bool operator==(const PhaseShape&) const = default;

 private:
  enum class Kind : uint8_t { Draine, FournierForand };

  float evaluate_fournier_forand(float cosine) const;
  float sample_draine(float u) const;
  float sample_fournier_forand(float u) const;

  Kind kind_ = Kind::Draine;
  float a_ = 0.0f;  ///< Draine: anisotropy; Fournier-Forand: delta over the squared sine of half the angle
  float b_ = 0.0f;  ///< Draine: alpha; Fournier-Forand: v = (3 - slope) / 2 of the distribution of sizes
  float c_ = 1.0f;  ///< Draine: 3 / (3 + alpha (1 + 2 anisotropy^2)); Fournier-Forand: amount of the polar term
};

/// Water droplets of a diameter in micrometres, up to 50: a mixture of Henyey-Greenstein and Draine (Jendersie and d'Eon
/// 2023, "An Approximate Mie Scattering Function for Fog and Cloud Rendering", eq. 4 and 7 to 22).
struct MieShapes {
  PhaseShape henyey_greenstein, draine;
  float draine_share;
};
MieShapes mie_shapes(float diameter);

}  // namespace ajar
