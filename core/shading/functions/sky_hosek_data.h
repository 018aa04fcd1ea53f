// Coefficients of the sky model of Hosek and Wilkie (2012): per component of XYZ, ground albedo 0 and 1, turbidity 1 to 10, and control point of
// a curve over the sun's elevation, the nine parameters of the distribution, and the mean radiance.
#pragma once

namespace ajar::nodes {

extern const float kHosekConfiguration[3 * 2 * 10 * 6 * 9];
extern const float kHosekRadiance[3 * 2 * 10 * 6];

}  // namespace ajar::nodes
