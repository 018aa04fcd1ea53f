// Measured lamps: files of IES LM-63 (1986 to 2002) as the IES Texture node reads them.
//
// Meaning: Cycles' of Blender 3.4. Candela times the file's factors become Cycles' watts by 4 pi / 177.83 (the efficacy
// of D65). A direction is looked up by its angle from -z and its turn about z, angles between rows and columns are
// interpolated by Catmull-Rom splines in their number, what lies beyond the last row is dark. Type C: one plane stands
// for all, 0-90 and 0-180 are mirrored, 90-270 is turned to 0-180. Types A and B, files that leave out part of the
// circle, and those that begin above the nadir, are read as Blender 5.2 reads them: 3.4 refuses them or shows them
// dark.
//
// Tilt tables and the sizes of the opening are passed over, as there.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "math/types.h"

namespace ajar::nodes {

/// What a node without a usable file shows, as in Cycles.
inline constexpr float kWithoutIes = 100.0f;

class IesProfile {
 public:
  /// Reads a file's text. When it is none, `error` says what is wrong with it, and the profile stays empty.
  static IesProfile read(std::string_view text, std::string& error);

  bool empty() const { return values_.empty(); }
  /// Strength towards `direction`, of any length.
  float towards(Vec3 direction) const;

  const std::vector<float>& horizontal() const { return horizontal_; }  ///< radians, ascending
  const std::vector<float>& vertical() const { return vertical_; }      ///< radians from -z, ascending

 private:
  std::vector<float> horizontal_, vertical_;
  std::vector<float> values_;  ///< by horizontal angle, then vertical
  bool closed_ = false;        ///< the planes go all the way round, the last is the first again
};

}  // namespace ajar::nodes
