// The colour matching functions of the CIE 1931 standard observer (2 degrees), from 380 to 780 nm in steps of 5 nm.
#pragma once

#include "math/types.h"

namespace ajar {

/// Converts CIE XYZ relative to D65 to the working space, Rec. 709. The result is not clamped.
inline Color xyz_to_rgb(Color xyz) {
  return {3.2404542f * xyz.x - 1.5371385f * xyz.y - 0.4985314f * xyz.z,
          -0.9692660f * xyz.x + 1.8760108f * xyz.y + 0.0415560f * xyz.z,
          0.0556434f * xyz.x - 0.2040259f * xyz.y + 1.0572252f * xyz.z};
}

namespace observer {

constexpr int kCount = 81;
constexpr float kFirst = 380.0f, kStep = 5.0f;  ///< nanometres
extern const float kMatching[kCount][3];

/// XYZ of monochromatic light, interpolated; black outside the table.
Color xyz(float nanometres);

}  // namespace observer

}  // namespace ajar
