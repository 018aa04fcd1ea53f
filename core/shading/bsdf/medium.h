// A participating medium at one point: its coefficients per metre.
//
// Scattering is a sum of coloured Henyey-Greenstein lobes. Extinction is scattering plus absorption. The coefficients
// of overlapping media are added [Fong, Wrenninge, Kulla and Habel 2017, "Production Volume Rendering"].
#pragma once

#include <array>

#include "math/types.h"

namespace ajar {

struct MediumLobe {
  Color scattering{0.0f};   ///< per metre
  float anisotropy = 0.0f;  ///< mean cosine, within (-1, 1)
};

struct MediumPoint {
  static constexpr int kMaxMixtureLobes = 4;

  Color extinction{0.0f}, scattering{0.0f};  ///< per metre
  Color emission{0.0f};                      ///< radiance per metre
  std::array<MediumLobe, kMaxMixtureLobes> lobes;
  int lobe_count = 0;
  int refused = 0;  ///< number of values that were not numbers; they count as 0

  bool empty() const { return is_black(extinction) && is_black(emission); }
  bool scatters() const { return !is_black(scattering); }

  /// Lobes of equal anisotropy are joined. If there are too many different ones, the new lobe joins the one with the
  /// nearest anisotropy.
  void add_scattering(Color amount, float anisotropy) {
    if (is_black(amount)) return;
    extinction += amount;
    scattering += amount;
    int nearest = -1;
    for (int i = 0; i < lobe_count; ++i)
      if (nearest < 0 ||
          std::abs(lobes[size_t(i)].anisotropy - anisotropy) < std::abs(lobes[size_t(nearest)].anisotropy - anisotropy))
        nearest = i;
    if (lobe_count < kMaxMixtureLobes && (nearest < 0 || lobes[size_t(nearest)].anisotropy != anisotropy))
      lobes[size_t(lobe_count++)] = {amount, anisotropy};
    else
      lobes[size_t(nearest)].scattering += amount;
  }
};

}  // namespace ajar
