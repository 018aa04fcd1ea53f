#include "shading/functions/patterns.h"

#include <algorithm>
#include <cmath>

#include "shading/functions/color_functions.h"
#include "shading/functions/noise.h"

namespace ajar::nodes {

float wave(const WaveParameters& w, Vec3 p) {
  p = (p + 0.000001f) * 0.999999f;  // faces at integer coordinates stay in one band
  const Vec3 place = p;
  float phase;
  if (w.rings) {
    if (w.axis != WaveAxis::All) p[int(w.axis)] = 0.0f;
    phase = 20.0f * glm::length(p);
  } else {
    phase = w.axis == WaveAxis::All ? 10.0f * (p.x + p.y + p.z) : 20.0f * p[int(w.axis)];
  }
  phase += w.phase;
  if (w.distortion != 0.0f) {
    phase += w.distortion *
             (2.0f * normalized_fbm(place * w.detail_scale, w.detail + 1.0f, saturate(w.detail_roughness)) - 1.0f);
  }
  const float turns = phase / (2.0f * kPi);
  switch (w.profile) {
    case WaveProfile::Sine: return 0.5f + 0.5f * std::sin(phase - 0.5f * kPi);
    case WaveProfile::Saw: return turns - std::floor(turns);
    case WaveProfile::Triangle: return 2.0f * std::abs(turns - std::floor(turns + 0.5f));
  }
  return 0.0f;
}

Color magic(Vec3 p, float scale, int depth, float distortion) {
  for (int i = 0; i < 3; ++i) p[i] = std::fmod(p[i], 2.0f * kPi);
  Vec3 v(std::sin((p.x + p.y + p.z) * 5.0f * scale), std::cos((-p.x + p.y - p.z) * 5.0f * scale),
         -std::cos((-p.x - p.y + p.z) * 5.0f * scale));
  // Each step replaces one component by the sine or cosine of a signed sum of all three components.
  struct Step {
    int target;
    float (*function)(float);
    float sign;
    Vec3 signs;
  };
  constexpr auto sine = [](float x) { return std::sin(x); };
  constexpr auto cosine = [](float x) { return std::cos(x); };
  static const Step kSteps[] = {{1, cosine, -1, {1, -1, 1}},  {0, cosine, 1, {1, -1, -1}}, {2, sine, 1, {-1, -1, -1}},
                                {0, cosine, -1, {-1, 1, -1}}, {1, sine, -1, {-1, 1, 1}},   {1, cosine, -1, {-1, 1, 1}},
                                {0, cosine, 1, {1, 1, 1}},    {2, sine, 1, {1, 1, -1}},    {0, cosine, -1, {-1, -1, 1}},
                                {1, sine, -1, {1, -1, 1}}};
  if (depth > 0) v *= distortion;
  for (int i = 0; i < std::min(depth, 10); ++i)
    v[kSteps[i].target] = distortion * kSteps[i].sign * kSteps[i].function(glm::dot(kSteps[i].signs, v));
  if (distortion != 0.0f) v /= 2.0f * distortion;
  return 0.5f - v;
}

namespace {

/// A hash of an integer to [0, 1], the one of Blender's Brick Texture.
float brick_noise(uint32_t n) {
  n = (n + 1013u) & 0x7fffffffu;
  n ^= n >> 13;
  n = (n * (n * n * 60493u + 19990303u) + 1376312589u) & 0x7fffffffu;
  return 0.5f * (float(n) / 1073741824.0f);
}

int whole(float x) { return x == x ? int(std::clamp(std::floor(x), -2e9f, 2e9f)) : 0; }

}  // namespace

Vec2 brick(const BrickParameters& b, Vec3 p) {
  const int row = whole(p.y / b.row_height);
  float width = b.width, shift = 0.0f;
  if (b.offset_frequency != 0 && b.squash_frequency != 0) {
    if (row % b.squash_frequency == 0) width *= b.squash;
    if (row % b.offset_frequency == 0) shift = width * b.offset;
  }
  const int column = whole((p.x + shift) / width);
  const float x = p.x + shift - width * float(column), y = p.y - b.row_height * float(row);
  const float tint = saturate(brick_noise((uint32_t(row) << 16) + (uint32_t(column) & 0xffffu)) + b.bias);
  const float to_edge = std::min(std::min(x, y), std::min(width - x, b.row_height - y));
  if (to_edge >= b.mortar_size) return {tint, 0.0f};
  if (b.mortar_smooth == 0.0f) return {tint, 1.0f};
  const float depth = 1.0f - to_edge / b.mortar_size;
  const float t = saturate(depth / b.mortar_smooth);
  return {tint, depth < b.mortar_smooth ? t * t * (3.0f - 2.0f * t) : 1.0f};
}

// The colour matching functions of the CIE 1931 observer, from 380 nm in steps of 5 nm.
constexpr int kObserverCount = 81;
constexpr float kObserver[kObserverCount][3] = {{0.0014f, 0, 0.0065f},
                                                {0.0022f, 0.0001f, 0.0105f},
                                                {0.0042f, 0.0001f, 0.0201f},
                                                {0.0076f, 0.0002f, 0.0362f},
                                                {0.0143f, 0.0004f, 0.0679f},
                                                {0.0232f, 0.0006f, 0.1102f},
                                                {0.0435f, 0.0012f, 0.2074f},
                                                {0.0776f, 0.0022f, 0.3713f},
                                                {0.1344f, 0.004f, 0.6456f},
                                                {0.2148f, 0.0073f, 1.0391f},
                                                {0.2839f, 0.0116f, 1.3856f},
                                                {0.3285f, 0.0168f, 1.623f},
                                                {0.3483f, 0.023f, 1.7471f},
                                                {0.3481f, 0.0298f, 1.7826f},
                                                {0.3362f, 0.038f, 1.7721f},
                                                {0.3187f, 0.048f, 1.7441f},
                                                {0.2908f, 0.06f, 1.6692f},
                                                {0.2511f, 0.0739f, 1.5281f},
                                                {0.1954f, 0.091f, 1.2876f},
                                                {0.1421f, 0.1126f, 1.0419f},
                                                {0.0956f, 0.139f, 0.813f},
                                                {0.058f, 0.1693f, 0.6162f},
                                                {0.032f, 0.208f, 0.4652f},
                                                {0.0147f, 0.2586f, 0.3533f},
                                                {0.0049f, 0.323f, 0.272f},
                                                {0.0024f, 0.4073f, 0.2123f},
                                                {0.0093f, 0.503f, 0.1582f},
                                                {0.0291f, 0.6082f, 0.1117f},
                                                {0.0633f, 0.71f, 0.0782f},
                                                {0.1096f, 0.7932f, 0.0573f},
                                                {0.1655f, 0.862f, 0.0422f},
                                                {0.2257f, 0.9149f, 0.0298f},
                                                {0.2904f, 0.954f, 0.0203f},
                                                {0.3597f, 0.9803f, 0.0134f},
                                                {0.4334f, 0.995f, 0.0087f},
                                                {0.5121f, 1, 0.0057f},
                                                {0.5945f, 0.995f, 0.0039f},
                                                {0.6784f, 0.9786f, 0.0027f},
                                                {0.7621f, 0.952f, 0.0021f},
                                                {0.8425f, 0.9154f, 0.0018f},
                                                {0.9163f, 0.87f, 0.0017f},
                                                {0.9786f, 0.8163f, 0.0014f},
                                                {1.0263f, 0.757f, 0.0011f},
                                                {1.0567f, 0.6949f, 0.001f},
                                                {1.0622f, 0.631f, 0.0008f},
                                                {1.0456f, 0.5668f, 0.0006f},
                                                {1.0026f, 0.503f, 0.0003f},
                                                {0.9384f, 0.4412f, 0.0002f},
                                                {0.8544f, 0.381f, 0.0002f},
                                                {0.7514f, 0.321f, 0.0001f},
                                                {0.6424f, 0.265f, 0},
                                                {0.5419f, 0.217f, 0},
                                                {0.4479f, 0.175f, 0},
                                                {0.3608f, 0.1382f, 0},
                                                {0.2835f, 0.107f, 0},
                                                {0.2187f, 0.0816f, 0},
                                                {0.1649f, 0.061f, 0},
                                                {0.1212f, 0.0446f, 0},
                                                {0.0874f, 0.032f, 0},
                                                {0.0636f, 0.0232f, 0},
                                                {0.0468f, 0.017f, 0},
                                                {0.0329f, 0.0119f, 0},
                                                {0.0227f, 0.0082f, 0},
                                                {0.0158f, 0.0057f, 0},
                                                {0.0114f, 0.0041f, 0},
                                                {0.0081f, 0.0029f, 0},
                                                {0.0058f, 0.0021f, 0},
                                                {0.0041f, 0.0015f, 0},
                                                {0.0029f, 0.001f, 0},
                                                {0.002f, 0.0007f, 0},
                                                {0.0014f, 0.0005f, 0},
                                                {0.001f, 0.0004f, 0},
                                                {0.0007f, 0.0002f, 0},
                                                {0.0005f, 0.0002f, 0},
                                                {0.0003f, 0.0001f, 0},
                                                {0.0002f, 0.0001f, 0},
                                                {0.0002f, 0.0001f, 0},
                                                {0.0001f, 0, 0},
                                                {0.0001f, 0, 0},
                                                {0.0001f, 0, 0},
                                                {0, 0, 0}};

Color wavelength(float nanometres, bool clip) {
  const float place = (nanometres - 380.0f) / 5.0f;
  if (!(place >= 0.0f && place < float(kObserverCount - 1))) return Color(0.0f);
  const int i = int(place);
  const float t = place - float(i);
  Color xyz;
  for (int k = 0; k < 3; ++k) xyz[k] = (1.0f - t) * kObserver[i][k] + t * kObserver[i + 1][k];
  const Color c = xyz_to_rgb(xyz) / 2.52f;  // this scale keeps all components below 1
  return clip ? glm::max(c, 0.0f) : c;
}

}  // namespace ajar::nodes
