// The unit of errors of an image, as in relMSE: the mean of (I - R)^2 / (R^2 + 0.01) [Rousselle et al. 2011].
//
// The constant keeps darkness from counting: an error of light far below 0.1 is not seen. This holds for the light that
// is displayed. An artist who lights a scene by a sun of 1,000 W/m^2 and displays it at an exposure of -8 stops sees
// black where the light is 1. So light is compared after the exposure of the film and of the display.
#pragma once

#include <algorithm>

namespace ajar {

inline constexpr double kDarkSquared = 0.01;  ///< added to squares of displayed light

/// What is added to squares of light that is multiplied by `exposure` before it is displayed. It is finite for any
/// exposure, also as a float.
inline double dark_squared(double exposure) { return kDarkSquared / std::max(exposure * exposure, 1e-24); }

}  // namespace ajar
