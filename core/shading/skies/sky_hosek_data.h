// Coefficients of the sky model of Hosek and Wilkie (2012). The indices are the component of XYZ, the ground albedo (0
// and 1), the turbidity (1 to 10), and the control point of a curve over the sun's elevation. The values are the nine
// parameters of the distribution, and the mean radiance.
#pragma once

namespace ajar::nodes {

extern const float kHosekConfiguration[3 * 2 * 10 * 6 * 9];
extern const float kHosekRadiance[3 * 2 * 10 * 6];

}  // namespace ajar::nodes
