// What an eye can tell apart: threshold versus intensity.
#pragma once

#include <algorithm>
#include <cmath>

namespace ajar {

/// Radiance 1 of a scene is the white of a display; viewing conditions of ITU-R BT.709 and sRGB assume 80 to 100 cd/m^2.
inline constexpr double kCandelasPerUnit = 100.0;

/// The smallest difference of luminance that an eye adapted to `candelas` (cd/m^2) can see, in cd/m^2 [Ferwerda et al. 1996; Ward
/// Larson et al. 1997, "A Visibility Matching Tone Reproduction Operator", table 1].
inline double tvi(double candelas) {
  const double l = std::log10(std::max(candelas, 1e-30));
  double exponent;
  if (l < -3.94) exponent = -2.86;
  else if (l < -1.44) exponent = std::pow(0.405 * l + 1.6, 2.18) - 2.86;
  else if (l < -0.0184) exponent = l - 0.395;
  else if (l < 1.9) exponent = std::pow(0.249 * l + 0.65, 2.7) - 0.72;
  else exponent = l - 1.255;
  return std::pow(10.0, exponent);
}

}  // namespace ajar
