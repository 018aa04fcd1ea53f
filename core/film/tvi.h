// The visibility threshold of the eye as a function of luminance (threshold versus intensity).
#pragma once

#include <algorithm>
#include <cmath>

namespace ajar {

/// Radiance 1 of a scene is the white of a display. The viewing conditions of ITU-R BT.709 and sRGB assume 80 to 100
/// cd/m^2.
inline constexpr double kCandelasPerUnit = 100.0;

/// Minimum difference of luminance that an eye adapted to `candelas` (cd/m^2) can see, in cd/m^2 [Ferwerda et al. 1996;
/// Ward Larson et al. 1997, "A Visibility Matching Tone Reproduction Operator", table 1].
inline double tvi(double candelas) {
  // The table gives log(tvi) as a function of log(candelas). Where tvi is proportional to candelas or constant, no
  // logarithm is needed.
  if (candelas < 1.148153621496883e-4) return 1.3803842646028852e-3;                     // 10^-3.94, 10^-2.86
  if (candelas >= 79.43282347242814) return 0.05559042572704037 * candelas;              // 10^1.9, 10^-1.255
  const bool is_bright = candelas >= 0.03630780547701014;                                // 10^-1.44
  if (is_bright && candelas < 0.9585173976856458) return 0.4027170343254591 * candelas;  // 10^-0.0184, 10^-0.395
  const double l = std::log10(candelas),
               exponent = is_bright ? std::pow(0.249 * l + 0.65, 2.7) - 0.72 : std::pow(0.405 * l + 1.6, 2.18) - 2.86;
  constexpr double kBinary = 3.321928094887362;  // log2(10)
  return std::exp2(kBinary * exponent);
}

}  // namespace ajar
