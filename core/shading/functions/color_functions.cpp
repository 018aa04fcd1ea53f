#include "shading/functions/color_functions.h"

#include <algorithm>

namespace ajar::nodes {

Color rgb_to_hsv(Color rgb) {
  const float high = max_component(rgb), low = std::min({rgb.x, rgb.y, rgb.z});
  const float range = high - low;
  const float saturation = high != 0.0f ? range / high : 0.0f;
  if (saturation == 0.0f) return {0.0f, saturation, high};
  const Color c = (Color(high) - rgb) / range;
  float hue = rgb.x == high ? c.z - c.y : rgb.y == high ? 2.0f + c.x - c.z : 4.0f + c.y - c.x;
  hue /= 6.0f;
  return {hue < 0.0f ? hue + 1.0f : hue, saturation, high};
}

Color hsv_to_rgb(Color hsv) {
  if (hsv.y == 0.0f) return Color(hsv.z);
  const float h = (hsv.x == 1.0f ? 0.0f : hsv.x) * 6.0f, sector = std::floor(h), f = h - sector;
  const float v = hsv.z, p = v * (1.0f - hsv.y), q = v * (1.0f - hsv.y * f), t = v * (1.0f - hsv.y * (1.0f - f));
  if (sector == 0.0f) return {v, t, p};
  if (sector == 1.0f) return {q, v, p};
  if (sector == 2.0f) return {p, v, t};
  if (sector == 3.0f) return {p, q, v};
  if (sector == 4.0f) return {t, p, v};
  return {v, p, q};
}

Color rgb_to_hsl(Color rgb) {
  const float high = max_component(rgb), low = std::min({rgb.x, rgb.y, rgb.z});
  const float lightness = std::min(1.0f, 0.5f * (high + low)), range = high - low;
  if (range == 0.0f) return {0.0f, 0.0f, lightness};
  const float saturation = lightness > 0.5f ? range / (2.0f - high - low) : range / (high + low);
  const float hue = high == rgb.x   ? (rgb.y - rgb.z) / range + (rgb.y < rgb.z ? 6.0f : 0.0f)
                    : high == rgb.y ? (rgb.z - rgb.x) / range + 2.0f
                                    : (rgb.x - rgb.y) / range + 4.0f;
  return {hue / 6.0f, saturation, lightness};
}

Color hsl_to_rgb(Color hsl) {
  const float h = hsl.x * 6.0f;
  const Color pure(saturate(std::abs(h - 3.0f) - 1.0f), saturate(2.0f - std::abs(h - 2.0f)),
                   saturate(2.0f - std::abs(h - 4.0f)));
  const float chroma = (1.0f - std::abs(2.0f * hsl.z - 1.0f)) * hsl.y;
  return (pure - 0.5f) * chroma + hsl.z;
}

namespace {

float overlay(float t, float a, float b) {
  return a < 0.5f ? a * (1.0f - t + 2.0f * t * b) : 1.0f - (1.0f - t + 2.0f * t * (1.0f - b)) * (1.0f - a);
}

float dodge(float t, float a, float b) {
  if (a == 0.0f) return 0.0f;
  const float d = 1.0f - t * b;
  return d <= 0.0f ? 1.0f : std::min(a / d, 1.0f);
}

float burn(float t, float a, float b) {
  const float d = 1.0f - t + t * b;
  return d <= 0.0f ? 0.0f : saturate(1.0f - (1.0f - a) / d);
}

template <float (*Function)(float, float, float)>
Color each(float t, Color a, Color b) {
  return {Function(t, a.x, b.x), Function(t, a.y, b.y), Function(t, a.z, b.z)};
}

/// Blends that take hue, saturation or value from `b`. A grey `b` has no hue and does not change `a`.
Color blend_hsv(Blend mode, float t, Color a, Color b) {
  Color hsv = rgb_to_hsv(a);
  const Color other = rgb_to_hsv(b);
  switch (mode) {
    case Blend::Hue:
    case Blend::Color:
      if (other.y == 0.0f) return a;
      hsv.x = other.x;
      if (mode == Blend::Color) hsv.y = other.y;
      return glm::mix(a, hsv_to_rgb(hsv), t);
    case Blend::Saturation:
      if (hsv.y == 0.0f) return a;
      hsv.y = glm::mix(hsv.y, other.y, t);
      return hsv_to_rgb(hsv);
    default: hsv.z = glm::mix(hsv.z, other.z, t); return hsv_to_rgb(hsv);
  }
}

}  // namespace

Color blend(Blend mode, float t, Color a, Color b) {
  const Color one(1.0f);
  const auto towards = [&](Color target) { return a + t * (target - a); };
  switch (mode) {
    case Blend::Mix: return towards(b);
    case Blend::Add: return towards(a + b);
    case Blend::Multiply: return towards(a * b);
    case Blend::Subtract: return towards(a - b);
    case Blend::Difference: return towards(glm::abs(a - b));
    case Blend::Exclusion: return glm::max(towards(a + b - 2.0f * a * b), 0.0f);
    case Blend::Darken: return towards(glm::min(a, b));
    case Blend::Lighten: return towards(glm::max(a, b));
    case Blend::Screen: return one - (1.0f - t + t * (one - b)) * (one - a);
    case Blend::Divide: {
      Color result = a;
      for (int i = 0; i < 3; ++i)
        if (b[i] != 0.0f) result[i] = (1.0f - t) * a[i] + t * a[i] / b[i];
      return result;
    }
    case Blend::Overlay: return each<overlay>(t, a, b);
    case Blend::Dodge: return each<dodge>(t, a, b);
    case Blend::Burn: return each<burn>(t, a, b);
    case Blend::SoftLight: {
      const Color screen = one - (one - b) * (one - a);
      return (1.0f - t) * a + t * ((one - a) * b * a + a * screen);
    }
    case Blend::LinearLight: return a + t * (2.0f * b - one);
    case Blend::Hue:
    case Blend::Saturation:
    case Blend::Color:
    case Blend::Value: return blend_hsv(mode, t, a, b);
  }
  return a;
}

// Piecewise fit of the Planckian locus in Rec. 709, which Blender's Blackbody node uses (Cycles, kernel/tables.h): red
// and green as a / T + b T + c, blue as a cubic.
Color blackbody(float kelvin, bool clip) {
  static constexpr float kUpper[6] = {965, 1167, 1449, 1902, 3315, 6365};
  static constexpr float kRed[7][3] = {
      {1.61919106e+03f, -2.05010916e-03f, 5.02995757e+00f}, {2.48845471e+03f, -1.11330907e-03f, 3.22621544e+00f},
      {3.34143193e+03f, -4.86551192e-04f, 1.76486769e+00f}, {4.09461742e+03f, -1.27446582e-04f, 7.25731635e-01f},
      {4.67028036e+03f, 2.91258199e-05f, 1.26703442e-01f},  {4.59509185e+03f, 2.87495649e-05f, 1.50345020e-01f},
      {3.78717450e+03f, 9.35907826e-06f, 3.99075871e-01f}};
  static constexpr float kGreen[7][3] = {
      {-4.88999748e+02f, 6.04330754e-04f, -7.55807526e-02f}, {-7.55994277e+02f, 3.16730098e-04f, 4.78306139e-01f},
      {-1.02363977e+03f, 1.20223470e-04f, 9.36662319e-01f},  {-1.26571316e+03f, 4.87340896e-06f, 1.27054498e+00f},
      {-1.42529332e+03f, -4.01150431e-05f, 1.43972784e+00f}, {-1.17554822e+03f, -2.16378048e-05f, 1.30408023e+00f},
      {-5.00799571e+02f, -4.59832026e-06f, 1.09098763e+00f}};
  static constexpr float kBlue[7][4] = {{5.96945309e-11f, -4.85742887e-08f, -9.70622247e-05f, -4.07936148e-03f},
                                        {2.40430366e-11f, 5.55021075e-08f, -1.98503712e-04f, 2.89312858e-02f},
                                        {-1.40949732e-11f, 1.89878968e-07f, -3.56632824e-04f, 9.10767778e-02f},
                                        {-3.61460868e-11f, 2.84822009e-07f, -4.93211319e-04f, 1.56723440e-01f},
                                        {-1.97075738e-11f, 1.75359352e-07f, -2.50542825e-04f, -2.22783266e-02f},
                                        {-1.61997957e-13f, -1.64216008e-08f, 3.86216271e-04f, -7.38077418e-01f},
                                        {6.72650283e-13f, -2.73078809e-08f, 4.24098264e-04f, -7.52335691e-01f}};
  Color c;
  if (kelvin >= 12000.0f) {
    c = {0.8262954810f, 0.9945080502f, 1.566307710f};
  } else if (!(kelvin >= 800.0f)) {
    c = {5.413294490f, -0.2031939004f, -0.0822535243f};
  } else {
    int i = 0;
    while (i < 6 && kelvin >= kUpper[i]) ++i;
    const auto rational = [kelvin](const float* k) { return k[0] / kelvin + k[1] * kelvin + k[2]; };
    const float* b = kBlue[i];
    c = {rational(kRed[i]), rational(kGreen[i]), ((b[0] * kelvin + b[1]) * kelvin + b[2]) * kelvin + b[3]};
  }
  return clip ? glm::max(c, 0.0f) : c;
}

Vec4 table_lookup(const CurveTable& table, float x) {
  const std::vector<Vec4>& values = table.values;
  const int last = int(values.size()) - 1;
  if (last < 1) return last == 0 ? values[0] : Vec4(0.0f);
  if (table.extrapolate && x < 0.0f) return values[0] + (values[0] - values[1]) * (-x * last);
  if (table.extrapolate && x > 1.0f) return values[last] + (values[last] - values[last - 1]) * ((x - 1.0f) * last);
  const float position = x > 0.0f ? std::min(x, 1.0f) * last : 0.0f;  // NaN becomes 0
  const int i = int(position);
  const float t = position - i;
  return table.interpolate && t > 0.0f ? (1.0f - t) * values[i] + t * values[i + 1] : values[i];
}

}  // namespace ajar::nodes
