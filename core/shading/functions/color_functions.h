// The functions of the colour nodes: blending, HSV and HSL, ramps, corrections. The blend formulas are Blender's.
// Formulas with special cases at 0 follow Cycles (Apache-2.0) there.
#pragma once

#include <cmath>
#include <vector>

#include "math/observer.h"
#include "math/types.h"

namespace ajar {

struct CurveTable {
  std::vector<Vec4> values;
  float min = 0.0f, max = 1.0f;
  bool interpolate = true, extrapolate = false;
};

}  // namespace ajar

namespace ajar::nodes {

enum class Blend : uint8_t {
  Mix,
  Darken,
  Multiply,
  Burn,
  Lighten,
  Screen,
  Dodge,
  Add,
  Overlay,
  SoftLight,
  LinearLight,
  Difference,
  Exclusion,
  Subtract,
  Divide,
  Hue,
  Saturation,
  Color,
  Value
};

Color rgb_to_hsv(Color rgb);
Color hsv_to_rgb(Color hsv);
Color rgb_to_hsl(Color rgb);
Color hsl_to_rgb(Color hsl);
/// Blends `a` and `b`. `t` is not clamped.
Color blend(Blend mode, float t, Color a, Color b);
/// In linear Rec. 709. Without `clip`, colours outside of it have negative components.
Color blackbody(float kelvin, bool clip = true);

enum class ColorModel : uint8_t { Rgb, Hsv, Hsl };
inline Color combine(ColorModel model, Color c) {
  return model == ColorModel::Hsv ? hsv_to_rgb(c) : model == ColorModel::Hsl ? hsl_to_rgb(c) : c;
}
inline Color separate(ColorModel model, Color c) {
  return model == ColorModel::Hsv ? rgb_to_hsv(c) : model == ColorModel::Hsl ? rgb_to_hsl(c) : c;
}

inline Color invert(Color c, float t) { return t * (1.0f - c) + (1.0f - t) * c; }
inline Color gamma(Color c, float exponent) {
  if (exponent == 0.0f) return Color(1.0f);
  for (int i = 0; i < 3; ++i)
    if (c[i] > 0.0f) c[i] = std::pow(c[i], exponent);
  return c;
}
inline Color bright_contrast(Color c, float bright, float contrast) {
  return glm::max((1.0f + contrast) * c + (bright - 0.5f * contrast), 0.0f);
}
inline Color hue_saturation(Color c, float hue, float saturation, float value, float t) {
  Color hsv = rgb_to_hsv(c);
  hsv.x = std::fmod(hsv.x + hue + 0.5f, 1.0f);
  hsv.y = saturate(hsv.y * saturation);
  hsv.z *= value;
  return glm::max(t * hsv_to_rgb(hsv) + (1.0f - t) * c, 0.0f);
}

/// The value of a table. `x` in [0, 1] covers the table; beyond it, `table.extrapolate` decides.
Vec4 table_lookup(const CurveTable& table, float x);

}  // namespace ajar::nodes
