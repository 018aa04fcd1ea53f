// Measured lamps: IES LM-63 files (1986 to 2002), as the IES Texture node reads them.
//
// The meaning is that of Cycles in Blender 3.4:
// - Candela times the factors of the file are converted to Cycles' watts by 4 pi / 177.83 (the efficacy of D65).
// - A direction is looked up by its angle from -z and its angle about z.
// - Values between rows and columns are interpolated by Catmull-Rom splines over their indices.
// - Beyond the last row the lamp is dark.
// - Type C: a single plane is used for all angles, 0-90 and 0-180 are mirrored, 90-270 is rotated to 0-180.
//
// Types A and B, files that leave out part of the circle, and files that start above the nadir are read as in Blender
// 5.2. Blender 3.4 rejects them or renders them dark.
//
// Tilt tables and the size of the opening are ignored, as in Cycles.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "math/types.h"

namespace ajar::nodes {

/// The value of a node without a usable file, as in Cycles.
inline constexpr float kWithoutIes = 100.0f;

class IesProfile {
 public:
  /// Reads the text of a file. If it is not valid, `error` describes the problem and the profile is empty.
  static IesProfile read(std::string_view text, std::string& error);

  bool empty() const { return values_.empty(); }
  /// The strength towards `direction`, which may have any length.
  float towards(Vec3 direction) const;

  const std::vector<float>& horizontal() const { return horizontal_; }  ///< radians, ascending
  const std::vector<float>& vertical() const { return vertical_; }      ///< radians from -z, ascending

 private:
  std::vector<float> horizontal_, vertical_;
  std::vector<float> values_;  ///< ordered by horizontal angle, then by vertical angle
  bool closed_ = false;        ///< the planes cover the full circle; the last is the first
};

}  // namespace ajar::nodes
