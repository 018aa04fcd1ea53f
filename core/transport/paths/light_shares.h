// How the light that a surface scatters is divided into the kinds of lobes that passes separate.
#pragma once

#include <array>

#include "shading/bsdf/bsdf.h"

namespace ajar {

/// Shares of diffuse, glossy and transmitted light in the scattered light; the sum is 1.
using PathShares = std::array<Color, 3>;
/// Where nothing is scattered (light beyond the terminator), the shares are those of the albedo.
PathShares shares_of(const Bsdf& bsdf, const PathShares& scattered);

}  // namespace ajar
