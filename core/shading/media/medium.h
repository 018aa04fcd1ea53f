// A participating medium at one point: its coefficients per metre.
//
// Scattering is a sum of coloured lobes. Extinction is scattering plus absorption. The coefficients
// of overlapping media are added [Fong, Wrenninge, Kulla and Habel 2017, "Production Volume Rendering"].
#pragma once

#include <array>

#include "math/types.h"
#include "shading/media/phase_shape.h"

namespace ajar {

struct MediumLobe {
  Color scattering{0.0f};  ///< per metre
  PhaseShape shape;
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

  /// Lobes of equal shape are joined. If there are too many different ones, the new lobe joins the one with the nearest
  /// mean cosine.
  void add_scattering(Color amount, const PhaseShape& shape) {
    if (is_black(amount)) return;
    extinction += amount;
    scattering += amount;
    for (int i = 0; i < lobe_count; ++i)
      if (lobes[size_t(i)].shape == shape) {
        lobes[size_t(i)].scattering += amount;
        return;
      }
    if (lobe_count < kMaxMixtureLobes)
      lobes[size_t(lobe_count++)] = {amount, shape};
    else
      lobes[nearest_lobe(shape.mean_cosine())].scattering += amount;
  }

 private:
  size_t nearest_lobe(float mean_cosine) const {
    size_t nearest = 0;
    float distance = kInfinity;
    for (size_t i = 0; i < size_t(lobe_count); ++i) {
      const float d = std::abs(lobes[i].shape.mean_cosine() - mean_cosine);
      if (d < distance) distance = d, nearest = i;
    }
    return nearest;
  }
};

}  // namespace ajar
